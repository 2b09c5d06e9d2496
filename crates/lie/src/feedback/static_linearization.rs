//! Exact linearization by static state feedback.

use bracketry_symbolic::{Expr, Pool};

use crate::algebra::field::{Field, VectorFields, bracket};
use crate::algebra::integrals::search::integrals_of_involutive;
use crate::algebra::krylov::Krylov;
use crate::algebra::matrix::generic_rank;
use crate::algebra::merge::merge_equal;
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::{independent, involutive};
use crate::budget::check_growth;
use crate::evidence::Evidence;
use crate::feedback::relative_degree::RelativeDegree;
use crate::undecided::Undecided;

/// The distributions `D_i = span{ad_f^k g_j, k ≤ i}` at a generic point.
#[derive(Clone, Debug)]
pub struct LinearizationFlag {
    /// dim D_0, dim D_1, … until the dimension is full or repeats (the repeated value is kept).
    pub dims: Vec<usize>,
    /// Whether D_i is involutive.
    pub involutive: Vec<bool>,
    /// Fields of which the first `dims[i]` span D_i if all distributions before are involutive.
    pub basis: Vec<Field>,
    states: usize,
}

impl LinearizationFlag {
    /// Whether static feedback and a change of coordinates make the system linear and
    /// controllable near a generic point.
    ///
    /// Jakubczyk and Respondek 1980; Hunt, Su, and Meyer 1983: D_0 … D_{n−2} are involutive and dim D_{n−1} = n.
    pub fn linearizable(&self) -> bool {
        self.dims.last() == Some(&self.states) && self.involutive.iter().all(|&i| i)
    }

    /// Lengths of the chains of integrators that a linearizable system is equivalent to, longest
    /// first: κ_j is the number of i with dim D_i − dim D_{i−1} ≥ j.
    pub fn controllability_indices(&self) -> Vec<usize> {
        let steps: Vec<usize> = self.dims.iter().scan(0, |before, &d| Some(d - std::mem::replace(before, d))).collect();
        let inputs = steps.first().copied().unwrap_or(0);
        (1..=inputs).map(|j| steps.iter().filter(|&&s| s >= j).count()).collect()
    }
}

