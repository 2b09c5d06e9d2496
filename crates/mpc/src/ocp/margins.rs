//! Margins by which a plan stays within its bounds.

/// How far within its bounds a plan is to stay, by the number of intervals ahead: what is not foreseen adds up. Soft bounds keep their
/// weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Margins {
    /// For the grid points 0 … N, a margin per state, each in its unit; beyond the last row that row holds. None when empty.
    pub states: Vec<Vec<f64>>,
    /// For every path constraint, a margin per grid point 0 … N, in its unit; none where a row is missing.
    pub path: Vec<Vec<f64>>,
}
