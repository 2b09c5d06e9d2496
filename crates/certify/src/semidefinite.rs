//! Small semidefinite programs whose matrices are Gram matrices, by a primal–dual interior-point method.
//!
//! Clarabel's semidefinite cone needs BLAS and LAPACK of the system, which users of this project need not have; its other cones
//! describe scaled diagonal dominance only. The programs here are small and of one shape, in which every entry of a Gram matrix
//! belongs to one equation, so that the linear systems are formed without tables.

use bracketry_symbolic::Limit;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// The equations A(X) + B y = b of one block, X ⪰ 0 of size n × n: A adds up the entries of X that belong to each row.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// n.
    pub(crate) size: usize,
    /// The row to which entry (i, j) belongs, at i n + j; the same for (j, i).
    pub(crate) row_of: Vec<usize>,
    /// One column for each free variable.
    pub(crate) free: DMatrix<f64>,
    /// b.
    pub(crate) right: DVector<f64>,
    /// Cost of the trace of X.
    pub(crate) cost: f64,
}

/// min Σ cost_k tr X_k + c'y subject to the equations of the blocks.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub(crate) blocks: Vec<Block>,
    pub(crate) cost: DVector<f64>,
}

/// Where the method ended.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub(crate) matrices: Vec<DMatrix<f64>>,
    pub(crate) free: DVector<f64>,
    /// Largest residual of the equations relative to the right-hand sides.
    pub(crate) residual: f64,
}

const MAX_ITERATIONS: usize = 80;
/// Relative duality gap and residual at which the iterations end.
const TOLERANCE: f64 = 1e-9;
/// Part of the way to the boundary that a step goes.
const TO_BOUNDARY: f64 = 0.95;
/// Steps shorter than this make no progress.
const SHORTEST_STEP: f64 = 1e-7;

/// Iterates of one block.
struct Iterate {
    x: DMatrix<f64>,
    z: DMatrix<f64>,
    multiplier: DVector<f64>,
}

/// What stays the same between predictor and corrector.
struct Linearized {
    inverse: DMatrix<f64>,
    schur: Cholesky<f64, Dyn>,
    /// Schur⁻¹ B.
    eliminated: DMatrix<f64>,
    primal: DVector<f64>,
    dual: DMatrix<f64>,
}

struct Direction {
    x: DMatrix<f64>,
    z: DMatrix<f64>,
    multiplier: DVector<f64>,
}

impl Block {
    fn sums(&self, x: &DMatrix<f64>) -> DVector<f64> {
        let mut out = DVector::zeros(self.right.len());
        for i in 0..self.size {
            for j in 0..self.size {
                out[self.row_of[i * self.size + j]] += x[(i, j)];
            }
        }
        out
    }

    fn adjoint(&self, v: &DVector<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.size, self.size, |i, j| v[self.row_of[i * self.size + j]])
    }

    /// tr(A_r X A_s Z⁻¹) for all rows r, s.
    fn schur(&self, x: &DMatrix<f64>, inverse: &DMatrix<f64>) -> DMatrix<f64> {
        let (n, rows) = (self.size, self.right.len());
        let mut m = DMatrix::zeros(rows, rows);
        for i in 0..n {
            for j in 0..n {
                let column = self.row_of[i * n + j];
                for q in 0..n {
                    let factor = inverse[(q, j)];
                    for p in 0..n {
                        m[(self.row_of[p * n + q], column)] += x[(p, i)] * factor;
                    }
                }
            }
        }
        let transposed = m.transpose();
        (m + transposed) * 0.5
    }
}

fn symmetric(m: DMatrix<f64>) -> DMatrix<f64> {
    let transposed = m.transpose();
    (m + transposed) * 0.5
}

/// The longest step, at most 1, that keeps x + step · d positive definite with a distance to the boundary.
fn step_length(x: &DMatrix<f64>, d: &DMatrix<f64>) -> f64 {
    let mut step = 1.0 / TO_BOUNDARY;
    while step > SHORTEST_STEP {
        if (x + d * step).cholesky().is_some() {
            return (step * TO_BOUNDARY).min(1.0);
        }
        step *= 0.8;
    }
    0.0
}

