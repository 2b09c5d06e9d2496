//! The widths by which the norms of a cost are rounded.

use super::cost_names::CostPoint;
use bracketry_native::{Function, Workspace};

/// The width of a solution, as a share of the typical size of a norm: it changes a norm by less than this share of its size.
pub(crate) const FINEST_ROUNDING: f64 = 1e-5;

/// Widths of the norms of a cost.
#[derive(Clone)]
pub(super) struct Widths {
    /// Typical size of every norm.
    sizes: Vec<f64>,
    /// What the widths are of them in values of the cost; 0: the norms are exact.
    share: f64,
    /// Σ c (∂r/∂v)² of every norm for every variable v.
    slopes: Option<Function>,
}

impl Widths {
    /// For norms with these slopes, exact at first.
    pub(super) fn new(count: usize, slopes: Option<Function>) -> Self {
        Self { sizes: vec![1.0; count], share: 0.0, slopes }
    }

    pub(super) fn are_none(&self) -> bool {
        self.sizes.is_empty()
    }

    /// Finds the sizes of the norms from those of the variables.
    pub(super) fn measure(&mut self, at: CostPoint<'_>, sizes: &[f64]) {
        let Some(slopes) = &self.slopes else { return };
        let arguments: Vec<f64> = at.x.iter().chain(at.u).chain([&at.t]).chain(at.r).copied().collect();
        let mut out = vec![0.0; self.sizes.len() * sizes.len()];
        slopes.call(&arguments, &mut Workspace::default(), &mut out);
        for (size, slopes) in self.sizes.iter_mut().zip(out.chunks(sizes.len())) {
            let square: f64 = slopes.iter().zip(sizes).map(|(slope, s)| slope * s * s).sum();
            *size = if square > 0.0 && square.is_finite() { square.sqrt() } else { 1.0 };
        }
    }

    pub(super) fn set_share(&mut self, share: f64) {
        self.share = share;
    }

    /// Of values.
    pub(super) fn of_values(&self) -> impl Iterator<Item = f64> + '_ {
        self.sizes.iter().map(|size| self.share * size)
    }

    /// Of derivatives, which exact norms do not have everywhere.
    pub(super) fn of_derivatives(&self) -> impl Iterator<Item = f64> + '_ {
        self.sizes.iter().map(|size| self.share.max(FINEST_ROUNDING) * size)
    }
}
