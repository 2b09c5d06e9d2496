//! The directions in which unit vectors leave σ = 0: `s` such that `σ̇(s) = λ s` with `|s| = 1`, `λ ≥ 0`.
//!
//! These are the fixed points of `s ↦ (κ s + σ̇(s))/|κ s + σ̇(s)|`, which dry friction, being dissipative, makes a contraction
//! for `κ` as large as its influence; Newton's method on the sphere ends the iteration. Where that does not converge, as where a
//! direction merely follows a σ that hardly grows, the directions are turned one after the other ([`relax`]) and are refined again.

use super::dependence::Span;
use super::filippov::Field;
use super::relaxation::relax;
use super::surfaces::{divide, norm};
use bracketry_numerics::linear_equations::solve_vector;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Fixed-point iterations before Newton's.
const FIXED_POINT: usize = 30;
const NEWTON: usize = 20;
/// `σ̇` across `s`, relative to the influence of `s`, at which the direction is known.
const RESIDUAL: f64 = 1e-14;
/// The same where the iterations end, at the rounding of forces far above that influence.
const LAST_RESIDUAL: f64 = 1e-10;

/// The unit vectors that leave.
struct Departure<'a> {
    switches: &'a [usize],
    /// Their components, in order.
    components: Vec<usize>,
    /// By switch, its components among these.
    rows: Vec<Range<usize>>,
}

/// What `σ̇` does at the present directions, by component.
struct Rates {
    all: DVector<f64>,
    /// What is normal to the direction.
    across: DVector<f64>,
    /// `λ = s·σ̇` of the switch.
    radial: Vec<f64>,
    /// Largest entry of `across`.
    residual: f64,
}

/// Solves for the directions of the unit vectors `leaving`, which are held, and writes the field for them; false if
/// there is no solution.
pub(crate) fn depart(field: &mut Field<'_>, (t, x): (f64, &[f64]), leaving: &[usize], dx: &mut [f64]) -> bool {
    let parts = leaving.iter().map(|&i| field.surfaces.parts[i].clone());
    let components: Vec<usize> = parts.clone().flatten().collect();
    let mut first = 0;
    let row = |part: Range<usize>| {
        first += part.len();
        first - part.len()..first
    };
    let rows = parts.map(row).collect();
    let departure = Departure { switches: leaving, components, rows };
    departure.start(field);
    departure.confine(field, (t, x));
    if !field.evaluate((t, x), dx) {
        return false;
    }
    field.surfaces.differentiate(&mut field.system, t, x);
    for &i in leaving {
        fill(field, i, dx);
    }
    let Some(jacobian) = field.influence((t, x), &departure.components, dx) else {
        return false;
    };
    if departure.converge(field, (t, x), (&jacobian, 0.0), dx) {
        return true;
    }
    departure.start(field);
    if !field.evaluate((t, x), dx) {
        return false;
    }
    field.surfaces.differentiate(&mut field.system, t, x);
    let Some(now) = departure.rates(field, dx) else {
        return false;
    };
    let mut s = DVector::from_iterator(now.all.len(), departure.components.iter().map(|&c| field.s[c]));
    relax(&mut s, now.all, &jacobian, &departure.rows);
    departure.components.iter().zip(s.iter()).for_each(|(&c, &s)| field.s[c] = s);
    departure.converge(field, (t, x), (&jacobian, LAST_RESIDUAL), dx)
}