impl Problem {
    /// Solves the program from an infeasible start (predictor and corrector of Mehrotra 1992, direction of Helmberg, Rendl,
    /// Vanderbei, and Wolkowicz 1996, of Kojima, Shindoh, and Hara 1997, and of Monteiro 1997). The best point so far where it
    /// makes no progress any more; `None` where the limit was reached, or no step is possible.
    pub(crate) fn solve(&self, limit: &Limit) -> Option<Solution> {
        let free_count = self.cost.len();
        let size = self.blocks.iter().flat_map(|b| b.right.iter()).fold(1.0, |m: f64, v| m.max(v.abs()));
        let mut y = DVector::zeros(free_count);
        let mut iterates: Vec<Iterate> = self
            .blocks
            .iter()
            .map(|b| Iterate {
                x: DMatrix::identity(b.size, b.size) * (10.0 * size),
                z: DMatrix::identity(b.size, b.size) * (1.0 + b.cost),
                multiplier: DVector::zeros(b.right.len()),
            })
            .collect();
        let total: usize = self.blocks.iter().map(|b| b.size).sum();
        let mut best: Option<Solution> = None;
        for _ in 0..MAX_ITERATIONS {
            if limit.is_reached() {
                return None;
            }
            let residuals: Vec<DVector<f64>> = self.residuals(&iterates, &y);
            let residual = residuals.iter().map(DVector::amax).fold(0.0, f64::max) / size;
            let gap = iterates.iter().map(|s| s.x.dot(&s.z)).sum::<f64>() / total as f64;
            let objective = self.cost.dot(&y).abs();
            if !residual.is_finite() || !gap.is_finite() {
                break;
            }
            if best.as_ref().is_none_or(|b| residual <= b.residual.max(TOLERANCE)) {
                let matrices = iterates.iter().map(|s| s.x.clone()).collect();
                best = Some(Solution { matrices, free: y.clone(), residual });
            }
            if residual < TOLERANCE && gap * (total as f64) < TOLERANCE * (1.0 + objective) {
                break;
            }
            let Some(linearized) = self.linearize(&iterates, residuals) else { break };
            let Some(normal) = self.normal(&linearized, free_count) else { break };
            let stationarity = self.stationarity(&iterates);
            let none: Vec<Option<DMatrix<f64>>> = vec![None; self.blocks.len()];
            let (predictor, _) = self.direction(&iterates, &linearized, &normal, &stationarity, 0.0, &none);
            let (primal, dual) = lengths(&iterates, &predictor);
            let after: f64 = iterates
                .iter()
                .zip(&predictor)
                .map(|(s, d)| (&s.x + &d.x * primal).dot(&(&s.z + &d.z * dual)))
                .sum::<f64>()
                / total as f64;
            let centering = (after / gap).max(0.0).powi(2).clamp(1e-4, 0.9);
            let corrections: Vec<Option<DMatrix<f64>>> =
                predictor.iter().zip(&linearized).map(|(d, l)| Some(symmetric(&d.x * &d.z * &l.inverse))).collect();
            let (direction, step_y) =
                self.direction(&iterates, &linearized, &normal, &stationarity, centering * gap, &corrections);
            let (primal, dual) = lengths(&iterates, &direction);
            if primal < SHORTEST_STEP && dual < SHORTEST_STEP {
                break;
            }
            for (s, d) in iterates.iter_mut().zip(&direction) {
                s.x += &d.x * primal;
                s.z += &d.z * dual;
                s.multiplier += &d.multiplier * dual;
            }
            y += step_y * primal;
        }
        best
    }

    fn residuals(&self, iterates: &[Iterate], y: &DVector<f64>) -> Vec<DVector<f64>> {
        self.blocks.iter().zip(iterates).map(|(b, s)| &b.right - b.sums(&s.x) - &b.free * y).collect()
    }

    /// c − Σ B'λ.
    fn stationarity(&self, iterates: &[Iterate]) -> DVector<f64> {
        let zero = self.cost.clone();
        self.blocks.iter().zip(iterates).fold(zero, |sum, (b, s)| sum - b.free.tr_mul(&s.multiplier))
    }

