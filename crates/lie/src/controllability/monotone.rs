//! Functions of the state that no input lowers, however large it is.

use bracketry_symbolic::{Expr, Function, Pool, Symbol};

use crate::algebra::field::{Field, bracket};
use crate::algebra::integrals::search::integrals;
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::vanishes;
use crate::budget::check_growth;
use crate::controllability::impulses::is_entire;
use crate::controllability::local::Frame;
use crate::controllability::sign::{NearOrigin, Sign};
use crate::evidence::Evidence;
use crate::reason::{Monotone, StlcReason};
use crate::residues::Fp;
use crate::undecided::Undecided;

/// A function φ with dφ(x0) ≠ 0 that is constant along all input fields and of which φ' + k (φ − φ(x0)) has one sign
/// everywhere, for a constant k.
///
/// If it is not negative, φ(x) ≥ φ(x0) on all that is reached (by Gronwall's inequality), and x0 is no interior point of it,
/// whatever the inputs are and however far the state goes. φ is sought among the integrals of the input fields, and of their
/// brackets with the drift, so that it does not depend on the coordinates in which the system is given; it and its rate have
/// to be defined for all states.
pub(crate) fn monotone_function(
    pool: &mut Pool,
    frame: &Frame,
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Undecided> {
    look(pool, frame, true, evidence)
}

/// A function φ with dφ(x0) ≠ 0 that is constant along all input fields and of which φ' has one sign near x0.
pub(crate) fn monotone_near(
    pool: &mut Pool,
    frame: &Frame,
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Undecided> {
    look(pool, frame, false, evidence)
}

fn look(
    pool: &mut Pool,
    frame: &Frame,
    everywhere: bool,
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Undecided> {
    let fields = &frame.fields;
    let states = fields.states.clone();
    if fields.controls.is_empty() {
        return Ok(None);
    }
    let (variables, offsets) = frame.deviations(pool);
    let signs = NearOrigin { frame, variables, everywhere };
    for function in candidates(pool, frame, evidence)? {
        let gradient: Field = pool.gradient(function, &states);
        let Ok(slopes) = frame.evaluate(pool, std::slice::from_ref(&gradient), evidence) else { continue };
        let steady = slopes.concat().iter().all(|d| *d == Fp::ZERO);
        let mut moved: Vec<bool> = Vec::new();
        for g in &fields.controls {
            let along = pool.lie_derivative(function, &states, g);
            moved.push(!vanishes(pool, along, &fields.bindings));
        }
        let rate = pool.lie_derivative(function, &states, &fields.drift);
        let rate = tidy(pool, rate);
        if steady || moved.contains(&true) || everywhere && !is_entire(pool, &[function, rate], &states) {
            continue;
        }
        let at_point = frame.value_at_point(pool, function);
        let factors = if everywhere { factors(pool, &states, function, rate) } else { vec![pool.int(0)] };
        for k in factors {
            let above = pool.sub(function, at_point);
            let pull = pool.mul(k, above);
            let total = pool.add(rate, pull);
            let total = tidy(pool, total);
            let moved = pool.substitute(total, &offsets);
            let change = match signs.sign(pool, moved) {
                Sign::Zero => Monotone::Constant,
                Sign::Positive | Sign::NonNegative => Monotone::Rises,
                Sign::Negative | Sign::NonPositive => Monotone::Falls,
                Sign::Unknown => continue,
            };
            let function = Function::new(pool, function);
            return Ok(Some(StlcReason::HalfSpace { function, change, one_sided: false }));
        }
    }
    Ok(None)
}

/// Integrals of the input fields, of these and their brackets with the drift, and so on.
fn candidates(pool: &mut Pool, frame: &Frame, evidence: &mut Evidence) -> Result<Vec<Expr>, Undecided> {
    let fields = &frame.fields;
    let known = [&fields.drift[..], &fields.controls.concat()].concat();
    let (first, mut all) = (pool.len(), Vec::new());
    let (mut distribution, mut last) = (fields.controls.clone(), fields.controls.clone());
    for _ in 0..fields.states.len() {
        let found = integrals(pool, &fields.states, &distribution, &known, &fields.bindings, evidence)?;
        if found.functions.is_empty() {
            break;
        }
        all.extend(found.functions.into_iter().filter(|f| !all.contains(f)).collect::<Vec<_>>());
        for y in &mut last {
            check_growth(pool, first, [&fields.drift, y], 1)?;
            *y = bracket(pool, &fields.states, &fields.drift, y);
        }
        distribution.extend(last.iter().cloned());
    }
    Ok(all)
}

/// The constants k that are tried: 0, and those for which φ' + k φ does not depend on one of the states as φ does.
fn factors(pool: &mut Pool, states: &[Symbol], function: Expr, rate: Expr) -> Vec<Expr> {
    let mut all = vec![pool.int(0)];
    for &s in states.iter().filter(|&&s| pool.depends_on(function, s)).collect::<Vec<_>>() {
        let (slope, change) = (pool.diff(function, s), pool.diff(rate, s));
        let ratio = pool.div(change, slope);
        let k = pool.neg(ratio);
        let k = tidy(pool, k);
        if !states.iter().any(|&s| pool.depends_on(k, s)) && !all.contains(&k) {
            all.push(k);
        }
    }
    all
}
