//! Settings of the library of causes.

settings! {
    /// Typical sizes of effects, and the values at which they are tried.
    LibrarySettings {
        /// Share of the typical acceleration that an amplitude at its scale causes.
        typical_share: f64 = 0.1,
        /// Most points taken from all records together: enough for typical sizes.
        most_points: usize = 2000,
        /// A difference quotient spans so many samples that differences are this many times the noise, if possible.
        clear_of_noise: f64 = 20.0,
        /// Delays and lags are tried from half a sampling interval up to this, s.
        longest_delay: f64 = 0.1,
        /// Number of delays and lags that are tried.
        time_trials: usize = 6,
        /// Fits of hidden masses start from frequencies up to this many cycles per interval between samples.
        highest_frequency: f64 = 0.08,
        /// Number of these frequencies.
        frequency_trials: usize = 4,
        /// Typical offset of a tracked point, m.
        small_offset: f64 = 0.01,
        /// Stribeck velocities are tried between these shares of the largest velocity in the data.
        stribeck_range: (f64, f64) = (0.005, 0.5),
        /// Number of Stribeck velocities that are tried.
        stribeck_trials: usize = 7,
        /// Periods per turn that are tried for a disturbance in the position of a rotation.
        ripples_per_turn: Vec<f64> = vec![1.0, 2.0, 4.0, 6.0, 8.0, 12.0],
        /// Ratios that are tried for a part that turns with two joints; the first is that of a differential.
        joint_ratios: Vec<f64> = vec![-1.0, -0.5, 0.5, 1.0],
        /// Waves are tried from a quarter over the range of the coordinate up to two to this power, in powers of two.
        most_waves: i32 = 5,
        /// Number of speed scales that are tried for saturating and fading functions.
        speed_trials: usize = 4,
    }
}