    fn linearize(&self, iterates: &[Iterate], residuals: Vec<DVector<f64>>) -> Option<Vec<Linearized>> {
        let each = self.blocks.iter().zip(iterates).zip(residuals);
        each.map(|((b, s), primal)| {
            let inverse = s.z.clone().cholesky()?.inverse();
            let mut schur = b.schur(&s.x, &inverse);
            // Rounding makes the matrix indefinite near the end.
            let regular = 1e-15 * schur.diagonal().amax();
            for k in 0..schur.nrows() {
                schur[(k, k)] += regular;
            }
            let schur = schur.cholesky()?;
            let eliminated = schur.solve(&b.free);
            let dual = DMatrix::identity(b.size, b.size) * b.cost - b.adjoint(&s.multiplier) - &s.z;
            Some(Linearized { inverse, schur, eliminated, primal, dual })
        })
        .collect()
    }

    /// Σ B' Schur⁻¹ B, which determines the free variables.
    fn normal(&self, linearized: &[Linearized], free_count: usize) -> Option<Cholesky<f64, Dyn>> {
        let zero = DMatrix::zeros(free_count, free_count);
        let mut sum: DMatrix<f64> =
            self.blocks.iter().zip(linearized).fold(zero, |sum, (b, l)| sum + b.free.tr_mul(&l.eliminated));
        let regular = 1e-14 * sum.diagonal().amax().max(f64::MIN_POSITIVE);
        for k in 0..free_count {
            sum[(k, k)] += regular;
        }
        symmetric(sum).cholesky()
    }

    fn direction(
        &self,
        iterates: &[Iterate],
        linearized: &[Linearized],
        normal: &Cholesky<f64, Dyn>,
        stationarity: &DVector<f64>,
        target: f64,
        corrections: &[Option<DMatrix<f64>>],
    ) -> (Vec<Direction>, DVector<f64>) {
        let constants: Vec<DMatrix<f64>> = iterates
            .iter()
            .zip(linearized)
            .zip(corrections)
            .map(|((s, l), correction)| {
                let along = symmetric(&s.x * &l.dual * &l.inverse);
                let constant = &l.inverse * target - &s.x - along;
                correction.as_ref().map_or_else(|| constant.clone(), |c| &constant - c)
            })
            .collect();
        let right: Vec<DVector<f64>> = self
            .blocks
            .iter()
            .zip(linearized)
            .zip(&constants)
            .map(|((b, l), constant)| &l.primal - b.sums(constant))
            .collect();
        let zero = -stationarity.clone();
        let sum = linearized.iter().zip(&right).fold(zero, |sum, (l, g)| sum + l.eliminated.tr_mul(g));
        let step = normal.solve(&sum);
        let each = self.blocks.iter().zip(iterates).zip(linearized).zip(right.iter().zip(constants));
        let directions = each
            .map(|(((b, s), l), (g, constant))| {
                let multiplier = l.schur.solve(&(g - &b.free * &step));
                let adjoint = b.adjoint(&multiplier);
                let x = constant + symmetric(&s.x * &adjoint * &l.inverse);
                Direction { x, z: &l.dual - adjoint, multiplier }
            })
            .collect();
        (directions, step)
    }
}

fn lengths(iterates: &[Iterate], directions: &[Direction]) -> (f64, f64) {
    let each = || iterates.iter().zip(directions);
    (
        each().map(|(s, d)| step_length(&s.x, &d.x)).fold(1.0, f64::min),
        each().map(|(s, d)| step_length(&s.z, &d.z)).fold(1.0, f64::min),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least eigenvalue of a matrix is the largest t with M − t I ⪰ 0.
    #[test]
    fn the_program_finds_the_least_eigenvalue() {
        let m = DMatrix::from_row_slice(3, 3, &[2.0, -1.0, 0.5, -1.0, 1.0, 0.3, 0.5, 0.3, -1.0]);
        let rows = [0, 1, 2, 1, 3, 4, 2, 4, 5];
        let mut free = DMatrix::zeros(6, 1);
        let mut right = DVector::zeros(6);
        for i in 0..3 {
            for j in i..3 {
                let row = rows[i * 3 + j];
                right[row] = if i == j { m[(i, j)] } else { 2.0 * m[(i, j)] };
                if i == j {
                    free[(row, 0)] = 1.0;
                }
            }
        }
        let block = Block { size: 3, row_of: rows.to_vec(), free, right, cost: 0.0 };
        let problem = Problem { blocks: vec![block], cost: DVector::from_element(1, -1.0) };
        let solution = problem.solve(&Limit::default()).unwrap_or_else(|| panic!("no solution"));
        let least = m.symmetric_eigenvalues().min();
        assert!((solution.free[0] - least).abs() < 1e-7, "{} instead of {least}", solution.free[0]);
    }
}
