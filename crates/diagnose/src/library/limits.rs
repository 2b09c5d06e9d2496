//! Limits of the library of causes: sizes, and the values that are tried.

// Typical sizes

/// Part of the typical acceleration that an amplitude at its scale makes.
pub(super) const TYPICAL_SHARE: f64 = 0.1;

/// Points taken from all records together, at most.
pub(super) const MOST_POINTS: usize = 2000;
/// A difference quotient is taken over so many samples that differences are this many times the noise, if possible.
pub(super) const CLEAR_OF_NOISE: f64 = 20.0;

/// Delays and lags are tried from half a sampling interval up to this, s.
pub(super) const LONGEST_DELAY: f64 = 0.1;
pub(super) const TIME_TRIALS: usize = 6;
/// A typical offset of a tracked point, m.
pub(super) const SMALL_OFFSET: f64 = 0.01;

// Trials

/// Stribeck velocities are tried between these parts of the velocities in the data.
pub(super) const STRIBECK_RANGE: (f64, f64) = (0.005, 0.5);
pub(super) const STRIBECK_TRIALS: usize = 7;

/// Periods per turn that are tried for a disturbance in the position of a rotation.
pub(super) const RIPPLES_PER_TURN: [f64; 6] = [1.0, 2.0, 4.0, 6.0, 8.0, 12.0];

/// Ratios tried for what turns with two joints; the first is that of a differential.
pub(super) const RATIOS: [f64; 4] = [-1.0, -0.5, 0.5, 1.0];

/// Waves are tried from a quarter over the range of the coordinate up to this many, in powers of two.
pub(super) const MOST_WAVES: i32 = 5;
/// Trials of the speed scale of saturating and fading functions.
pub(super) const SPEED_TRIALS: usize = 4;
