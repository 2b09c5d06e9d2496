//! An interval of the grid.

/// One interval: its start, its length, the number of integration steps over it, and the input held there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval<'a> {
    /// Time at the start, s.
    pub(crate) t: f64,
    /// Length, s.
    pub(crate) dt: f64,
    /// Number of integration steps.
    pub(crate) substeps: usize,
    /// The input.
    pub(crate) u: &'a [f64],
}

impl Interval<'_> {
    /// Length of an integration step, s.
    pub(crate) fn step(&self) -> f64 {
        self.dt / self.substeps as f64
    }

    /// Start times of the integration steps, s.
    pub(super) fn times(&self) -> impl Iterator<Item = f64> + use<> {
        let (t, h) = (self.t, self.step());
        (0..self.substeps).map(move |step| t + step as f64 * h)
    }
}
