//! Stability of the zero dynamics.

use std::cmp::Ordering;

use bracketry_symbolic::{Bindings, Expr, Pool, Rational, Real, Symbol};
use nalgebra::DMatrix;

use crate::algebra::field::VectorFields;
use crate::answer::Answer;
use crate::evidence::Evidence;
use crate::feedback::critical::Critical;
use crate::feedback::zero_dynamics::{Set, ZeroDynamics};
use crate::linear::clusters::{clusters, decay};
use crate::linear::matrix::Matrix;
use crate::linear::spectrum::{MAX_IRRATIONAL, Spectrum};
use crate::linear::taylor::reals;
use crate::reason::{MinimumPhaseReason, Reason};
use bracketry_numerics::eigen::{balance, eigenvalues};

/// Whether the zero dynamics are asymptotically stable at an equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct MinimumPhase {
    /// The verdict.
    pub holds: Answer<bool>,
    /// What it rests on; absent for an unknown verdict, which has its own reason.
    pub reason: Option<MinimumPhaseReason>,
    /// Eigenvalues of the linearization, real and imaginary parts; empty if there is no equilibrium or no coordinate.
    pub eigenvalues: Vec<(f64, f64)>,
}

impl ZeroDynamics {
    /// Whether the equilibrium at `point` (one constant expression per state of `fields`) is
    /// asymptotically stable on the set.
    pub fn minimum_phase(
        &self,
        pool: &mut Pool,
        fields: &VectorFields,
        point: &[Expr],
        evidence: &mut Evidence,
    ) -> MinimumPhase {
        let decided = |holds: bool, reason, eigenvalues| MinimumPhase {
            holds: Answer::Known(holds),
            reason: Some(reason),
            eigenvalues,
        };
        let open = |reason| MinimumPhase { holds: Answer::Unknown(reason), reason: None, eigenvalues: Vec::new() };
        if self.states.is_empty() {
            return decided(true, MinimumPhaseReason::NoMotion, Vec::new());
        }
        if self.inputs.iter().any(Option::is_none) {
            return open(Reason::FreeInputs);
        }
        let mut conditions = self.equations.clone();
        for &(s, value) in &self.solved {
            let x = pool.sym(s);
            conditions.push(pool.sub(x, value));
        }
        let set = Set::of(fields, point, self.states.clone());
        for c in conditions {
            match set.vanishes_at_point(pool, c, evidence) {
                Some(true) => {}
                Some(false) => return open(Reason::NoEquilibrium),
                None => return open(Reason::EquilibriumOpen),
            }
        }
        let mut divergence = pool.int(0);
        for (&z, &e) in self.states.iter().zip(&self.equations) {
            let d = pool.diff(e, z);
            divergence = pool.add(divergence, d);
        }
        if fields.vanishes(pool, divergence, evidence) == Ok(true) && self.states.len() > 1 {
            // Liouville: an attracting equilibrium would make volumes shrink.
            let eigenvalues = self.eigenvalues(pool, &set, evidence).unwrap_or_default();
            return decided(false, MinimumPhaseReason::PreservesVolume, eigenvalues);
        }
        if let &[z] = self.states.as_slice() {
            return self.scalar(pool, &set, z, evidence);
        }
        let rows = pool.jacobian(&self.equations, &self.states).concat();
        let k = self.states.len();
        if let Some(spectrum) = set.spectrum(pool, &rows, evidence) {
            let eigenvalues = listed(&spectrum);
            return match (spectrum.right, spectrum.on_axis) {
                (0, 0) => decided(true, MinimumPhaseReason::Stable, eigenvalues),
                (0, on_axis) => {
                    let critical = Critical { set: &set, states: &self.states, equations: &self.equations, on_axis };
                    match critical.decide(pool, evidence) {
                        Some((holds, reason)) => decided(holds, reason, eigenvalues),
                        None => MinimumPhase { eigenvalues, ..open(Reason::ZeroDynamicsOnAxis) },
                    }
                }
                _ => decided(false, MinimumPhaseReason::Unstable, eigenvalues),
            };
        }
        let Some(values) = set.numbers(pool, &rows) else { return open(Reason::ZeroDynamicsNoNumbers) };
        let mut matrix = DMatrix::from_row_slice(k, k, &values);
        balance(&mut matrix);
        let (Some(eigenvalues), Some(found)) = (eigenvalues(&matrix), clusters(&matrix, matrix.norm())) else {
            return open(Reason::NoConvergence);
        };
        match decay(&found) {
            Some(true) => decided(true, MinimumPhaseReason::Stable, eigenvalues),
            Some(false) => decided(false, MinimumPhaseReason::Unstable, eigenvalues),
            None => MinimumPhase { eigenvalues, ..open(Reason::ZeroDynamicsNearAxis) },
        }
    }

