//! Solutions at which the Jacobian has not full rank, by the signs of the equations.

use std::cmp::Ordering;

use bracketry_symbolic::{Expr, Rational};
use nalgebra::DVector;

use crate::algebra::combination::rational_combination;
use crate::operating::elimination::combinations;
use crate::operating::solver::Found;
use crate::operating::trim::Search;

/// Half widths, relative to the size of the point, of the intervals that are looked at for a change of sign.
const HALF_WIDTHS: [f64; 7] = [1e-13, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3, 1e-2];

/// An interval of this width, relative to the size of the point, is a number.
const NARROW: f64 = 4.0 * f64::EPSILON;

/// A value is clearly larger than another from this quotient on.
const CLEARLY: f64 = 100.0;

/// Most passes over the equations: to move a solution of one along the tangents of the others changes these to second order.
const PASSES: usize = 6;

impl Search<'_> {
    /// A solution to which the iterations came near, to full accuracy, and how far it may be from the one that is meant, relative to its size.
    ///
    /// Near a multiple root the equations are smaller than their rounding errors, and with coefficients of very different size steps that
    /// change the solution change nothing that floating point shows. The exact sign of each equation, or of what is left of it beside the
    /// others ([`combinations`]), on a line along which the others do not change encloses the root, and halving the interval finds it. At
    /// a root of even order the derivative changes its sign. Where neither is seen, the point stays, with the width of the interval beyond
    /// which the equation is clearly not 0.
    pub(super) fn located(&mut self, found: &Found) -> (DVector<f64>, f64) {
        let mut z = found.z.clone();
        let mut accuracy: f64 = 0.0;
        for _ in 0..PASSES {
            let before = z.clone();
            accuracy = 0.0;
            let slopes = self.equations.jacobian(&z);
            for c in combinations(&slopes) {
                let expression = self.combination(&c, &z);
                let root = self.root(expression, &z, &c.direction).or_else(|| {
                    let slope = self.slope(expression, &c.direction);
                    self.root(slope, &z, &c.direction)
                });
                match root {
                    Some(root) => z = root,
                    None => accuracy = accuracy.max(self.unseen(expression, &z, &c.direction)),
                }
            }
            let size = 1.0 + z.norm();
            let moved = (&z - &before).norm() / size;
            accuracy = accuracy.max(moved);
            if moved <= NARROW || self.equations.value(&z).iter().any(|v| !v.is_finite()) {
                break;
            }
        }
        (z, accuracy)
    }

    /// The derivative of an expression of the free variables in a direction.
    fn slope(&mut self, expression: Expr, direction: &DVector<f64>) -> Expr {
        let (pool, _) = &mut self.exact;
        let slopes: Vec<Expr> = self.free.iter().map(|&s| pool.diff(expression, s)).collect();
        let weights: Vec<Rational> =
            direction.iter().map(|&d| Rational::try_from(d).unwrap_or(Rational::ZERO)).collect();
        rational_combination(pool, &slopes, &weights)
    }

    /// The point on the line through `z` where the sign of an expression changes; `None` where it is not seen to change nearby.
    fn root(&mut self, expression: Expr, z: &DVector<f64>, direction: &DVector<f64>) -> Option<DVector<f64>> {
        let size = 1.0 + z.norm();
        let at = |t: f64| z + direction * (t * size);
        if self.sign(expression, z) == Some(Ordering::Equal) {
            return Some(z.clone());
        }
        let enclosed = |search: &mut Self, width: &f64| {
            let ends = [-*width, *width].map(|t| search.sign(expression, &at(t)));
            matches!(
                ends,
                [Some(Ordering::Less), Some(Ordering::Greater)] | [Some(Ordering::Greater), Some(Ordering::Less)]
            )
        };
        let width = HALF_WIDTHS.iter().copied().find(|w| enclosed(self, w))?;
        let (mut low, mut high) = (-width, width);
        let left = self.sign(expression, &at(low))?;
        while high - low > NARROW {
            let middle = f64::midpoint(low, high);
            if middle <= low || middle >= high {
                break;
            }
            match self.sign(expression, &at(middle))? {
                Ordering::Equal => return Some(at(middle)),
                sign if sign == left => low = middle,
                _ => high = middle,
            }
        }
        Some(at(f64::midpoint(low, high)))
    }

    /// The smallest of the half widths at whose ends an expression is clearly larger than at `z`, or the largest.
    fn unseen(&mut self, expression: Expr, z: &DVector<f64>, direction: &DVector<f64>) -> f64 {
        let size = 1.0 + z.norm();
        let mut size_at = |t: f64| self.number(expression, &(z + direction * (t * size))).map(f64::abs);
        let Some(here) = size_at(0.0) else { return HALF_WIDTHS[HALF_WIDTHS.len() - 1] };
        let is_clear = |w: &f64| [-*w, *w].into_iter().all(|t| size_at(t).is_some_and(|v| v > CLEARLY * here));
        HALF_WIDTHS.iter().copied().find(is_clear).unwrap_or(HALF_WIDTHS[HALF_WIDTHS.len() - 1])
    }
}
