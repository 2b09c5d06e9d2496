//! Limits of screening, selection and verdict. Shares are of the excess of the sum of squares over that of noise unless they say
//! otherwise, sizes are root mean squares in units of the noise.

// Alarm and motion

/// Fewest samples of a column in a window for which low and high frequencies can be told apart.
pub(super) const FEWEST_SPECTRUM_SAMPLES: usize = 12;
/// Least standard deviation of the noise, relative to the estimate from the column itself. Smaller residuals, of data without noise,
/// may be the inexactness of the simulation.
pub(super) const LEAST_NOISE: f64 = 0.2;

/// A column holds motion if nine tenths of its values spread more than this many times as far as its noise alone would.
pub(super) const MOTION_SPREAD: f64 = 1.5;
/// Nine tenths of a normal variable lie within this many standard deviations around its mean, to both sides.
pub(super) const NINE_TENTHS: f64 = 1.645;

/// Standard deviations of the noise of two columns that differ by more than this factor more than their estimates do weigh the columns
/// wrongly; one that differs from its estimate by this factor is told of.
pub(super) const NOISE_OFF: f64 = 1.5;

/// Curves take the place of straight lines if they leave at most this share of the excess.
pub(super) const CURVES_WORTH: f64 = 0.5;
/// Two steps of time are alike if they differ by at most this part.
pub(super) const EVEN_STEPS: f64 = 0.01;

// Periods

/// Frequencies are half a cycle per range of the data apart: between two of them a wave loses step by a quarter of a cycle
/// toward the ends of the data.
pub(super) const STEPS_PER_CYCLE: usize = 2;
/// Most cycles over the range of the data.
pub(super) const MOST_CYCLES: usize = 200;
/// Steps between two neighboring frequencies around a peak. Where a motion turns, a wave pushes longest in one direction, so
/// that the turnings dominate: frequencies a whole cycle apart fit them nearly as well as the true one, and half a cycle
/// is too coarse to tell which crest of the comb is the highest.
pub(super) const FINER_STEPS: usize = 16;
/// Most peaks that are looked at closely.
pub(super) const MOST_REFINED_PEAKS: usize = 24;
/// Most periods that are tried.
pub(super) const MOST_PERIODS: usize = 6;

// Linearized gains

/// Share of a column's response that must be left after the refitted parameters have taken what they can: the square of the
/// sine of its angle to them. Below, it is the rounding of finite differences.
pub(super) const LEAST_ANGLE: f64 = 1e-7;

// Exact fits

/// An amplitude that begins from a secant may leave it by this factor at most: farther out the secant says nothing.
pub(super) const FARTHEST: f64 = 2.0;
/// How often a fit that diverged is restarted, and the factor by which its amplitudes are then nearer to none.
pub(super) const MOST_RETURNS: usize = 2;
pub(super) const NEARER: f64 = 0.25;
/// Share of the model's excess below which, near the noise, the residual of an explanation is its own inexactness: three per
/// cent in amplitude, as no real part follows its law more exactly.
pub(super) const INEXACT: f64 = 1e-3;
/// Residuals with a root mean square below this many times the noise are near it.
pub(super) const NEAR_NOISE: f64 = 1.5;
/// A parameter below this share of its value in the model has taken its term out.
pub(super) const VANISHED: f64 = 0.05;
/// An effect whose amplitudes are below five standard deviations is uncertain; where leaving it out nevertheless costs ten times
/// what these say, the fit without it has stopped elsewhere.
pub(super) const UNCERTAIN: f64 = 25.0;
pub(super) const STOPPED_SHORT: f64 = 10.0;
/// A parameter is far from its nominal value beyond this part of it.
pub(super) const FAR_PARAMETER: f64 = 0.5;

// The pipeline

/// Share of the excess over noise that named causes must explain where structure remains; with less the verdict is that the
/// data are unexplained.
pub(super) const LEAST_EXPLAINED: f64 = 0.5;
/// Lengths of windows, as parts of the longest, with which parameters that are far off start.
pub(super) const SHORTER: [f64; 2] = [0.25, 0.0625];
/// Long windows are worth a search if some pair of candidates promises a residual of at most this many times the noise.
pub(super) const WITHIN_REACH: f64 = 3.0;

// Selection

/// Exact fits are made of single candidates that promise at least this share of what the best one promises.
pub(super) const NEAR_BEST: f64 = 0.5;
/// Most exact fits of singles, and of pairs, per round.
pub(super) const MOST_SINGLE_FITS: usize = 5;
pub(super) const MOST_PAIR_FITS: usize = 3;
/// A cause must take away this share of the excess that is there without it.
pub(super) const LEAST_SHARE: f64 = 0.1;

