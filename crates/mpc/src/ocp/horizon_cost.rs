//! The parts of what a trajectory costs.

/// What a trajectory costs over a horizon, without penalties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HorizonCost {
    /// The stage cost, summed over the intervals.
    pub(crate) stage: f64,
    /// The terminal cost.
    pub(crate) terminal: f64,
}

impl HorizonCost {
    /// That of no trajectory.
    pub(crate) const NONE: Self = Self { stage: f64::NAN, terminal: f64::NAN };

    pub(crate) fn total(self) -> f64 {
        self.stage + self.terminal
    }
}
