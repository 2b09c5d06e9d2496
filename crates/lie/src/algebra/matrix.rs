//! Determinants and linear equations with expressions as entries.

use bracketry_symbolic::{Bindings, Expr, Pool, ZeroTest};
use rustc_hash::FxHashMap;

use crate::algebra::rational::readable::tidy;
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
    let Some(first) = rows.first() else { return Ok(0) };
    if first.is_empty() {
        return Ok(0);
    }
    evidence.allow_elimination(rows.len(), first.len())?;
    let rank = pool.rank(rows, bindings)?;
    evidence.add(&rank.certificate);
    Ok(rank.rank)
}

/// The determinant of a square matrix as a readable expression; `None` if it is not square, empty or too large.
pub(crate) fn determinant(pool: &mut Pool, rows: &[Vec<Expr>]) -> Option<Expr> {
    let n = rows.len();
    if n == 0 || n > MAX_SIZE || rows.iter().any(|r| r.len() != n) {
        return None;
    }
    // minors[set of columns]: determinant of the last rows in these columns (Laplace).
    let mut minors: FxHashMap<usize, Expr> = std::iter::once((0, pool.int(1))).collect();
    for row in rows.iter().rev() {
        let mut larger: FxHashMap<usize, Expr> = FxHashMap::default();
        let mut sets: Vec<usize> = minors.keys().copied().collect();
        sets.sort_unstable();
        for set in sets {
            for (j, &entry) in row.iter().enumerate() {
                if set >> j & 1 == 1 || pool.is_zero(entry) {
                    continue;
                }
                let before = (set & ((1 << j) - 1)).count_ones();
                let product = pool.mul(entry, minors[&set]);
                let term = if before % 2 == 0 { product } else { pool.neg(product) };
                let sum = larger.get(&(set | 1 << j)).map_or(term, |&s| pool.add(s, term));
                larger.insert(set | 1 << j, sum);
            }
        }
        let mut done: Vec<(usize, Expr)> = larger.into_iter().collect();
        done.sort_unstable_by_key(|m| m.0);
        minors = done.into_iter().map(|(set, e)| (set, tidy(pool, e))).collect();
    }
    let zero = pool.int(0);
    Some(minors.get(&((1 << n) - 1)).copied().unwrap_or(zero))
}

/// The solution of A x = b for an invertible A (Cramer's rule), as readable expressions.
pub(crate) fn solve(pool: &mut Pool, a: &[Vec<Expr>], b: &[Expr]) -> Option<Vec<Expr>> {
    let d = determinant(pool, a)?;
    if pool.is_zero(d) {
        return None;
    }
    (0..a.len())
        .map(|j| {
            let replaced: Vec<Vec<Expr>> = a
                .iter()
                .zip(b)
                .map(|(row, &b)| row.iter().enumerate().map(|(k, &e)| if k == j { b } else { e }).collect())
                .collect();
            let top = determinant(pool, &replaced)?;
            let x = pool.div(top, d);
            Some(tidy(pool, x))
        })
        .collect()
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
        let p = rows[i][j];
        let unit: Vec<Expr> = rows[i]
            .iter()
            .map(|&e| {
                let q = pool.div(e, p);
                tidy(pool, q)
            })
            .collect();
        for (k, row) in rows.iter_mut().enumerate() {
            if k == i {
                row.clone_from(&unit);
            } else if !pool.is_zero(row[j]) {
                let c = row[j];
                for (e, &u) in row.iter_mut().zip(&unit) {
                    let term = pool.mul(c, u);
                    let difference = pool.sub(*e, term);
                    *e = tidy(pool, difference);
                }
            }
        }
    }
    Ok(rows)
}
