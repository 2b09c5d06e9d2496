//! Quadratic forms of uncontrollable modes that no input lowers.

use bracketry_symbolic::{Echelon, Expr, FieldElement, Function, Pool, Real};
use rustc_hash::FxHashMap;

use crate::algebra::combination::{combination, real_combination, symbols};
use crate::algebra::span::vanishes;
use crate::controllability::linearization::exact_matrices;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::sign::NearOrigin;
use crate::evidence::Evidence;
use crate::linear::form::signs;
use crate::linear::matrix::{Matrix, quotient_by_reachable};
use crate::linear::pencil::semidefinite_combinations;
use crate::reason::StabilizableReason;

/// Most uncontrollable modes.
const MAX_MODES: usize = 4;

/// A form V = yᵀ P y of functions y = W (x − x0) that no input changes at once, with V' ≥ 0 near the point and V > 0 at some points
/// arbitrarily near it: from these, no motion near the point approaches it.
///
/// With y' = Q y to first order, tried are P for which QᵀP + P Q is semidefinite, zero (as of oscillating modes), or 1.
pub(crate) fn growing_form(pool: &mut Pool, frame: &Frame, evidence: &mut Evidence) -> Option<StabilizableReason> {
    let n = frame.fields.states.len();
    let (a, b) = exact_matrices(pool, frame, evidence)?;
    let modes = Echelon::invariant(b.rows(), n, |v| a.times(v)).null_space();
    let k = modes.len();
    if k == 0 || k > MAX_MODES {
        return None;
    }
    let (variables, offsets) = frame.deviations(pool);
    // Coordinates y in place of one deviation each, in which the others do not occur.
    let own = |i: usize| {
        let alone = |&x: &usize| (0..k).all(|l| modes[l][x] == if l == i { Real::ONE } else { Real::ZERO });
        (0..n).find(alone)
    };
    let places: Vec<usize> = (0..k).map(own).collect::<Option<_>>()?;
    let mut straight: FxHashMap<Expr, Expr> = FxHashMap::default();
    for (&place, w) in places.iter().zip(&modes) {
        let y = pool.sym(variables[place]);
        let rest: Vec<Real> = (0..n).map(|x| if places.contains(&x) { Real::ZERO } else { -w[x].clone() }).collect();
        let others = symbols(pool, &variables);
        let others = real_combination(pool, &others, &rest)?;
        straight.insert(y, pool.add(y, others));
    }
    let modal: Vec<Expr> = places.iter().map(|&place| pool.sym(variables[place])).collect();
    let moved = |pool: &mut Pool, field: &[Expr], w: &[Real]| -> Option<Expr> {
        let sum = real_combination(pool, field, w)?;
        let sum = pool.substitute(sum, &offsets);
        Some(pool.substitute(sum, &straight))
    };
    for (g, w) in frame.fields.controls.iter().flat_map(|g| modes.iter().map(move |w| (g, w))) {
        let along = moved(pool, g, w)?;
        if !vanishes(pool, along, &frame.fields.bindings) {
            return None;
        }
    }
    let rates: Vec<Expr> = modes.iter().map(|w| moved(pool, &frame.fields.drift, w)).collect::<Option<_>>()?;
    let near = NearOrigin { frame, variables, everywhere: false };
    for p in forms(&quotient_by_reachable(&a, &b), k) {
        if pool.reached_limit().is_some() {
            return None;
        }
        // V' = 2 yᵀ P y'.
        let Some(rate) = bilinear(pool, &modal, &p, &rates) else { continue };
        let sign = near.sign(pool, rate);
        let opposite = Matrix::new(p.rows().iter().map(|r| r.iter().map(|x| -x).collect()).collect(), k);
        let grows = [(&p, sign), (&opposite, sign.opposite())]
            .into_iter()
            .find(|(p, s)| s.at_least_zero() && signs(p).is_some_and(|(positive, _)| positive));
        if let Some((p, _)) = grows {
            let deviations: Vec<Expr> = (0..n)
                .map(|i| {
                    let x = pool.sym(frame.fields.states[i]);
                    pool.sub(x, frame.point()[i])
                })
                .collect();
            let y: Vec<Expr> = modes.iter().map(|w| real_combination(pool, &deviations, w)).collect::<Option<_>>()?;
            let value = bilinear(pool, &y, p, &y)?;
            return Some(StabilizableReason::Grows { function: Function::new(pool, value) });
        }
    }
    None
}

/// yᵀ P z, expanded; `None` where an entry of P is too long for an expression.
fn bilinear(pool: &mut Pool, y: &[Expr], p: &Matrix<Real>, z: &[Expr]) -> Option<Expr> {
    let pulled: Vec<Expr> = p.rows().iter().map(|row| real_combination(pool, z, row)).collect::<Option<_>>()?;
    let form = combination(pool, y, &pulled);
    Some(pool.expand(form))
}

/// A basis of the symmetric P with QᵀP + P Q = 0, a P with QᵀP + P Q = 1, and others for which that is semidefinite, where Q is rational.
fn forms(q: &Matrix<Real>, k: usize) -> Vec<Matrix<Real>> {
    let places: Vec<(usize, usize)> = (0..k).flat_map(|i| (i..k).map(move |j| (i, j))).collect();
    let symmetric = |c: &[Real]| {
        let mut sum = vec![vec![Real::ZERO; k]; k];
        for (&(i, j), c) in places.iter().zip(c) {
            sum[i][j].clone_from(c);
            sum[j][i].clone_from(c);
        }
        sum
    };
    let changed = |place: usize| {
        let unit: Vec<Real> = (0..places.len()).map(|l| Real::from(i64::from(l == place))).collect();
        let p = symmetric(&unit);
        let product = |i: usize, j: usize| (0..k).fold(Real::ZERO, |s, l| s + &p[i][l] * &q.rows()[l][j]);
        let rows = (0..k).map(|i| (0..k).map(|j| product(i, j) + product(j, i)).collect());
        Matrix::new(rows.collect(), k)
    };
    let changes: Vec<Matrix<Real>> = (0..places.len()).map(changed).collect();
    let rows = places.iter().map(|&(i, j)| {
        let right = if i == j { -Real::ONE } else { Real::ZERO };
        changes.iter().map(|c| c.rows()[i][j].clone()).chain([right]).collect()
    });
    let null = Matrix::new(rows.collect(), places.len() + 1).null_space();
    let rational: Option<Vec<_>> = changes.iter().map(Matrix::rational).collect();
    let others = rational.map_or_else(Vec::new, |changes| semidefinite_combinations(&changes));
    let others = others.into_iter().map(|c| c.into_iter().map(Real::from).collect());
    null.into_iter().chain(others).map(|c: Vec<Real>| Matrix::new(symmetric(&c), k)).collect()
}
