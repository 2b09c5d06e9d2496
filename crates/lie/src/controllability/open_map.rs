//! Maps that are open at a point by their second derivatives.

use bracketry_symbolic::{Expr, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::controllability::local_accessibility::Frame;
use crate::linear::form::signs;
use crate::linear::matrix::RationalMatrix;

/// Whether the image of `map`, which is 0 where all variables are, covers a neighborhood of 0 because its derivative lacks
/// one dimension, λ·DF = 0, and the form λ·D²F takes both signs on the kernel of DF (Agrachev and Sachkov 2004, theorem 20.3:
/// negative index of ±λ·D²F at least the corank). All numbers are exact.
pub(crate) fn open_by_second_order(pool: &mut Pool, frame: &Frame, map: &[Expr], variables: &[Symbol]) -> bool {
    seen(pool, frame, map, variables).unwrap_or(false)
}

fn seen(pool: &mut Pool, frame: &Frame, map: &[Expr], variables: &[Symbol]) -> Option<bool> {
    let zero = pool.int(0);
    let origin: FxHashMap<Expr, Expr> = variables.iter().map(|&s| (pool.sym(s), zero)).collect();
    let at_origin = |pool: &mut Pool, rows: Vec<Vec<Expr>>| -> Option<RationalMatrix> {
        let columns = rows.first().map_or(0, Vec::len);
        let flat = pool.substitute_all(&rows.concat(), &origin);
        let flat = frame.rationals(pool, &flat)?;
        Some(RationalMatrix::new(flat.chunks(columns.max(1)).map(<[_]>::to_vec).collect(), columns))
    };
    let first = pool.jacobian(map, variables);
    let derivative = at_origin(pool, first)?;
    let left = derivative.transposed().null_space();
    let [lambda] = &left[..] else { return Some(false) };
    let mut terms = Vec::new();
    for (c, &e) in lambda.iter().zip(map) {
        let c = pool.rational(c.clone());
        terms.push(pool.mul(c, e));
    }
    let missed = pool.sum(terms);
    let gradient = pool.gradient(missed, variables);
    let second = pool.jacobian(&gradient, variables);
    let hessian = at_origin(pool, second)?;
    let kernel = derivative.null_space();
    let images: Vec<_> = kernel.iter().map(|v| hessian.times(v)).collect();
    let form = RationalMatrix::new(kernel, variables.len());
    let rows = images.iter().map(|image| form.times(image)).collect();
    Some(signs(&RationalMatrix::new(rows, images.len())) == Some((true, true)))
}