impl VectorFields {
    /// Dimensions and involutivity of the distributions that decide on static feedback linearization.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly, or grows too large before the
    /// question of linearizability is settled.
    pub fn linearization_flag(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<LinearizationFlag, Undecided> {
        let n = self.states.len();
        if let Some(linear) = Krylov::of_large(pool, self) {
            // Constant fields commute.
            let (dims, basis) = linear.flag(pool, evidence)?;
            let involutive = vec![true; dims.len()];
            return Ok(LinearizationFlag { dims, involutive, basis, states: n });
        }
        let basis = independent(pool, &self.controls, &self.bindings, evidence)?;
        let mut flag = LinearizationFlag { dims: vec![basis.len()], involutive: Vec::new(), basis, states: n };
        let first = pool.len();
        loop {
            match self.next_distribution(pool, &mut flag, first, evidence) {
                Ok(true) => {}
                Ok(false) => return Ok(flag),
                // Once a distribution is not involutive the rest of the list decides nothing.
                Err(_) if flag.involutive.contains(&false) => return Ok(flag),
                Err(why) => return Err(why),
            }
        }
    }

    /// Decides on the involutivity of the last distribution of `flag` and appends the next one; false at the end.
    fn next_distribution(
        &self,
        pool: &mut Pool,
        flag: &mut LinearizationFlag,
        first: usize,
        evidence: &mut Evidence,
    ) -> Result<bool, Undecided> {
        let last = flag.dims.len() - 1;
        let known = flag.basis.len();
        let before = if last == 0 { 0 } else { flag.dims[last - 1] };
        // Brackets of older fields lie in D_{i−1} where that is involutive.
        let old = if flag.involutive.last() == Some(&true) { before } else { 0 };
        if flag.involutive.len() == last {
            flag.involutive.push(involutive(pool, &self.states, &flag.basis, old, &self.bindings, evidence)?);
        }
        if known == self.states.len() || known == before {
            return Ok(false);
        }
        // [f, aY] = a[f, Y] + (f·a)Y, and [f, D_{i−1}] ⊂ D_i: the new fields suffice.
        let mut all = flag.basis.clone();
        for y in &flag.basis[before..] {
            check_growth(pool, first, [&self.drift, y], 1)?;
            all.push(bracket(pool, &self.states, &self.drift, y));
        }
        let mut basis = independent(pool, &all, &self.bindings, evidence)?;
        if let Ok(merged) = merge_equal(pool, &basis, &self.bindings, evidence) {
            basis = merged;
        }
        eliminate_units(pool, &mut basis);
        flag.dims.push(basis.len());
        flag.basis = basis;
        Ok(true)
    }

    /// Whether x' = f + Σ u_i g_i can be made linear and controllable near a generic point by
    /// a change of coordinates and static state feedback; see [`LinearizationFlag::linearizable`].
    ///
    /// # Errors
    /// [`Undecided`] if a function in the fields cannot be evaluated exactly.
    pub fn static_feedback_linearizable(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<bool, Undecided> {
        Ok(self.linearization_flag(pool, evidence)?.linearizable())
    }

    /// Outputs with vector relative degree (κ_1, …, κ_m), Σ κ_j = n, for a linearizable system
    /// (Isidori 1995, thm. 5.2.3), each tested exactly; `None` if they were not found in closed form.
    ///
    /// `preferred` functions and the states are tried first, the shortest before the others, then functions that are constant
    /// along the distributions of `flag`. The input fields must be independent.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly, or the derivatives of the outputs grow too large.
    pub fn linearizing_outputs(
        &self,
        pool: &mut Pool,
        flag: &LinearizationFlag,
        preferred: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<Option<LinearizingOutputs>, Undecided> {
        let Some(functions) = self.linearizing_functions(pool, flag, preferred, evidence)? else { return Ok(None) };
        let degrees = self.relative_degree(pool, &functions, evidence)?;
        let found: Option<Vec<usize>> = degrees.degrees.iter().copied().collect();
        if degrees.is_vector() && found.is_some_and(|d| d == flag.controllability_indices()) {
            Ok(Some(LinearizingOutputs { functions, degrees }))
        } else {
            Ok(None)
        }
    }

    /// The functions of [`VectorFields::linearizing_outputs`], without their derivatives, which grow with the length of a chain.
    ///
    /// For h constant along D_(κ−2), `L_g L_f^(κ−1) h = (−1)^(κ−1) dh(ad_f^(κ−1) g)` (Isidori 1995, lemma 4.1.2):
    /// the decoupling matrix follows from the fields `ad_f^(κ−1) g_i`, and from these modulo D_(κ−2).
    pub(crate) fn linearizing_functions(
        &self,
        pool: &mut Pool,
        flag: &LinearizationFlag,
        preferred: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<Option<Vec<Expr>>, Undecided> {
        let indices = flag.controllability_indices();
        if !flag.linearizable() || indices.len() != self.controls.len() {
            return Ok(None);
        }
        let mut simple = preferred.to_vec();
        for &s in &self.states {
            let x = pool.sym(s);
            if !simple.contains(&x) {
                simple.push(x);
            }
        }
        // Shorter outputs make shorter feedback: cos(q) in place of q makes it singular, too.
        simple.sort_by_key(|&h| pool.reachable(&[h]).len());
        let levels = self.levels(pool, flag)?;
        let mut chosen: Vec<Expr> = Vec::new();
        let mut rows: Vec<Vec<Expr>> = Vec::new();
        for &length in &indices {
            let along = if length >= 2 { &flag.basis[..flag.dims[length - 2]] } else { &[] };
            let level = &levels[length - 1];
            let mut candidates = Vec::new();
            for &h in &simple {
                if self.constant_along(pool, h, along, evidence)? {
                    candidates.push(h);
                }
            }
            let mut next = self.first_independent(pool, &mut rows, level, &candidates, evidence)?;
            if next.is_none() && !along.is_empty() {
                let integrals =
                    integrals_of_involutive(pool, &self.states, along, preferred, &self.bindings, evidence)?;
                next = self.first_independent(pool, &mut rows, level, &integrals.functions, evidence)?;
            }
            let Some(h) = next else { return Ok(None) };
            chosen.push(tidy(pool, h));
        }
        Ok(Some(chosen))
    }

    /// `ad_f^k g_i` modulo D_(k−1) for all i, at index k: the components of which D_(k−1) holds the unit fields are left out.
    fn levels(&self, pool: &mut Pool, flag: &LinearizationFlag) -> Result<Vec<Vec<Field>>, Undecided> {
        let first = pool.len();
        let zero = pool.int(0);
        let mut levels = vec![self.controls.clone()];
        for k in 1..flag.dims.len() {
            let mut level = Vec::new();
            for y in &levels[k - 1] {
                check_growth(pool, first, [&self.drift, y], 1)?;
                let mut next = bracket(pool, &self.states, &self.drift, y);
                for field in &flag.basis[..flag.dims[k - 1]] {
                    let mut nonzero = (0..field.len()).filter(|&i| field[i] != zero);
                    if let (Some(i), None) = (nonzero.next(), nonzero.next()) {
                        next[i] = zero;
                    }
                }
                level.push(next);
            }
            levels.push(level);
        }
        Ok(levels)
    }

    /// Whether the derivatives of `h` along all of `fields` vanish.
    pub(crate) fn constant_along(
        &self,
        pool: &mut Pool,
        h: Expr,
        fields: &[Field],
        evidence: &mut Evidence,
    ) -> Result<bool, Undecided> {
        for y in fields {
            let e = pool.lie_derivative(h, &self.states, y);
            if !self.vanishes(pool, e, evidence)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The first of `candidates` whose row dh(Y_i), Y_i in `level`, is independent of `rows`, to which it is added.
    fn first_independent(
        &self,
        pool: &mut Pool,
        rows: &mut Vec<Vec<Expr>>,
        level: &[Field],
        candidates: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<Option<Expr>, Undecided> {
        for &h in candidates {
            rows.push(level.iter().map(|y| pool.lie_derivative(h, &self.states, y)).collect());
            if generic_rank(pool, rows, &self.bindings, evidence)? == rows.len() {
                return Ok(Some(h));
            }
            rows.pop();
        }
        Ok(None)
    }
}

/// Outputs that linearize a system together with their derivatives.
#[derive(Clone, Debug)]
pub struct LinearizingOutputs {
    /// The outputs, those with the longest chains first.
    pub functions: Vec<Expr>,
    /// Their relative degrees, which add up to the number of states. The derivatives are the
    /// linearizing coordinates, [`RelativeDegree::feedback`] the linearizing feedback.
    pub degrees: RelativeDegree,
}

/// Makes independent fields simpler without a change of the distributions that the first ones
/// span: a field with one component that is not plainly zero becomes the unit field, and no
/// later field keeps that component.
fn eliminate_units(pool: &mut Pool, fields: &mut [Field]) {
    let (zero, one) = (pool.int(0), pool.int(1));
    let mut units: Vec<usize> = Vec::new();
    for field in fields {
        for &i in &units {
            field[i] = zero;
        }
        let mut nonzero = (0..field.len()).filter(|&i| field[i] != zero);
        if let (Some(i), None) = (nonzero.next(), nonzero.next()) {
            field[i] = one;
            units.push(i);
        }
    }
}