/// A term of which less than this part is left hides its sign: there is little for friction to resist.
pub(super) const LITTLE_LEFT: f64 = 0.5;

/// Terms that are put against all windows, after a look at a part of them.
pub(super) const SHORTLIST: usize = 25;
/// What terms without a name must take away: this share of the excess that the named causes leave.
pub(super) const SUBSTANTIAL: f64 = 0.2;
/// Beyond the first few, terms alone are fitted exactly if they promise at least this share of what the best one does.
pub(super) const NEAR_BEST_TERM: f64 = 0.8;
/// Most exact fits of terms alone, of terms beside named causes, and of pairs.
pub(super) const MOST_TERMS_ALONE: usize = 8;
pub(super) const MOST_TERMS_BESIDE: usize = 3;
pub(super) const MOST_TERM_PAIRS: usize = 2;

// Rivals and held-out windows

/// Windows that a search or a comparison uses at most.
pub(super) const MOST_WINDOWS: usize = 330;
/// Two explanations differ on data that no fit has seen if the mean difference over windows is this many standard errors:
/// one-sided 1 %.
pub(super) const DIFFERENT: f64 = 2.33;

/// A rival stays if its sum of squares exceeds the chosen one's by less than this many units of scatter.
///
/// If the rival is the truth, at distance d (in standard deviations) from the chosen explanation, the difference is
/// normal with mean −d² and standard deviation 2d. It exceeds 9 with probability Φ(−(d² + 9)/(2d)), at most Φ(−3) = 0.13 %
/// whatever d is: so seldom is the truth left out.
pub(super) const MARGIN: f64 = 9.0;
/// The linearized problem may underrate what an exact fit gains by this factor.
pub(super) const UNDERRATED: f64 = 0.6;
/// What gains beside a cause at least this share of what it gains in its place explains something else.
pub(super) const BESIDE: f64 = 0.5;
/// Most times that a rival takes a cause's place.
pub(super) const MOST_SWAPS: usize = 4;
/// Most exact fits per cause.
pub(super) const MOST_RIVAL_FITS: usize = 8;

// Verdict

/// Standard deviations that some amplitude of a cause must exceed where structure remains, which takes what the cause's
/// shape is not certain of; where only noise is, one will do.
pub(super) const SURE: f64 = 2.0;

/// One-sided level at which a parameter must have left its tolerance.
pub(super) const OUTSIDE_TOLERANCE: f64 = 0.05;

/// Candidates that the report lists.
pub(super) const LISTED_CANDIDATES: usize = 15;
/// Fewest windows that are resampled.
pub(super) const FEWEST_RESAMPLED: usize = 5;

/// The other hold is reported if without any cause it leaves at most this share of the excess.
pub(super) const OTHER_HOLD_WORTH: f64 = 0.5;
/// A delay is half a sampling time if it differs by at most this share of one, or by two standard deviations.
pub(super) const NEAR_HALF_SAMPLE: f64 = 0.05;

/// A run for validation is reported if its residual is this many times that of the fitted data.
pub(super) const MUCH_MORE: f64 = 1.5;

// Units

/// Windows that are looked at.
pub(super) const UNIT_WINDOWS: usize = 8;
/// Another unit must leave at most this share of the excess, without any cause.
pub(super) const UNIT_EXPLAINS: f64 = 0.1;
/// Another unit that leaves this many times as much over as the causes that were named is none.
pub(super) const OUTDONE: f64 = 1.5;
/// Columns that explain the data within this factor of the best one are named with it.
pub(super) const UNITS_ALIKE: f64 = 1.05;
/// A parameter that changes by more than this factor is a sign of a wrong unit.
pub(super) const UNIT_CHANGE: f64 = 2.0;

// Places

/// A velocity below this share of its root mean square counts as near rest.
pub(super) const NEAR_REST: f64 = 0.1;
/// Near rest for this many times as long as a reversal at typical acceleration takes is rest.
pub(super) const LINGERING: f64 = 4.0;
/// Equations with a smaller share of the error are not looked at by acceleration, position and tilt.
pub(super) const LEAST_PLACE_SHARE: f64 = 0.01;
/// Angles by whose sign the error is told apart, per equation.
pub(super) const MOST_ANGLES: usize = 3;
/// Most values over time that the report keeps per equation and stretch.
pub(super) const MOST_VALUES: usize = 500;
