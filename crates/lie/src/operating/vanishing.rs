//! Whether equations vanish where they are small.

use std::cmp::Ordering;

use bracketry_symbolic::{Bindings, Expr, Rational};
use nalgebra::DVector;
use rustc_hash::FxHashMap;

use crate::algebra::combination::rational_combination;
use crate::operating::elimination::{Combination, combinations};
use crate::operating::solver::Found;
use crate::operating::trim::{ROUNDING, Search};

/// Distances, relative to its size, from a point within which an equation changes its sign at a solution: a multiple one is found to lower
/// accuracy, and beside a kink there may be another sign soon.
const CLEAR: [f64; 6] = [1e-7, 1e-5, FAR, 1e-9, 1e-11, 1e-13];

/// The largest of these distances.
const FAR: f64 = 1e-3;

/// A value at a solution is below this part of the values at the largest distance.
const SMALL: f64 = 0.1;

/// Equations change by less than this part of what their slopes give in a direction in which they do not change to first order. It is below
/// the part by which independent equations differ.
const KEPT: f64 = 1e-4;

impl Search<'_> {
    /// Whether all equations vanish there: each, or a [combination](combinations) of them, changes its sign within a short step in a
    /// direction in which those before it do not change, or vanishes exactly, as at a multiple solution. What only tends to 0, as e^−x does,
    /// has one sign. Where signs are not known, the first-order approximation tells.
    pub(super) fn is_solution(&mut self, found: &Found) -> bool {
        let slopes = self.equations.jacobian(&found.z);
        let size = 1.0 + found.z.norm();
        let mut all_small = true;
        // What is left of an equation would hide the sign of those after it: it is taken away first.
        let mut z = found.z.clone();
        let list = combinations(&slopes);
        let vanish = list.iter().enumerate().all(|(k, c)| {
            let value = c.weights.dot(&self.equations.value(&z));
            let (small, vanishes) = self.vanishes(c, &list[..k], &z);
            all_small &= small || value.abs() <= ROUNDING;
            let correction = -value / c.slope;
            if correction.abs() <= ROUNDING * size {
                z.axpy(correction, &c.direction, 1.0);
            }
            vanishes
        });
        vanish || all_small && self.confirmed(found, FAR).is_some()
    }

    /// Whether a combination is small at `z`, beside its values nearby, and whether it vanishes while those before it do not change.
    fn vanishes(&mut self, c: &Combination, before: &[Combination], z: &DVector<f64>) -> (bool, bool) {
        let combination = self.combination(c, z);
        let size = 1.0 + z.norm();
        let f = self.equations.value(z);
        let value = c.weights.dot(&f).abs();
        let beside = |distance: f64| {
            let step = &c.direction * (distance * size);
            [z - &step, z.clone(), z + &step]
        };
        // A jump changes the sign, too, but its values do not become small.
        let [one, _, other] = beside(FAR).map(|z| c.weights.dot(&self.equations.value(&z)).abs());
        let is_small = value <= SMALL * one.max(other);
        let here = self.sign(combination, z);
        let changes_sign = |clear: f64| {
            let [one, _, other] = beside(clear);
            let mut signs = [None; 2];
            for (sign, place) in signs.iter_mut().zip([one, other]) {
                match self.changed(before, &f, &place, clear * size) {
                    Some(change) if change > KEPT => return false,
                    Some(_) => *sign = self.sign(combination, &place),
                    None => {}
                }
            }
            match (signs, here) {
                ([Some(one), Some(other)], _) => is_small && one != other,
                // Beside the end of a domain, as of a root, where slopes change fast: the sign changes as the slope tells.
                ([None, Some(Ordering::Greater)], Some(Ordering::Less))
                | ([Some(Ordering::Less), None], Some(Ordering::Greater)) => is_small,
                (_, Some(_)) => false,
                (_, None) => is_small && c.slope > 0.0 && value <= c.slope * clear * size,
            }
        };
        let vanishes = here == Some(Ordering::Equal) || CLEAR.into_iter().any(changes_sign);
        (is_small, vanishes)
    }

    /// The largest change of equations from their values `f` to those at another place, as a part of what their slopes give for this
    /// distance: beside a kink or the end of a domain, slopes do not tell in which direction equations stay as they are. `None` where they
    /// have no value.
    fn changed(&mut self, list: &[Combination], f: &DVector<f64>, z: &DVector<f64>, distance: f64) -> Option<f64> {
        let change = self.equations.value(z) - f;
        list.iter().filter(|c| c.is_alone() && c.slope > 0.0).try_fold(0.0, |most: f64, c| {
            let part = c.weights.dot(&change).abs() / (c.slope * distance);
            (!part.is_nan()).then_some(most.max(part))
        })
    }

    /// A combination of the equations as one expression.
    pub(super) fn combination(&mut self, c: &Combination, z: &DVector<f64>) -> Expr {
        let (pool, equations) = &mut self.exact;
        let number = |value: f64| Rational::try_from(value).unwrap_or(Rational::ZERO);
        if !c.is_alone() {
            let at: FxHashMap<Expr, Expr> =
                self.free.iter().zip(z.iter()).map(|(&s, &z)| (pool.sym(s), pool.rational(number(z)))).collect();
            if let Some(exact) = c.exact(pool, equations, &self.free, &at) {
                return exact;
            }
        }
        let weights: Vec<Rational> = c.weights.iter().map(|&w| number(w)).collect();
        rational_combination(pool, equations, &weights)
    }

    /// The sign of an expression of the free variables; `None` where it is not known.
    pub(super) fn sign(&mut self, expression: Expr, z: &DVector<f64>) -> Option<Ordering> {
        let values = self.bindings(z)?;
        self.exact.0.constant_sign(expression, &values)
    }

    /// The value of an expression of the free variables, whatever cancels; `None` where it is not known.
    pub(super) fn number(&mut self, expression: Expr, z: &DVector<f64>) -> Option<f64> {
        let values = self.bindings(z)?;
        self.exact.0.constant_value(expression, &values)
    }

    fn bindings(&self, z: &DVector<f64>) -> Option<Bindings> {
        let mut values = Bindings::new();
        for (&s, &z) in self.free.iter().zip(z.iter()) {
            values.bind(s, Rational::try_from(z).ok()?);
        }
        Some(values)
    }
}
