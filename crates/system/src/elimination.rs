//! Gauss–Jordan elimination on matrices of expressions.

use bracketry_symbolic::{Expr, Pool};

/// Scales row `i` to one in column `j` and clears that column in all other rows.
pub(crate) fn eliminate(pool: &mut Pool, rows: &mut [Vec<Expr>], i: usize, j: usize) {
    let leading = rows[i][j];
    for e in &mut rows[i] {
        let quotient = pool.div(*e, leading);
        *e = pool.simplify(quotient);
    }
    let pivot_row = rows[i].clone();
    for (k, row) in rows.iter_mut().enumerate() {
        if k == i || pool.is_zero(row[j]) {
            continue;
        }
        let factor = row[j];
        for (e, &p) in row.iter_mut().zip(&pivot_row) {
            let product = pool.mul(factor, p);
            let difference = pool.sub(*e, product);
            *e = pool.simplify(difference);
        }
    }
}
