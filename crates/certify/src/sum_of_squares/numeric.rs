//! The semidefinite program of a program of sums of squares.

use bracketry_symbolic::Limit;
use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::monomials::{Monomial, product};
use crate::semidefinite::{Block, Problem};
use crate::sum_of_squares::program::{AffinePolynomial, Constraint, Margin, Program, Unsolved};

/// A numerical solution with the largest margin.
#[derive(Clone, Debug)]
pub(crate) struct Numeric {
    pub(crate) unknowns: Vec<f64>,
    /// One for each constraint.
    pub(crate) matrices: Vec<DMatrix<f64>>,
    /// Largest t with Q − t I ⪰ 0 for all of them that have no fixed margin, at most 1.
    pub(crate) margin: f64,
}

/// Weight of the traces against the margin: it bounds the solution and is small enough to leave the margin.
const TRACE: f64 = 1e-6;
/// Solutions that violate the equations by more are none.
const MAX_RESIDUAL: f64 = 1e-5;

/// Size by which the coefficients of an unknown are divided, so that all unknowns are of like size.
fn scale(p: &[&AffinePolynomial], k: usize) -> f64 {
    let sizes = p.iter().flat_map(|p| p.linear[k].terms().map(|(_, c)| c.to_f64().value().abs()));
    sizes.fold(0.0, f64::max)
}

impl Program {
    /// Maximizes t ≤ 1 subject to p_k(x; y) = zᵀ Q_k z and Q_k ⪰ t I, less a little of the traces. Both this program and its dual have
    /// strictly feasible points once the linear equations are satisfied, so that the method converges.
    pub(crate) fn solve(&self, limit: &Limit) -> Result<Numeric, Unsolved> {
        let all: Vec<&AffinePolynomial> = self.constraints.iter().map(|c| &c.polynomial).collect();
        let scales: Vec<f64> =
            (0..self.unknowns).map(|k| scale(&all, k)).map(|s| if s > 0.0 { s } else { 1.0 }).collect();
        let filled = || self.constraints.iter().filter(|c| !c.basis.is_empty());
        let mut blocks: Vec<Block> = filled().map(|c| block(c, &scales)).collect();
        // t + τ = 1 with τ ≥ 0.
        let mut free = DMatrix::zeros(1, self.unknowns + 1);
        free[(0, self.unknowns)] = 1.0;
        blocks.push(Block { size: 1, row_of: vec![0], free, right: DVector::from_element(1, 1.0), cost: TRACE });
        let mut cost = DVector::zeros(self.unknowns + 1);
        cost[self.unknowns] = -1.0;
        let solution = match (Problem { blocks, cost }).solve(limit) {
            Some(solution) if solution.residual < MAX_RESIDUAL => solution,
            _ if limit.is_reached() => return Err(Unsolved::OutOfTime),
            _ => return Err(Unsolved::NotFeasible),
        };
        let margin = solution.free[self.unknowns];
        let mut found = solution.matrices.iter();
        let mut next = |c: &Constraint| {
            let x = if c.basis.is_empty() { None } else { found.next() };
            let shift = if c.margin == Margin::One { 1.0 } else { margin };
            x.map(|x| x + DMatrix::identity(x.nrows(), x.nrows()) * shift)
        };
        let matrices = self.constraints.iter().map(|c| next(c).unwrap_or_else(|| DMatrix::zeros(0, 0))).collect();
        Ok(Numeric { unknowns: solution.free.iter().zip(&scales).map(|(y, s)| y / s).collect(), matrices, margin })
    }
}

/// The rows of a constraint: the place of each product of two monomials, in order.
pub(crate) fn rows(c: &Constraint) -> BTreeMap<Monomial, usize> {
    c.products().into_iter().enumerate().map(|(k, m)| (m, k)).collect()
}

fn block(c: &Constraint, scales: &[f64]) -> Block {
    let (n, unknowns) = (c.basis.len(), scales.len());
    let rows = rows(c);
    let mut row_of = vec![0; n * n];
    let mut free = DMatrix::zeros(rows.len(), unknowns + 1);
    for i in 0..n {
        for j in 0..n {
            row_of[i * n + j] = rows[&product(&c.basis[i], &c.basis[j])];
        }
        if c.margin == Margin::Largest {
            free[(row_of[i * n + i], unknowns)] += 1.0;
        }
    }
    for (k, p) in c.polynomial.linear.iter().enumerate() {
        for (m, x) in p.terms() {
            if let Some(&row) = rows.get(m) {
                free[(row, k)] = -x.to_f64().value() / scales[k];
            }
        }
    }
    let mut right = DVector::zeros(rows.len());
    for (m, x) in c.polynomial.constant.terms() {
        if let Some(&row) = rows.get(m) {
            right[row] = x.to_f64().value();
        }
    }
    if c.margin == Margin::One {
        for i in 0..n {
            right[row_of[i * n + i]] -= 1.0;
        }
    }
    Block { size: n, row_of, free, right, cost: TRACE }
}
