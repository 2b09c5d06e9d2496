//! The bounds that a plan keeps: those of the problem, less their margins.

use super::bounds::Bounds;
use super::problem::Ocp;

impl Bounds {
    /// The bounds, closer by a margin on both sides; the middle where nothing is left.
    pub(crate) fn within(self, margin: f64) -> Self {
        let (min, max) = (self.min + margin, self.max - margin);
        if min <= max {
            return Self { min, max, ..self };
        }
        let middle = f64::midpoint(self.min, self.max);
        Self { min: middle, max: middle, ..self }
    }
}

impl Ocp {
    /// Bounds of state i at grid point k of a plan.
    pub(crate) fn state_bounds_at(&self, k: usize, i: usize) -> Bounds {
        let rows = &self.margins.states;
        let margin = rows.get(k).or(rows.last()).and_then(|row| row.get(i)).copied();
        margin.map_or(self.state_bounds[i], |margin| self.state_bounds[i].within(margin))
    }

    /// Margin of a path constraint at grid point k of a plan.
    pub(crate) fn path_margin(&self, constraint: usize, k: usize) -> f64 {
        let row = self.margins.path.get(constraint);
        row.and_then(|row| row.get(k).or(row.last())).copied().unwrap_or(0.0)
    }
}
