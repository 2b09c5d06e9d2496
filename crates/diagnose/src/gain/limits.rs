//! Limits of predictions, force errors and intervals.

// Held-out parts and horizons

/// Parts into which the data are split where there are none for validation.
pub(super) const FOLDS: usize = 4;
/// Shortest stretch that is held out in windows of the fit.
pub(super) const SHORTEST_FOLD: usize = 2;

/// Horizons in seconds, where the data allow.
pub(super) const HORIZONS: [f64; 3] = [0.1, 0.5, 1.0];
/// Shares of the longest stretch that stand in where it is too short for all of [`HORIZONS`] but the first.
pub(super) const HORIZON_SHARES: [f64; 2] = [0.25, 0.5];
/// Most predictions per horizon: with more, neighbors overlap and tell the same.
pub(super) const MOST_PREDICTIONS: usize = 150;
/// Fewest predictions for a horizon to be reported.
pub(super) const FEWEST_PREDICTIONS: usize = 5;

// Intervals

/// Resamples.
pub(crate) const RESAMPLES: usize = 1000;
/// Ends of the interval of 95 %.
pub(super) const INTERVAL_ENDS: [f64; 2] = [0.025, 0.975];

// Equations along data

/// Samples per period of the fastest motion that counts: about 48 Hz at 1 kHz. A force error grows with its bandwidth; with this one the
/// published errors of the EMPS benchmark (Janot, Gautier and Brunot 2019; filtered differently) are met on both of its runs.
pub(super) const SAMPLES_PER_PERIOD: f64 = 21.0;
/// Most of the acceleration's size that may be noise of the sensor.
pub(super) const MOST_DERIVATIVE_NOISE: f64 = 0.02;
/// The states on the right-hand side are smoothed less than the residual, by this factor, so that friction stays steep.
pub(super) const STATE_BANDWIDTH: f64 = 2.5;
/// Ratio of the bandwidths that are tried one after the other.
pub(super) const NARROWER: f64 = 0.84;
/// Periods of the bandwidth that are left out at each end, where splines are less exact.
pub(super) const LOST_PERIODS: f64 = 3.0;
/// Fewest periods of the bandwidth in a stretch.
pub(super) const FEWEST_PERIODS: f64 = 12.0;

/// Share of the root mean square of ∂f/∂u below which the input hardly acts.
pub(super) const WEAK_INPUT: f64 = 0.1;

// Rest

/// A switching function below this many standard deviations of its noise cannot be told from zero.
pub(super) const UNDECIDED_SIGN: f64 = 3.0;
/// Most signs that are undecided at once: more corners are not looked at.
pub(super) const MOST_UNDECIDED: usize = 6;
