//! Determinants and linear equations with expressions as entries.

use bracketry_symbolic::{Bindings, Expr, Pool, ZeroTest};

use crate::algebra::rational::readable::tidy;
use crate::algebra::span::independent_rows;
use crate::budget::check_size;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

/// Larger determinants are not written out.
const MAX_SIZE: usize = 8;

/// Rank of a matrix at a generic point.
pub(crate) fn generic_rank(
    pool: &mut Pool,
    rows: &[Vec<Expr>],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<usize, Undecided> {
    Ok(independent_rows(pool, rows, bindings, evidence)?.len())
}

/// The determinant of a square matrix as a readable expression; `None` if it is not square, empty or too large.
pub(crate) fn determinant(pool: &mut Pool, rows: &[Vec<Expr>]) -> Option<Expr> {
    let n = rows.len();
    if n == 0 || n > MAX_SIZE || rows.iter().any(|r| r.len() != n) {
        return None;
    }
    Some(pool.determinant(rows, tidy))
}

/// The solution of A x = b for an invertible A (Cramer's rule), as readable expressions.
pub(crate) fn solve(pool: &mut Pool, a: &[Vec<Expr>], b: &[Expr]) -> Option<Vec<Expr>> {
    let d = determinant(pool, a)?;
    if pool.is_zero(d) {
        return None;
    }
    let quotients = pool.cramer(a, b, d, tidy);
    Some(quotients.into_iter().map(|x| tidy(pool, x)).collect())
}

/// Independent rows with the same span over the functions, with unit pivots (Gauss–Jordan).
pub(crate) fn reduced(
    pool: &mut Pool,
    rows: &[Vec<Expr>],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Vec<Vec<Expr>>, Undecided> {
    let first = pool.len();
    let mut rows = rows.to_vec();
    let mut pivots: Vec<usize> = Vec::new();
    for i in 0..rows.len() {
        check_size(pool, first)?;
        // The shortest entry that does not vanish.
        let mut order: Vec<(u64, usize)> = rows[i].iter().map(|&e| pool.text_size(e).length).zip(0..).collect();
        order.sort_unstable();
        let mut pivot = None;
        for (_, j) in order {
            if pivots.contains(&j) || pool.is_zero(rows[i][j]) {
                continue;
            }
            match pool.zero_test(rows[i][j], bindings) {
                ZeroTest::NonZero => {
                    pivot = Some(j);
                    break;
                }
                ZeroTest::Zero(certificate) => evidence.add(&certificate),
                ZeroTest::Unknown(why) => return Err(why.into()),
            }
        }
        let Some(j) = pivot else { continue };
        pivots.push(j);
        pool.eliminate_column(&mut rows, (i, j), tidy);
    }
    Ok(rows)
}
