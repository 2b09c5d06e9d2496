//! Statistics that the identification shares.

/// 97.5 % point of the normal distribution: half of a 95 % interval in standard deviations.
pub(super) const TWO_SIDED: f64 = 1.959_964;
/// Median of χ² with 6 degrees of freedom.
pub(super) const CHI_SQUARE_MEDIAN: f64 = 5.348;
/// 99.9 % point of χ² with 6 degrees of freedom.
pub(super) const CHI_SQUARE_REJECTED: f64 = 22.458;
