//! Maps that are open at a point by their second derivatives.

use bracketry_symbolic::{Expr, Pool, Real, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::combination::real_combination;
use crate::controllability::local_accessibility::Frame;
use crate::evidence::Evidence;
use crate::linear::form::signs;
use crate::linear::matrix::Matrix;

/// Whether the image of `map`, which is 0 where all variables are, covers a neighborhood of 0 because its derivative lacks
/// one dimension, λ·DF = 0, and the form λ·D²F takes both signs on the kernel of DF (Agrachev and Sachkov 2004, theorem 20.3:
/// negative index of ±λ·D²F at least the corank). All numbers are exact.
pub(crate) fn open_by_second_order(
    pool: &mut Pool,
    frame: &Frame,
    map: &[Expr],
    variables: &[Symbol],
    evidence: &mut Evidence,
) -> bool {
    seen(pool, frame, map, variables, evidence).unwrap_or(false)
}

fn seen(pool: &mut Pool, frame: &Frame, map: &[Expr], variables: &[Symbol], evidence: &mut Evidence) -> Option<bool> {
    let zero = pool.int(0);
    let origin: FxHashMap<Expr, Expr> = variables.iter().map(|&s| (pool.sym(s), zero)).collect();
    let n = variables.len();
    let first = pool.jacobian(map, variables).concat();
    let first = pool.substitute_all(&first, &origin);
    let matrix = |list: &[Real]| Matrix::new(list.chunks(n.max(1)).map(<[_]>::to_vec).collect(), n);
    let left = matrix(&frame.reals(pool, &first, evidence)?).transposed().null_space();
    let [lambda] = &left[..] else { return Some(false) };
    let missed = real_combination(pool, map, lambda)?;
    let gradient = pool.gradient(missed, variables);
    let second = pool.jacobian(&gradient, variables).concat();
    // Together once more: numbers of different calls do not belong together.
    let both = [first, pool.substitute_all(&second, &origin)].concat();
    let mut derivative = frame.reals(pool, &both, evidence)?;
    let hessian = matrix(&derivative.split_off(map.len() * n));
    let kernel = matrix(&derivative).null_space();
    let images: Vec<_> = kernel.iter().map(|v| hessian.times(v)).collect();
    let form = Matrix::new(kernel, n);
    let rows = images.iter().map(|image| form.times(image)).collect();
    Some(signs(&Matrix::new(rows, images.len())) == Some((true, true)))
}
