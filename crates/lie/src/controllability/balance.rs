//! Inputs that balance the drift.

use bracketry_symbolic::{Bindings, Expr, Pool, ZeroTest};
use rustc_hash::FxHashMap;

use crate::algebra::field::VectorFields;
use crate::controllability::local_accessibility::Frame;
use crate::error::Error;
use crate::evidence::Evidence;

/// Inputs, as expressions of parameters, for which the state rests at the point: f + Σ u_i g_i = 0
/// there, with the values `chosen` for inputs that are not needed. `None` if there are none.
pub(crate) fn balance(
    pool: &mut Pool,
    system: &VectorFields,
    states: &[Expr],
    chosen: &[Expr],
    evidence: &mut Evidence,
) -> Result<Option<Vec<Expr>>, Error> {
    let m = system.controls.len();
    let zero = pool.int(0);
    let at: FxHashMap<Expr, Expr> = system.states.iter().zip(states).map(|(&s, &v)| (pool.sym(s), v)).collect();
    let mut columns: Vec<Vec<Expr>> = Vec::new();
    for field in system.controls.iter().chain(std::iter::once(&system.drift)) {
        columns.push(pool.substitute_all(field, &at));
    }
    // Rows of (g_1 … g_m | f) at the point, eliminated with exact tests for pivots.
    let mut rows: Vec<Vec<Expr>> = (0..system.states.len()).map(|c| columns.iter().map(|v| v[c]).collect()).collect();
    let mut pivots: Vec<(usize, usize)> = Vec::new();
    for column in 0..m {
        let next = pivots.len();
        let mut pivot = None;
        for (r, row) in rows.iter().enumerate().skip(next) {
            match nonzero(pool, row[column], &system.bindings) {
                Some(true) => {
                    pivot = Some(r);
                    break;
                }
                Some(false) => {}
                None => return Ok(None),
            }
        }
        let Some(pivot) = pivot else { continue };
        rows.swap(next, pivot);
        let head = rows[next].clone();
        for (r, row) in rows.iter_mut().enumerate() {
            if r == next || pool.is_zero(row[column]) {
                continue;
            }
            let factor = pool.div(row[column], head[column]);
            for (x, &h) in row.iter_mut().zip(&head) {
                let product = pool.mul(factor, h);
                *x = pool.sub(*x, product);
            }
            row[column] = zero;
        }
        pivots.push((next, column));
    }
    let mut inputs = chosen.to_vec();
    let others: Vec<usize> = (0..m).filter(|j| pivots.iter().all(|p| p.1 != *j)).collect();
    for &(r, column) in &pivots {
        let mut right = rows[r][m];
        for &j in &others {
            let term = pool.mul(rows[r][j], chosen[j]);
            right = pool.add(right, term);
        }
        let quotient = pool.div(right, rows[r][column]);
        let value = pool.neg(quotient);
        inputs[column] = pool.simplify(value);
    }
    let frame = Frame::new(pool, system, states, &inputs)?;
    Ok(frame.is_equilibrium(pool, evidence)?.then_some(inputs))
}

fn nonzero(pool: &mut Pool, e: Expr, bindings: &Bindings) -> Option<bool> {
    if pool.is_zero(e) {
        return Some(false);
    }
    match pool.zero_test(e, bindings) {
        ZeroTest::Zero(_) => Some(false),
        ZeroTest::NonZero => Some(true),
        ZeroTest::Unknown(_) => None,
    }
}
