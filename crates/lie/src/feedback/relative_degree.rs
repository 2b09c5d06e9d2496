//! Relative degrees of outputs and the decoupling matrix.

use bracketry_symbolic::{Expr, Func, Function, Named, Node, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::field::VectorFields;
use crate::algebra::matrix::{determinant, generic_rank, solve};
use crate::algebra::rational::readable::{tidy, vanishing_factors};
use crate::budget::check_growth;
use crate::condition::Condition;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

/// How the inputs enter the derivatives of the outputs (Isidori 1995, sec. 5.1), at a generic point.
#[derive(Clone, Debug)]
pub struct RelativeDegree {
    /// Per output the smallest r with some `L_gj L_f^(r−1) h ≠ 0`; `None` where no input ever reaches it.
    pub degrees: Vec<Option<usize>>,
    /// Per output `h, L_f h, …, L_f^(r−1) h`; as far as they differ for an output that is never reached.
    pub derivatives: Vec<Vec<Expr>>,
    /// Per output `L_f^r h`, the part of the r-th derivative that is free of inputs.
    pub drift: Vec<Expr>,
    /// `A_ij = L_gj L_f^(r_i−1) h_i`; zero rows for outputs that are never reached.
    pub decoupling: Vec<Vec<Expr>>,
    /// Generic rank of A.
    pub rank: usize,
}

impl RelativeDegree {
    /// Whether the outputs have a vector relative degree at a generic point: A has full row rank.
    pub fn is_vector(&self) -> bool {
        self.rank == self.degrees.len()
    }

    /// The sum of the degrees; `None` if an output is never reached.
    pub fn total(&self) -> Option<usize> {
        self.degrees.iter().copied().sum()
    }

    /// det A for as many outputs as inputs, as a readable expression; `None` otherwise or if it
    /// is too large to be written out.
    pub fn determinant(&self, pool: &mut Pool) -> Option<Expr> {
        determinant(pool, &self.decoupling)
    }

    /// The functions of which at least one vanishes where A is singular or an output has no value, for as many outputs as
    /// inputs.
    pub fn singular_factors(&self, pool: &mut Pool, fields: &VectorFields) -> Option<Vec<Expr>> {
        let d = self.determinant(pool)?;
        let mut factors = vanishing_factors(pool, d, &fields.states, &fields.bindings)?;
        let outputs: Vec<Expr> = self.derivatives.iter().filter_map(|list| list.first().copied()).collect();
        for e in divisors(pool, &outputs) {
            for factor in vanishing_factors(pool, e, &fields.states, &fields.bindings)? {
                if !factors.contains(&factor) {
                    factors.push(factor);
                }
            }
        }
        Some(factors)
    }

    /// Where det A vanishes or an output has no value; `None` if det A is zero everywhere or too large, or A is not
    /// square.
    pub fn singular_set(&self, pool: &mut Pool, fields: &VectorFields) -> Option<Condition> {
        let factors = self.is_vector().then(|| self.singular_factors(pool, fields))??;
        Some(Condition::any_vanishes(pool, &factors))
    }

    /// The feedback `u = A⁻¹(v − L_f^r h)` that makes `y_i^(r_i) = v_i`, where A is square and invertible.
    pub fn feedback(&self, pool: &mut Pool, references: &[Expr]) -> Option<Vec<Expr>> {
        if !self.is_vector() || self.decoupling.iter().any(|row| row.len() != self.degrees.len()) {
            return None;
        }
        let wanted: Vec<Expr> = references.iter().zip(&self.drift).map(|(&v, &b)| pool.sub(v, b)).collect();
        solve(pool, &self.decoupling, &wanted)
    }

    /// [`RelativeDegree::feedback`] with the names of the inputs.
    pub(crate) fn named_feedback(
        &self,
        pool: &mut Pool,
        inputs: &[Symbol],
        references: &[Expr],
    ) -> Option<Named<Function>> {
        let feedback = self.feedback(pool, references)?;
        Some(Named(
            inputs.iter().zip(feedback).map(|(&u, e)| (pool.name(u).to_owned(), Function::new(pool, e))).collect(),
        ))
    }

    /// Rank of A at a point, given one constant expression per state.
    ///
    /// # Errors
    /// [`Undecided`] if A has no value there or cannot be evaluated exactly.
    pub fn rank_at(
        &self,
        pool: &mut Pool,
        fields: &VectorFields,
        point: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<usize, Undecided> {
        let mut bindings = fields.bindings.clone();
        let mut at: FxHashMap<Expr, Expr> = FxHashMap::default();
        for (&s, &v) in fields.states.iter().zip(point) {
            // Rational coordinates are bound, so that a denominator that vanishes there is seen.
            if let Some(value) = pool.number(v) {
                bindings.bind(s, value.clone());
            } else {
                at.insert(pool.sym(s), v);
            }
        }
        let rows: Vec<Vec<Expr>> = self.decoupling.iter().map(|r| pool.substitute_all(r, &at)).collect();
        generic_rank(pool, &rows, &bindings, evidence)
    }
}

impl VectorFields {
    /// Relative degrees and decoupling matrix of `outputs`, functions of the state.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly or grows too large.
    pub fn relative_degree(
        &self,
        pool: &mut Pool,
        outputs: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<RelativeDegree, Undecided> {
        let known = outputs.iter().map(|&h| vec![tidy(pool, h)]).collect();
        self.relative_degree_from(pool, known, evidence)
    }

    /// The same, with the first derivatives `h, L_f h, …` of every output known and free of inputs.
    pub(crate) fn relative_degree_from(
        &self,
        pool: &mut Pool,
        known: Vec<Vec<Expr>>,
        evidence: &mut Evidence,
    ) -> Result<RelativeDegree, Undecided> {
        let first = pool.len();
        let zero = pool.int(0);
        let mut found = RelativeDegree {
            degrees: Vec::new(),
            derivatives: Vec::new(),
            drift: Vec::new(),
            decoupling: Vec::new(),
            rank: 0,
        };
        for mut list in known {
            let mut row = vec![zero; self.controls.len()];
            let mut degree = None;
            let mut last = list.last().copied().unwrap_or(zero);
            // dh, dL_f h, …, dL_f^(r−1) h are independent up to the relative degree: r ≤ n.
            for r in list.len()..=self.states.len() {
                check_growth(pool, first, [&[last], &[]], self.states.len())?;
                for (entry, g) in row.iter_mut().zip(&self.controls) {
                    let e = pool.lie_derivative(last, &self.states, g);
                    *entry = if self.vanishes(pool, e, evidence)? { zero } else { tidy(pool, e) };
                }
                let next = pool.lie_derivative(last, &self.states, &self.drift);
                last = if self.vanishes(pool, next, evidence)? { zero } else { tidy(pool, next) };
                if row.iter().any(|&e| e != zero) {
                    degree = Some(r);
                    break;
                }
                if r < self.states.len() {
                    list.push(last);
                }
            }
            found.degrees.push(degree);
            found.derivatives.push(list);
            found.drift.push(last);
            found.decoupling.push(row);
        }
        found.rank = generic_rank(pool, &found.decoupling, &self.bindings, evidence)?;
        Ok(found)
    }
}

/// What the expressions divide by or take the logarithm of.
pub(crate) fn divisors(pool: &Pool, roots: &[Expr]) -> Vec<Expr> {
    let inner = |e: Expr| match pool.node(e) {
        Node::Pow(base, k) if pool.number(k).is_some_and(|k| *k < Rational::ZERO) => Some(base),
        Node::Call(Func::Log, a) => Some(a),
        _ => None,
    };
    pool.reachable(roots).into_iter().filter_map(inner).collect()
}
