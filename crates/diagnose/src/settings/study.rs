//! Settings of windows and fits.

settings! {
    /// How records are cut into windows and a model is fitted to them.
    StudySettings {
        /// Length of the windows, s; `None`: a sixteenth of the data, or what
        /// [`Study::with_best_windows`](crate::Study::with_best_windows) chooses.
        window: Option<f64> = None,
        /// Names of parameters that keep their values.
        fixed: Vec<String> = Vec::new(),
        /// Most iterations of a fit.
        iterations: usize = 15,
        /// Number and length of windows.
        windows: WindowSettings = WindowSettings::default(),
        /// Priors and ranges of the unknowns.
        priors: PriorSettings = PriorSettings::default(),
        /// Iterations and simulations.
        solver: SolverSettings = SolverSettings::default(),
        /// Comparison of the model's time scale with that of the data.
        time_scale: TimeScaleSettings = TimeScaleSettings::default(),
    }

    /// Number and length of windows.
    WindowSettings {
        /// Fewest samples of a window: ten per state of a mechanical coordinate.
        fewest_samples: usize = 20,
        /// Fewest windows into which the data are cut: the scatter of the estimates is taken from these blocks.
        fewest_windows: f64 = 16.0,
        /// Difference of the mean logarithm of the standard deviations below which two lengths are equal; the longer is taken.
        indifferent: f64 = 0.03,
        /// Longest time constant of a filter of a column, over the length of the windows.
        slowest_filter: f64 = 0.25,
        /// Estimates start the fits with the next length if their standard deviation is below this share of the prior's.
        certain_share: f64 = 0.2,
    }

    /// Priors and ranges of the unknowns.
    PriorSettings {
        /// Standard deviation of a parameter's prior over its nominal value. Weak: it decides only where the data do not.
        parameter: f64 = 0.5,
        /// Standard deviation of the prior of an effect's amplitude over its scale.
        amplitude: f64 = 100.0,
        /// Standard deviation of the prior of an effect's shape over its scale.
        shape: f64 = 2.0,
        /// The same, over its scale, of a coefficient that has only one value: it need not move.
        one_value: f64 = 1e-3,
        /// Standard deviation of the prior of an initial state over its scale: it affects only states that the data do not show.
        state: f64 = 100.0,
        /// A number is not identifiable from the data if its standard deviation exceeds this share of the prior's.
        unidentified_share: f64 = 0.5,
        /// A parameter stays within this factor of its starting value on the sides where the model file has no limit: a refit is
        /// a calibration. Short windows of a model that is far off are explained best by their initial states alone, with
        /// unbounded masses.
        largest_change: f64 = 3.0,
        /// How often the range of a parameter may move to where the fit has come.
        range_moves: i32 = 3,
    }

    /// Iterations and simulations of a fit.
    SolverSettings {
        /// Iterations before a fit may be given up for being too slow: the first ones may have to find out how far to go.
        fewest_iterations: usize = 3,
        /// Relative decrease of the sum of squares that ends an iteration.
        settled_share: f64 = 1e-6,
        /// The same for initial states that the unknowns will move again.
        rough_share: f64 = 1e-2,
        /// Decrease of the sum of squares, in units of the noise, that ends an iteration: a hundredth of one standard deviation's.
        settled_fall: f64 = 1e-2,
        /// Most iterations for an initial state alone.
        state_iterations: usize = 15,
        /// The same where the unknowns will move it again.
        rough_state_iterations: usize = 3,
        /// Initial damping, relative to the diagonal.
        first_damping: f64 = 1e-4,
        /// Smallest damping.
        least_damping: f64 = 1e-9,
        /// Damping of the unknowns at which a step is too short to lower the cost.
        most_damping: f64 = 1e8,
        /// The same of an initial state alone, which is not worth as many simulations.
        most_state_damping: f64 = 1e4,
        /// Step of finite differences over the scale.
        difference_step: f64 = 1e-4,
        /// Step of finite differences in a delay or a lag over the sampling time: the effect of a held input is linear in its
        /// delay within an interval.
        time_step: f64 = 0.05,
        /// Relative and absolute tolerance of the simulations: far below any noise.
        tolerance: (f64, f64) = (1e-6, 1e-8),
        /// Most steps of a simulation between two readings; a window that takes more is given up.
        most_steps: usize = 10_000,
        /// A lag starts this many time constants before a window: `e^-40` of its history remains.
        lag_history: f64 = 40.0,
    }

    /// Comparison of the model's time scale with that of the data.
    TimeScaleSettings {
        /// Windows at whose first sample the model is linearized.
        examined_windows: usize = 8,
        /// A simulation that takes more steps than this between two samples …
        most_steps_per_sample: f64 = 50.0,
        /// … and more than this over all samples is refused: a diagnosis takes about a thousand of them.
        most_steps_in_all: f64 = 50_000.0,
    }
}
