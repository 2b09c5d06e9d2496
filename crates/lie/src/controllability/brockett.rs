//! Brockett's necessary condition for stabilization by continuous state feedback.

use bracketry_symbolic::{Expr, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::span::vanishes;
use crate::algebra::subsets::subsets;
use crate::answer::Answer;
use crate::controllability::linearization::Linearization;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::local_degree::has_local_degree;
use crate::controllability::open_map::open_by_second_order;
use crate::controllability::sign::{NearOrigin, Sign};
use crate::evidence::Evidence;
use crate::linear::taylor::{Terms, is_analytic};
use crate::reason::Reason;
use crate::residues::{Echelon, Fp};
use crate::undecided::Undecided;

/// Most sets of variables that are tried.
const MAX_SETS: usize = 2000;
/// Most variables in such a set.
const MAX_SIZE: usize = 6;

/// Whether the image of (x, u) ↦ f(x) + Σ u_i g_i(x) near the equilibrium covers a neighborhood of
/// 0, which stabilization by continuous feedback of the state needs (Brockett 1983, theorem 1 (iii)).
///
/// - [A B] of full rank: true (the map is a submersion there).
/// - Components R with invertible Jacobian in as many of the variables (x, u) that vanish where
///   these variables rest at their values: then R = 0 only there. Where another component
///   vanishes too, or keeps one sign, the vectors along it (or against that sign) are not in the
///   image: false.
/// - The input fields span the drift and have a constant rank below n: false (Brockett's corollary, after feedback).
/// - A derivative that lacks one dimension, in which the second derivatives take both signs: true ([`open_by_second_order`]).
/// - Polynomial components that, of n of the variables while the others rest, have a local degree different from zero:
///   true ([`has_local_degree`]).
/// - Other equilibria arbitrarily near, at which the derivative has full rank: true ([`regular_nearby`]).
pub(crate) fn brockett_condition(
    pool: &mut Pool,
    frame: &Frame,
    linearization: &Linearization,
    evidence: &mut Evidence,
) -> Answer<bool> {
    match decide(pool, frame, linearization, evidence) {
        Ok(Some(holds)) => Answer::Known(holds),
        Ok(None) => Answer::Unknown(Reason::NoSubmersion),
        Err(why) => Answer::Unknown(why.into()),
    }
}

fn decide(
    pool: &mut Pool,
    frame: &Frame,
    linearization: &Linearization,
    evidence: &mut Evidence,
) -> Result<Option<bool>, Undecided> {
    let fields = &frame.fields;
    let (n, m) = (fields.states.len(), fields.controls.len());
    // Columns of [A B].
    let mut span = Echelon::new(&linearization.b, n);
    for j in 0..n {
        span.insert(linearization.a.iter().map(|row| row[j]).collect());
    }
    if span.rank() == n {
        return Ok(Some(true));
    }
    if m > 0 {
        let mut all = fields.controls.clone();
        all.push(fields.drift.clone());
        let generic = pool.rank(&all, &fields.bindings)?;
        evidence.add(&generic.certificate);
        if generic.rank < n && Echelon::new(&linearization.b, n).rank() == generic.rank {
            return Ok(Some(false));
        }
    }
    // F as a function of deviations from the point, one symbol for each state and input.
    let (mut variables, offsets) = frame.deviations(pool);
    let mut image = pool.substitute_all(&fields.drift, &offsets);
    for (i, g) in fields.controls.iter().enumerate() {
        let u = pool.symbol(&format!("offset of input {i}"));
        variables.push(u);
        let u = pool.sym(u);
        for (e, c) in image.iter_mut().zip(pool.substitute_all(g, &offsets)) {
            let term = pool.mul(u, c);
            *e = pool.add(*e, term);
        }
    }
    let jacobian: Vec<Vec<_>> = (0..n)
        .map(|i| {
            let row = linearization.a[i].iter().copied();
            row.chain(linearization.b.iter().map(|b| b[i])).collect()
        })
        .collect();
    if misses_a_direction(pool, frame, &image, &variables, &jacobian) {
        return Ok(Some(false));
    }
    let covered = open_by_second_order(pool, frame, &image, &variables, evidence)
        || covers(pool, frame, &image, &variables, evidence)
        || regular_nearby(pool, frame, &image, &variables, evidence)?;
    Ok(covered.then_some(true))
}

/// Whether components vanish only where others vanish too or keep a sign.
fn misses_a_direction(
    pool: &mut Pool,
    frame: &Frame,
    image: &[Expr],
    variables: &[Symbol],
    jacobian: &[Vec<Fp>],
) -> bool {
    let (n, fields) = (image.len(), &frame.fields);
    let near = NearOrigin { frame, variables: variables.to_vec(), everywhere: false };
    let zero = pool.int(0);
    let mut tried = 0;
    for size in 0..=MAX_SIZE.min(n - 1) {
        for set in subsets(variables.len(), size) {
            tried += 1;
            if tried > MAX_SETS {
                return false;
            }
            let at_rest: FxHashMap<Expr, Expr> = set.iter().map(|&i| (pool.sym(variables[i]), zero)).collect();
            let rest = pool.substitute_all(image, &at_rest);
            let vanishing: Vec<usize> = (0..n).filter(|&i| vanishes(pool, rest[i], &fields.bindings)).collect();
            if vanishing.len() < size {
                continue;
            }
            let rows: Vec<Vec<_>> = vanishing.iter().map(|&i| set.iter().map(|&j| jacobian[i][j]).collect()).collect();
            if Echelon::new(&rows, n).rank() < size {
                continue;
            }
            if vanishing.len() > size {
                return true;
            }
            for i in (0..n).filter(|i| !vanishing.contains(i)) {
                if near.sign(pool, rest[i]) != Sign::Unknown {
                    return true;
                }
            }
        }
    }
    false
}

/// Whether the image of polynomial components, of n of the variables, is seen to cover a neighborhood of 0.
fn covers(pool: &mut Pool, frame: &Frame, image: &[Expr], variables: &[Symbol], evidence: &mut Evidence) -> bool {
    let mut map = Vec::new();
    for &e in image {
        let e = frame.constants_in(pool, e);
        let Some(terms) = Terms::of(pool, e, variables) else { return false };
        map.push(terms);
    }
    let Some(map) = Terms::with_values(pool, &map, evidence) else { return false };
    if map.iter().any(|p| p.order() == 0) {
        return false;
    }
    for set in subsets(variables.len(), map.len()).take(MAX_SETS) {
        let at_rest: Vec<usize> = (0..variables.len()).filter(|i| !set.contains(i)).collect();
        if has_local_degree(map.iter().map(|p| p.without(&at_rest)).collect(), set) {
            return true;
        }
    }
    false
}

/// Whether the components vanish together where some of the variables do, and their Jacobian has full rank at almost all of these
/// points: near each of them, and so arbitrarily near the point, the map is open.
fn regular_nearby(
    pool: &mut Pool,
    frame: &Frame,
    image: &[Expr],
    variables: &[Symbol],
    evidence: &mut Evidence,
) -> Result<bool, Undecided> {
    let (zero, bindings) = (pool.int(0), &frame.fields.bindings);
    let origin: FxHashMap<Expr, Expr> = variables.iter().map(|&s| (pool.sym(s), zero)).collect();
    for &e in image {
        let e = frame.constants_in(pool, e);
        if !is_analytic(pool, e, &origin) {
            return Ok(false);
        }
    }
    let jacobian = pool.jacobian(image, variables);
    let sets = (1..variables.len().min(MAX_SIZE + 1)).flat_map(|size| subsets(variables.len(), size));
    for set in sets.take(MAX_SETS) {
        let at_rest: FxHashMap<Expr, Expr> = set.iter().map(|&i| (pool.sym(variables[i]), zero)).collect();
        if !pool.substitute_all(image, &at_rest).into_iter().all(|e| vanishes(pool, e, bindings)) {
            continue;
        }
        let rows: Vec<Vec<Expr>> = jacobian.iter().map(|row| pool.substitute_all(row, &at_rest)).collect();
        let generic = pool.rank(&rows, bindings)?;
        evidence.add(&generic.certificate);
        if generic.rank == image.len() {
            return Ok(true);
        }
    }
    Ok(false)
}