impl Departure<'_> {
    /// Refines the directions from where they are, for their influence on σ̇; false if they do not converge, at last to the residual
    /// `accepted`.
    fn converge(
        &self,
        field: &mut Field<'_>,
        (t, x): (f64, &[f64]),
        (jacobian, accepted): (&DMatrix<f64>, f64),
        dx: &mut [f64],
    ) -> bool {
        let size = jacobian.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let mut flipped: Vec<usize> = Vec::new();
        for iteration in 0..FIXED_POINT + NEWTON {
            if !field.evaluate((t, x), dx) {
                return false;
            }
            field.surfaces.differentiate(&mut field.system, t, x);
            let Some(now) = self.rates(field, dx) else {
                return false;
            };
            let known = RESIDUAL * size + 1e-15 * now.all.amax();
            if now.residual <= known {
                // The direction opposite to σ̇ is a fixed point too where `s` has little influence on its own σ̇: flip it, once.
                let backwards = |(a, i): &(usize, usize)| {
                    let rate = field.radial_rate(*i, dx);
                    !flipped.contains(i) && rate < -known && self.own_influence(field, *a, jacobian) > rate
                };
                let switches = self.switches.iter().copied().enumerate();
                let backwards: Vec<usize> = switches.filter(backwards).map(|(_, i)| i).collect();
                if backwards.is_empty() {
                    return true;
                }
                for &i in &backwards {
                    field.s[field.surfaces.parts[i].clone()].iter_mut().for_each(|s| *s = -*s);
                }
                flipped.extend(backwards);
                continue;
            }
            if iteration + 1 == FIXED_POINT + NEWTON {
                return now.residual <= accepted * size;
            }
            // Close to the solution: Newton's step within the sphere.
            let newton = now.residual < 1e-2 * size || iteration >= FIXED_POINT;
            let step = if newton { self.step_on_sphere(field, jacobian, &now, size) } else { None };
            if !self.turn(field, step.as_ref(), &now.all, size) {
                return false;
            }
        }
        false
    }

    /// The influence `sᵀ J s` of a direction on its own radial rate.
    fn own_influence(&self, field: &Field<'_>, at: usize, jacobian: &DMatrix<f64>) -> f64 {
        let rows = &self.rows[at];
        let s = |a: usize| field.s[self.components[a]];
        rows.clone().map(|a| rows.clone().map(|b| s(a) * jacobian[(a, b)] * s(b)).sum::<f64>()).sum()
    }

    /// Starts from directions within the unit ball.
    fn start(&self, field: &mut Field<'_>) {
        if self.components.iter().any(|&c| !field.s[c].is_finite()) {
            self.components.iter().for_each(|&c| field.s[c] = 0.0);
        }
        for &i in self.switches {
            let s = &mut field.s[field.surfaces.parts[i].clone()];
            let size = norm(s).max(1.0);
            divide(s, size);
        }
    }

    /// Keeps the directions to what the sticking switches leave free.
    fn confine(&self, field: &mut Field<'_>, (t, x): (f64, &[f64])) {
        if field.forces.sticking.is_empty() {
            return;
        }
        field.surfaces.differentiate(&mut field.system, t, x);
        let mut span = Span::default();
        for &c in &field.forces.sticking {
            span.add(&field.surfaces, c);
        }
        for &i in self.switches {
            let part = field.surfaces.parts[i].clone();
            span.confine(&field.surfaces, i, &mut field.s[part]);
        }
    }

    /// None where they are not finite.
    fn rates(&self, field: &Field<'_>, dx: &[f64]) -> Option<Rates> {
        let k = self.components.len();
        let rates = DVector::from_iterator(k, self.components.iter().map(|&c| field.surfaces.rate(c, dx)));
        if !rates.iter().all(|r| r.is_finite()) {
            return None;
        }
        let (mut across, mut radial, mut residual) = (rates.clone(), vec![0.0; k], 0.0f64);
        for (&i, rows) in self.switches.iter().zip(&self.rows) {
            let rate = field.radial_rate(i, dx);
            for a in rows.clone() {
                across[a] -= rate * field.s[self.components[a]];
                radial[a] = rate;
                residual = residual.max(across[a].abs());
            }
        }
        Some(Rates { all: rates, across, radial, residual })
    }

    /// Takes a step within the sphere, or one of the fixed-point iteration; false where a direction is lost.
    fn turn(&self, field: &mut Field<'_>, step: Option<&DVector<f64>>, rates: &DVector<f64>, size: f64) -> bool {
        for (&i, rows) in self.switches.iter().zip(&self.rows) {
            let s = &mut field.s[field.surfaces.parts[i].clone()];
            for (s, a) in s.iter_mut().zip(rows.clone()) {
                match step {
                    Some(step) => *s += step[a],
                    None => *s = size * *s + rates[a],
                }
            }
            let length = norm(s);
            if length == 0.0 || !length.is_finite() {
                return false;
            }
            divide(s, length);
        }
        true
    }

    /// The step of Newton's method for `P σ̇ = 0`: `(P J P − λ) δ = −P σ̇`, `P = 1 − s sᵀ`.
    fn step_on_sphere(
        &self,
        field: &Field<'_>,
        jacobian: &DMatrix<f64>,
        now: &Rates,
        size: f64,
    ) -> Option<DVector<f64>> {
        let k = self.components.len();
        let mut projection = DMatrix::<f64>::identity(k, k);
        let mut along = DMatrix::<f64>::zeros(k, k);
        for rows in &self.rows {
            for a in rows.clone() {
                for b in rows.clone() {
                    along[(a, b)] = field.s[self.components[a]] * field.s[self.components[b]];
                }
            }
        }
        projection -= &along;
        let mut matrix = &projection * jacobian * &projection - along * size.max(f64::MIN_POSITIVE);
        for a in 0..k {
            // Directions without influence follow σ̇ as slowly as |σ| grows.
            matrix[(a, a)] -= now.radial[a].max(0.0) + 1e-13 * size;
        }
        let step = solve_vector(matrix, &-&now.across)?;
        step.iter().all(|v| v.is_finite() && v.abs() < 1.0).then_some(step)
    }
}

/// Completes the direction of a switch to unit length along its `σ̇`.
fn fill(field: &mut Field<'_>, switch: usize, dx: &[f64]) {
    let part = field.surfaces.parts[switch].clone();
    let rates: Vec<f64> = part.clone().map(|c| field.surfaces.rate(c, dx)).collect();
    let s = &mut field.s[part];
    let (rate, size) = (norm(&rates), norm(s));
    let missing = 1.0 - size.powi(2);
    if rate == 0.0 || !rate.is_finite() {
        // Nothing tells where to: any direction, or the present one.
        if size > 0.0 {
            divide(s, size);
        } else {
            s[0] = 1.0;
        }
        return;
    }
    if missing <= 0.0 {
        return;
    }
    let along: f64 = s.iter().zip(&rates).map(|(s, r)| s * r / rate).sum();
    let length = (along * along + missing).sqrt() - along;
    for (s, r) in s.iter_mut().zip(&rates) {
        *s += length * r / rate;
    }
}
