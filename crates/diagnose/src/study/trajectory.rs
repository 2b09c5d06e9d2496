//! A simulated trajectory of a window, with the linear maps along it.

use bracketry_sim::{Path, Tangent};

/// What was simulated last, and the unknowns and the initial state that it belongs to.
#[derive(Default)]
pub(super) struct Trajectory {
    pub(super) path: Path,
    /// By reading, the number of pieces until then.
    pub(super) marks: Vec<usize>,
    /// What the columns would show without filters and offsets, over their noise, column by column.
    pub(super) shown: Vec<f64>,
    /// What the filters of the columns showed at first, over the noise; NaN without a filter.
    pub(super) filter_starts: Vec<f64>,
    /// By reading, angle and spin of a body whose tracked point lies off its center of mass; empty without one.
    pub(super) turns: Vec<(f64, f64)>,
    /// The unknowns and the initial state that it belongs to.
    pub(super) of: Option<(Vec<f64>, Vec<f64>)>,
    /// The linear maps along it, where they have been made.
    pub(super) tangent: Tangent,
    pub(super) mapped: bool,
}

impl Trajectory {
    /// Whether the linear maps along it have been made.
    pub(super) fn is_mapped(&self) -> bool {
        self.mapped
    }

    /// Whether it is that of these unknowns and this initial state.
    pub(super) fn is_of(&self, theta: &[f64], x0: &[f64]) -> bool {
        self.of.as_ref().is_some_and(|of| of.0 == theta && of.1 == x0)
    }

    /// Forgets what it belongs to.
    pub(super) fn forget(&mut self) {
        self.of = None;
        self.mapped = false;
        self.marks.clear();
        self.turns.clear();
    }
}