    /// Eigenvalues of the linearization at the point of `set`, real and imaginary parts.
    fn eigenvalues(&self, pool: &mut Pool, set: &Set<'_>, evidence: &mut Evidence) -> Option<Vec<(f64, f64)>> {
        let rows = pool.jacobian(&self.equations, &self.states).concat();
        let k = self.states.len();
        if let Some(spectrum) = set.spectrum(pool, &rows, evidence) {
            return Some(listed(&spectrum));
        }
        let values = set.numbers(pool, &rows)?;
        eigenvalues(&DMatrix::from_row_slice(k, k, &values))
    }

    /// z' = F(z): the first derivative of F that does not vanish decides.
    fn scalar(&self, pool: &mut Pool, set: &Set<'_>, z: Symbol, evidence: &mut Evidence) -> MinimumPhase {
        const MAX_ORDER: usize = 7;
        let mut d = self.equations[0];
        let mut eigenvalues = Vec::new();
        if pool.is_zero(d) {
            let reason = MinimumPhaseReason::AtRest;
            return MinimumPhase { holds: Answer::Known(false), reason: Some(reason), eigenvalues: vec![(0.0, 0.0)] };
        }
        for order in 1..=MAX_ORDER {
            d = pool.diff(d, z);
            let sign = match set.vanishes_at_point(pool, d, evidence) {
                Some(true) => Ordering::Equal,
                Some(false) => {
                    let here = set.values_at_point(pool, &[d])[0];
                    let Some(sign) = pool.constant_sign(here, &Bindings::new()) else { break };
                    sign
                }
                None => break,
            };
            if order == 1 {
                let value = if sign == Ordering::Equal { Some(0.0) } else { set.numbers(pool, &[d]).map(|v| v[0]) };
                eigenvalues.extend(value.map(|v| (v, 0.0)));
            }
            if sign != Ordering::Equal {
                let stable = order % 2 == 1 && sign == Ordering::Less;
                let reason = match (order, stable) {
                    (1, true) => MinimumPhaseReason::Negative,
                    (1, false) => MinimumPhaseReason::Positive,
                    _ => MinimumPhaseReason::Order { state: pool.name(z).to_owned(), order },
                };
                return MinimumPhase { holds: Answer::Known(stable), reason: Some(reason), eigenvalues };
            }
        }
        MinimumPhase { holds: Answer::Unknown(Reason::Derivatives), reason: None, eigenvalues }
    }
}

/// Every eigenvalue as often as it occurs.
fn listed(spectrum: &Spectrum) -> Vec<(f64, f64)> {
    spectrum.roots.iter().flat_map(|r| std::iter::repeat_n((r.re, r.im), r.multiplicity)).collect()
}

impl Set<'_> {
    /// The expressions with the values of point and parameters.
    pub(crate) fn values_at_point(&self, pool: &mut Pool, list: &[Expr]) -> Vec<Expr> {
        let (bindings, mut map) = self.at_point(pool);
        let roots = pool.substitute_all(list, &map);
        map.clear();
        for s in pool.symbols_of(&roots) {
            if let Some(v) = bindings.get(s).cloned() {
                let x = pool.sym(s);
                map.insert(x, pool.rational(v));
            }
        }
        pool.substitute_all(&roots, &map)
    }

    /// The eigenvalues of a square matrix at the point, given by its entries, if they are told exactly.
    fn spectrum(&self, pool: &mut Pool, entries: &[Expr], evidence: &mut Evidence) -> Option<Spectrum> {
        let k = entries.len().isqrt();
        let values = if k > MAX_IRRATIONAL {
            self.rationals(pool, entries)?.into_iter().map(Real::from).collect()
        } else {
            let entries = self.values_at_point(pool, entries);
            reals(pool, &entries, evidence)?
        };
        Spectrum::of_reals(&Matrix::new(values.chunks(k.max(1)).map(<[Real]>::to_vec).collect(), k))
    }

    /// Values at the point; `None` if one is not seen to be a rational number.
    pub(crate) fn rationals(&self, pool: &mut Pool, list: &[Expr]) -> Option<Vec<Rational>> {
        let values = self.values_at_point(pool, list);
        values.into_iter().map(|e| pool.constant_rational(e)).collect()
    }

    /// Values at the point to the last digit, parameters at theirs; `None` if one has none that can be enclosed.
    fn numbers(&self, pool: &mut Pool, list: &[Expr]) -> Option<Vec<f64>> {
        let values = self.values_at_point(pool, list);
        values.into_iter().map(|e| pool.constant_value(e, &Bindings::new())).collect()
    }
}
