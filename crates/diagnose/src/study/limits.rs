//! Limits of the fits. They stand deep in the iterations, so that they are constants, gathered here.

/// Fewest samples of a window: ten per state of a mechanical coordinate.
pub(super) const FEWEST_SAMPLES: usize = 20;
/// Fewest windows into which the data are cut: blocks from which the scatter of the estimates is taken.
pub(super) const FEWEST_WINDOWS: f64 = 16.0;
/// Differences of the mean logarithm of the standard deviations below this do not count; the longer window is taken.
pub(super) const INDIFFERENT: f64 = 0.03;
/// Estimates start the fits with windows of the next length if their standard deviation is below this share of the prior's.
pub(super) const CERTAIN_SHARE: f64 = 0.2;

/// Standard deviation of the prior of a parameter over its nominal value. Weak: it decides only where the data do not.
pub(super) const PARAMETER_PRIOR: f64 = 0.5;
/// Standard deviation of the prior of an effect's amplitude over its scale.
pub(super) const AMPLITUDE_PRIOR: f64 = 100.0;
/// Standard deviation of the prior of an effect's shape over its scale.
pub(super) const SHAPE_PRIOR: f64 = 2.0;
/// The same, over its scale, of a coefficient that has one value only: it need not move at all.
pub(super) const ONE_VALUE_PRIOR: f64 = 1e-3;
/// Standard deviation of the prior of an initial state over its scale: only states that the data do not show feel it.
pub(super) const STATE_PRIOR: f64 = 100.0;
/// A number is not identifiable from the data if its standard deviation exceeds this share of the prior's.
pub(super) const UNIDENTIFIED_SHARE: f64 = 0.5;

/// A parameter stays within this factor of the value it comes from, on the sides where the model file has no limit: a refit is a
/// calibration. Windows that are short against the time constants of a model that is wrong by far are explained best by their
/// initial states alone, with masses beyond all bounds.
pub(super) const LARGEST_CHANGE: f64 = 3.0;
/// How often the range of a parameter may move on to where the fit has come.
pub(super) const RANGE_MOVES: i32 = 3;

/// A fall of the sum of squares relative to it that ends an iteration.
pub(super) const SETTLED_SHARE: f64 = 1e-6;
/// The same for initial states that the unknowns will move again.
pub(super) const ROUGH_SHARE: f64 = 1e-2;
/// A fall of the sum of squares (in noise units) that ends an iteration: a hundredth of what one standard deviation is worth.
pub(super) const SETTLED_FALL: f64 = 1e-2;
/// Most iterations for an initial state alone.
pub(super) const STATE_ITERATIONS: usize = 15;
/// Most of them where the unknowns will move it again.
pub(super) const ROUGH_STATE_ITERATIONS: usize = 3;

/// Damping, relative to the diagonal, with which an iteration starts.
pub(super) const FIRST_DAMPING: f64 = 1e-4;
/// Damping never falls below this.
pub(super) const LEAST_DAMPING: f64 = 1e-9;
/// Damping of the unknowns at which a step is too short to lower anything.
pub(super) const MOST_DAMPING: f64 = 1e8;
/// The same of an initial state alone, where another simulation is not worth it earlier.
pub(super) const MOST_STATE_DAMPING: f64 = 1e4;
/// Step of finite differences over the scale.
pub(super) const DIFFERENCE_STEP: f64 = 1e-4;
/// Step of finite differences in a delay or a lag over the sampling time: what a held input does is linear in its delay within an
/// interval.
pub(super) const TIME_STEP: f64 = 0.05;

/// Relative and absolute tolerance of the simulations: far below any noise.
pub(super) const TOLERANCE: (f64, f64) = (1e-6, 1e-8);
/// Most steps of one simulation of a window between two readings; a window that takes more is not worth its time.
pub(super) const MOST_STEPS: usize = 10_000;
/// A lag is started this many time constants before a window: `e^-40` of what was before is left.
pub(super) const LAG_HISTORY: f64 = 40.0;

/// Windows at whose first sample the model is linearized, to compare its time scale with that of the data.
pub(super) const EXAMINED_WINDOWS: usize = 8;
/// Eigenvalues below this share of the largest are zero: motions that go on for ever.
pub(super) const ZERO_EIGENVALUE: f64 = 1e-6;
/// A simulation that takes more steps than this between two samples …
pub(super) const MOST_STEPS_PER_SAMPLE: f64 = 50.0;
/// … and more than this over all samples is not worth its time: a diagnosis takes about a thousand of them.
pub(super) const MOST_STEPS_IN_ALL: f64 = 50_000.0;
