//! The input combinations that keep the second distribution involutive.

use bracketry_symbolic::{Expr, Pool};

use crate::algebra::field::{Field, VectorFields, bracket};
use crate::algebra::matrix::{generic_rank, reduced, solve};
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::independent;
use crate::algebra::subsets::subsets;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

impl VectorFields {
    /// Combinations Y = Σ α_i(x) g_i with `Σ α_i [g_j, [f, g_i]]` in D_1 = span{g_i, [f, g_i]} for all j, where D_1 is not
    /// involutive: along them, an involutive distribution between D_0 and D_1 may exist, whose integrals are candidates for
    /// flat outputs (Gstöttner, Kolar and Schöberl 2021). They do not depend on the choice of the inputs. Empty if
    /// there are none, or D_1 has not 2m dimensions.
    pub(crate) fn characteristic_inputs(
        &self,
        pool: &mut Pool,
        evidence: &mut Evidence,
    ) -> Result<Vec<Field>, Undecided> {
        let (n, m) = (self.states.len(), self.controls.len());
        let along: Vec<Field> =
            self.controls.iter().map(|g| bracket(pool, &self.states, &self.drift, g)).collect();
        let spanning: Vec<Field> = self.controls.iter().chain(&along).cloned().collect();
        let basis = independent(pool, &spanning, &self.bindings, evidence)?;
        if basis.len() != 2 * m || basis.len() >= n {
            return Ok(Vec::new());
        }
        let basis = reduced(pool, &basis, &self.bindings, evidence)?;
        let Some(pivots) = pivots(pool, &basis) else { return Ok(Vec::new()) };
        let mut rows = Vec::new();
        for g in &self.controls {
            let columns: Vec<Field> = along
                .iter()
                .map(|y| {
                    let z = bracket(pool, &self.states, g, y);
                    modulo(pool, z, &basis, &pivots)
                })
                .collect();
            for k in (0..n).filter(|k| !pivots.contains(k)) {
                rows.push(columns.iter().map(|c| c[k]).collect::<Vec<Expr>>());
            }
        }
        let kernel = self.kernel(pool, &rows, evidence)?;
        Ok(kernel.into_iter().map(|alpha| self.combination(pool, &alpha)).collect())
    }

    /// A basis of {α : M α = 0}; empty if all α are in it, or it is not written out.
    fn kernel(
        &self,
        pool: &mut Pool,
        rows: &[Vec<Expr>],
        evidence: &mut Evidence,
    ) -> Result<Vec<Vec<Expr>>, Undecided> {
        let m = self.controls.len();
        let rank = pool.rank(rows, &self.bindings)?;
        evidence.add(&rank.certificate);
        if rank.rank == 0 || rank.rank == m {
            return Ok(Vec::new());
        }
        let top: Vec<&Vec<Expr>> = rank.independent.iter().map(|&i| &rows[i]).collect();
        let (zero, one) = (pool.int(0), pool.int(1));
        for pivots in subsets(m, rank.rank) {
            let b: Vec<Vec<Expr>> = top.iter().map(|row| pivots.iter().map(|&j| row[j]).collect()).collect();
            if generic_rank(pool, &b, &self.bindings, evidence)? < rank.rank {
                continue;
            }
            let mut kernel = Vec::new();
            for free in (0..m).filter(|j| !pivots.contains(j)) {
                let column: Vec<Expr> = top.iter().map(|row| pool.neg(row[free])).collect();
                let Some(x) = solve(pool, &b, &column) else { return Ok(Vec::new()) };
                let mut alpha = vec![zero; m];
                alpha[free] = one;
                for (&j, x) in pivots.iter().zip(x) {
                    alpha[j] = tidy(pool, x);
                }
                kernel.push(alpha);
            }
            return Ok(kernel);
        }
        Ok(Vec::new())
    }

    /// Σ α_i g_i.
    fn combination(&self, pool: &mut Pool, alpha: &[Expr]) -> Field {
        (0..self.states.len())
            .map(|k| {
                let mut sum = pool.int(0);
                for (&a, g) in alpha.iter().zip(&self.controls) {
                    let term = pool.mul(a, g[k]);
                    sum = pool.add(sum, term);
                }
                tidy(pool, sum)
            })
            .collect()
    }
}

/// Per field a component that is 1 there and plainly zero in the others; `None` if there is none.
fn pivots(pool: &Pool, basis: &[Field]) -> Option<Vec<usize>> {
    let n = basis.first()?.len();
    (0..basis.len())
        .map(|i| {
            (0..n).find(|&k| {
                pool.is_one(basis[i][k]) && basis.iter().enumerate().all(|(j, y)| j == i || pool.is_zero(y[k]))
            })
        })
        .collect()
}

/// `z` less the combination of `basis` that has its components at the pivots.
fn modulo(pool: &mut Pool, mut z: Field, basis: &[Field], pivots: &[usize]) -> Field {
    for (y, &p) in basis.iter().zip(pivots) {
        let factor = z[p];
        if pool.is_zero(factor) {
            continue;
        }
        for (a, &b) in z.iter_mut().zip(y) {
            let term = pool.mul(factor, b);
            *a = pool.sub(*a, term);
        }
    }
    z
}
