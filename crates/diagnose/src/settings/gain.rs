//! Settings of predictions, force errors, and intervals.

settings! {
    /// How the gain is measured and intervals are made.
    GainSettings {
        /// Multi-step predictions.
        predictions: PredictionSettings = PredictionSettings::default(),
        /// Equations of motion along data.
        equations: EquationSettings = EquationSettings::default(),
        /// Number of resamples of the windows for an interval.
        resamples: usize = 1000,
        /// An interval narrower than this share of the one that the standard deviation promises is withheld: resampled windows
        /// that all agree on a wrong value do not scatter.
        narrowest_interval: f64 = 0.125,
        /// A number of which one window tells more than this share has the interval of its standard deviation: resamples that leave this
        /// window out tell nothing of it.
        most_of_one_window: f64 = 0.9,
    }

    /// Multi-step predictions on held-out data.
    PredictionSettings {
        /// Number of parts into which the data are split if there are none for validation.
        folds: usize = 4,
        /// Fewest windows of the fit in a held-out part.
        shortest_fold: usize = 2,
        /// Horizons, s; none: the usual ones, or shares of a length that the data give.
        horizons: Vec<f64> = Vec::new(),
        /// The usual horizons, s: those of machines that are sampled often enough and have windows of seconds.
        usual_horizons: Vec<f64> = vec![0.1, 0.5, 1.0],
        /// Windows longer than this many of the longest usual horizon are those of a slow system: the usual shares of the window
        /// replace the usual horizons.
        slow_window: f64 = 10.0,
        /// Fewest samples in a usual horizon.
        fewest_samples: f64 = 2.0,
        /// Shares of the longest stretch that replace the horizons if it is too short for all but the first.
        horizon_shares: Vec<f64> = vec![0.25, 0.5],
        /// Most predictions per horizon: with more, neighbors overlap and add no information.
        most_predictions: usize = 150,
        /// Fewest predictions for a horizon to be reported.
        fewest_predictions: usize = 5,
    }

    /// Equations of motion along data.
    EquationSettings {
        /// Samples per period at the bandwidth: about 48 Hz at 1 kHz. A force error grows with its bandwidth; with this one the
        /// published errors of the EMPS benchmark (Janot, Gautier, and Brunot 2019; filtered differently) are met on both runs.
        samples_per_period: f64 = 21.0,
        /// Largest share of a derivative's size that may be noise of the sensor.
        most_derivative_noise: f64 = 0.02,
        /// States on the right-hand side have this many times the bandwidth of the residual, so that friction stays steep.
        state_bandwidth: f64 = 2.5,
        /// Ratio of the bandwidths that are tried one after the other.
        narrower: f64 = 0.84,
        /// Periods of the bandwidth that are left out at each end, where splines are less accurate.
        lost_periods: f64 = 3.0,
        /// Fewest periods of the bandwidth in a stretch.
        fewest_periods: f64 = 12.0,
        /// Share of the root mean square of ∂f/∂u below which the input hardly acts.
        weak_input: f64 = 0.1,
        /// A switching function below this many standard deviations of its noise cannot be told from zero.
        undecided_sign: f64 = 3.0,
        /// Most signs that are undecided at once: all their combinations are evaluated.
        most_undecided: usize = 6,
    }
}

impl GainSettings {
    /// The defaults with these horizons, s, in ascending order; with the usual ones if there are none.
    pub fn with_horizons(horizons: &[f64]) -> Self {
        let mut horizons = horizons.to_vec();
        horizons.sort_by(f64::total_cmp);
        horizons.dedup();
        GainSettings {
            predictions: PredictionSettings { horizons, ..PredictionSettings::default() },
            ..Self::default()
        }
    }
}
