//! Functions of the state that no input lowers, however large it is.

use bracketry_symbolic::{Expr, Function, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::field::{Field, bracket};
use crate::algebra::integrals::search::integrals;
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::vanishes;
use crate::budget::check_growth;
use crate::controllability::function_pencil::combinations;
use crate::controllability::impulses::is_entire;
use crate::controllability::input_values::Side;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::region::{Extent, Region};
use crate::controllability::sign::{NearOrigin, Sign};
use crate::evidence::Evidence;
use crate::reason::{Monotone, StlcReason};
use crate::residues::Fp;
use crate::undecided::Undecided;

/// A function φ with dφ(x0) ≠ 0 that is constant along the fields of the inputs that move to both sides, does not fall along
/// those of the others, and of which φ' + k (φ − φ(x0)) is not negative, or the reverse.
///
/// Then φ(x) ≥ φ(x0) on all that is reached (by Gronwall's inequality), and x0 is no interior point of it, whatever the inputs
/// are: near x0, or however far the state goes. For k = 0, the only one but for [`Region::Level`], φ never falls, or not where the region is.
/// φ is sought among the integrals of the input fields, and of their brackets with the drift, so that it does not depend on
/// the coordinates in which the system is given, and among their combinations whose rates are semidefinite to second order;
/// everywhere it and its rate have to be defined for all states.
pub(crate) fn monotone_function(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    extent: Extent,
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Undecided> {
    let fields = &frame.fields;
    let states = fields.states.clone();
    let free: Vec<Field> =
        fields.controls.iter().zip(sides).filter(|(_, side)| side.is_none()).map(|(g, _)| g.clone()).collect();
    if free.is_empty() {
        return Ok(None);
    }
    let (variables, offsets) = frame.deviations(pool);
    let signs = NearOrigin { frame, variables, everywhere: extent.everywhere };
    let mut functions = candidates(pool, frame, &free, evidence)?;
    functions.extend(combinations(pool, frame, &functions));
    for function in functions {
        let gradient: Field = pool.gradient(function, &states);
        let Ok(slopes) = frame.evaluate(pool, std::slice::from_ref(&gradient), evidence) else { continue };
        let steady = slopes.concat().iter().all(|d| *d == Fp::ZERO);
        let rate = pool.lie_derivative(function, &states, &fields.drift);
        let rate = tidy(pool, rate);
        if steady || extent.everywhere && !is_entire(pool, &[function, rate], &states) {
            continue;
        }
        let at_point = frame.value_at_point(pool, function);
        // Level sets of other functions are no hyperplanes: their rates are looked at on both sides.
        let region = if extent.region == Region::Level { Region::All } else { extent.region };
        let above = pool.sub(function, at_point);
        let moved = pool.substitute(above, &offsets);
        let Some(in_region) = region.coordinates(pool, moved, &signs.variables) else { continue };
        let Some(pushed) = pushes(pool, &signs, function, sides, [&offsets, &in_region]) else { continue };
        let factors =
            if extent.region == Region::Level { factors(pool, &states, function, rate) } else { vec![pool.int(0)] };
        for k in factors {
            let pull = pool.mul(k, above);
            let total = pool.add(rate, pull);
            let total = tidy(pool, total);
            let moved = pool.substitute(total, &offsets);
            let moved = pool.substitute(moved, &in_region);
            let drifts = signs.sign(pool, moved);
            let up = drifts.at_least_zero() && pushed.iter().all(|s| s.at_least_zero());
            let down = drifts.opposite().at_least_zero() && pushed.iter().all(|s| s.opposite().at_least_zero());
            if !extent.region.bars(up, down) {
                continue;
            }
            let change = match (up, down) {
                (true, true) => Monotone::Constant,
                (true, false) => Monotone::Rises,
                _ => Monotone::Falls,
            };
            let one_sided = sides.iter().any(Option::is_some);
            let function = Function::new(pool, function);
            return Ok(Some(StlcReason::HalfSpace { function, change, one_sided }));
        }
    }
    Ok(None)
}

/// The signs of what the inputs add to the rate of the function, by the sides to which they move; `None` where one that moves
/// to both sides adds something.
fn pushes(
    pool: &mut Pool,
    signs: &NearOrigin,
    function: Expr,
    sides: &[Option<Side>],
    maps: [&FxHashMap<Expr, Expr>; 2],
) -> Option<Vec<Sign>> {
    let fields = &signs.frame.fields;
    let mut list = Vec::new();
    for (g, side) in fields.controls.iter().zip(sides) {
        let along = pool.lie_derivative(function, &fields.states, g);
        if vanishes(pool, along, &fields.bindings) {
            continue;
        }
        let along = tidy(pool, along);
        let along = maps.into_iter().fold(along, |along, map| pool.substitute(along, map));
        list.push(match side {
            Some(Side::Above) => signs.sign(pool, along),
            Some(Side::Below) => signs.sign(pool, along).opposite(),
            None => return None,
        });
    }
    Some(list)
}

/// Integrals of these input fields, of these and their brackets with the drift, and so on.
pub(crate) fn candidates(
    pool: &mut Pool,
    frame: &Frame,
    controls: &[Field],
    evidence: &mut Evidence,
) -> Result<Vec<Expr>, Undecided> {
    let fields = &frame.fields;
    let known = [&fields.drift[..], &fields.controls.concat()].concat();
    let (first, mut all) = (pool.len(), Vec::new());
    let (mut distribution, mut last) = (controls.to_vec(), controls.to_vec());
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
