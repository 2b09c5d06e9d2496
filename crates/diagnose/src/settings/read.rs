//! Settings of reading: what is noise, what is a gap, what deserves a warning.

settings! {
    /// What is accepted in a run, and what deserves a warning.
    ReadSettings {
        /// Estimates of noise.
        noise: NoiseSettings = NoiseSettings::default(),
        /// Agreement of columns with each other.
        consistency: ConsistencySettings = ConsistencySettings::default(),
        /// What is no sample.
        repair: RepairSettings = RepairSettings::default(),
        /// What is no measurement.
        outliers: OutlierSettings = OutlierSettings::default(),
        /// What is left out of long runs.
        decimation: DecimationSettings = DecimationSettings::default(),
        /// Largest share of lost entries of a measured column.
        most_lost: f64 = 0.99,
        /// Fewest entries of a measured column that were not lost.
        fewest_known: usize = 20,
        /// A step in time longer than this many usual ones is a gap.
        gap: f64 = 2.5,
        /// Noise above this share of a column's range deserves a warning.
        mostly_noise: f64 = 0.25,
        /// Correlation of neighboring samples of the noise that deserves a warning.
        correlated: f64 = 0.3,
        /// Standard deviation of the steps in time over the step that deserves a warning.
        uneven: f64 = 0.02,
        /// Fewest equal values in a row that count as flat.
        flat_samples: usize = 5,
    }

    /// Estimates of noise from a column itself.
    NoiseSettings {
        /// Smallest noise, as a share of the column's range: no instrument resolves more than 20 bits.
        finest_resolution: f64 = 1.0 / (1 << 20) as f64,
        /// Fewest differences that give a scale.
        fewest_differences: usize = 12,
        /// An order of differences that lowers the estimate by less than this factor is no better than the one before.
        same_scale: f64 = 1.03,
        /// Growth from one distance of samples to twice that, beyond which it is motion and not noise: noise behind a filter of
        /// second order grows by less than 2^1.5, motion in differences of eighth order by up to 2^8.
        motion_growth: f64 = 1.7,
        /// Largest distance, in samples, at which correlated noise is followed.
        farthest_neighbor: usize = 32,
    }

    /// Which samples stand alone, so that they are no measurements.
    OutlierSettings {
        /// An outlier differs from both neighbors by more than this many standard deviations of the noise: white noise does so once in
        /// 10^10 samples.
        beyond_noise: f64 = 8.0,
        /// And by more than this many times the largest difference of neighboring samples around it.
        beyond_motion: f64 = 4.0,
        /// Largest share of the samples of a column; more belong to what is measured, and are kept.
        most: f64 = 0.05,
        /// How many are listed by their times.
        listed: usize = 3,
    }

    /// Which rows of long runs are left out.
    DecimationSettings {
        /// No fewer rows than this are left: the time of a diagnosis grows with them.
        rows: usize = 20_000,
        /// Measurements are on a straight line if they are off it by less than this many times the noise …
        beyond_noise: f64 = 1.2,
        /// … or less than this share of the column's standard deviation.
        share_of_spread: f64 = 0.005,
    }

    /// What is left out of a table, and what is filled.
    RepairSettings {
        /// A number that stands for a lost value is farther from all others than this many times their range and their size.
        sentinel_distance: f64 = 3.0,
        /// Numbers beyond it stand for lost values whatever they are.
        largest_value: f64 = 1e30,
        /// Fewest changes of a column that show how often its sensor reads.
        fewest_readings: usize = 20,
        /// Share of the readings of a slower sensor that are one of its intervals apart: it may show the same value twice.
        regular_readings: f64 = 0.9,
        /// How far a step of a regular clock is from the usual one, over that.
        regular_step: f64 = 0.1,
        /// Share of such steps that makes a clock regular.
        regular_clock: f64 = 0.8,
    }

    /// Agreement of a position with its velocity, and of angles with radians.
    ConsistencySettings {
        /// Number of parts of the run over which displacements are compared.
        displacements: usize = 100,
        /// A displacement counts if it exceeds the noise by this factor.
        significant_displacement: f64 = 5.0,
        /// Smallest correlation of displacements and integrated velocities.
        least_correlation: f64 = 0.7,
        /// Largest deviation of their slope from one, or from that of another unit, that passes as calibration.
        calibration: f64 = 0.15,
        /// More turns than this each way are not likely.
        most_turns: f64 = 5.0,
    }
}
