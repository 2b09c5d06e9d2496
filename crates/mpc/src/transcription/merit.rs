//! The merit of a trajectory.

/// The parts of the merit function.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Merit {
    /// Cost and penalties.
    pub(crate) objective: f64,
    /// Sum of |defect|/scale over all intervals and states.
    pub(crate) defects: f64,
    /// Largest |defect|/scale.
    pub(crate) worst_defect: f64,
}

impl Merit {
    pub(crate) fn value(&self, weight: f64) -> f64 {
        self.objective + weight * self.defects
    }
}
