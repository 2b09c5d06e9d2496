//! Limits of reading: what is noise, what is a gap, what is worth a warning.

// Values and times

/// Largest share of lost entries of a measured column.
pub(super) const MOST_LOST: f64 = 0.5;
/// Sizes of columns whose squares, and those of their noise, are numbers.
pub(super) const SIZES: std::ops::Range<f64> = 1e-100..1e100;

/// A step in time longer than this many usual ones is a gap.
pub(super) const GAP: f64 = 2.5;

/// Highest derivative that is taken from a spline; the next one jumps.
pub(super) const HIGHEST_DERIVATIVE: u32 = 2;

/// Files, and arrays in them, larger than this are refused.
pub(super) const MOST_BYTES: u64 = 512 << 20;
/// The header of an array of numbers opens one brace and one parenthesis. The parser of headers tries every reading of what
/// is nested, which takes for ever on what is nested deeply.
pub(super) const MOST_PARENTHESES: usize = 6;

// Noise

/// Smallest noise, as a share of the column's range: no instrument resolves more than 20 bits.
pub(super) const FINEST_RESOLUTION: f64 = 1.0 / (1 << 20) as f64;
/// Orders of differences, from the least spread to the least influenced by the motion.
pub(super) const DIFFERENCE_ORDERS: [usize; 5] = [3, 4, 5, 6, 8];
pub(super) const HIGHEST_DIFFERENCE: usize = 8;
/// Fewest differences that give a scale.
pub(super) const FEWEST_DIFFERENCES: usize = 12;
/// An order that lowers the estimate by less than this share is no better than the one before.
pub(super) const SAME_SCALE: f64 = 1.03;
/// Growth from one distance of samples to twice that, beyond which it is motion and no noise: noise behind a filter of second
/// order grows by less than 2^1.5, motion in differences of eighth order by up to 2^8.
pub(super) const MOTION_GROWTH: f64 = 1.7;
/// Largest distance, in samples, at which correlated noise is followed.
pub(super) const FARTHEST_NEIGHBOR: usize = 32;

// Warnings

/// Noise above this share of the range.
pub(super) const MOSTLY_NOISE: f64 = 0.25;
/// Correlation of neighbors that is worth a word.
pub(super) const CORRELATED: f64 = 0.3;
/// Standard deviation of the steps in time over the step that is worth a word.
pub(super) const UNEVEN: f64 = 0.02;
/// Shortest row of equal values that counts as flat.
pub(super) const FLAT_SAMPLES: usize = 5;

/// Number of parts of the run over which displacements are compared.
pub(super) const DISPLACEMENTS: usize = 100;
/// A displacement counts where it exceeds the noise by this factor.
pub(super) const SIGNIFICANT_DISPLACEMENT: f64 = 5.0;
/// Smallest correlation of what one column says and what the others say.
pub(super) const LEAST_CORRELATION: f64 = 0.7;
/// Largest deviation of the slope from one, or from that of another unit, that passes as calibration.
pub(super) const CALIBRATION: f64 = 0.15;
/// More than this many turns in each direction are not likely.
pub(super) const MOST_TURNS: f64 = 5.0;
