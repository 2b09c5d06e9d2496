//! Half-spaces that no mode leaves, at a point where switching functions vanish.

use bracketry_symbolic::{Expr, Function, Node, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::combination::{combination, symbols};
use crate::algebra::field::Field;
use crate::algebra::integrals::search::integrals;
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::vanishes;
use crate::controllability::input_values::Side;
use crate::controllability::meeting::{Adjacent, AtSwitchPoint, change, input_set};
use crate::controllability::region::{Extent, Region};
use crate::controllability::sign::{NearOrigin, Sign};
use crate::evidence::Evidence;
use crate::linear::taylor::is_analytic;
use crate::reason::StlcReason;
use crate::residues::{Echelon, Fp, OFFSET};
use crate::undecided::Undecided;

/// A linear function, or an integral of all input fields, that can change to one side only in each of these modes, those that
/// meet at the point or all.
///
/// In a mode the switching functions that are told have their signs. Where such an s is affine in a coordinate, the
/// coordinate is replaced by what makes s = ±q², so that the sign of what depends on s is that of q².
pub(crate) fn half_space_of_modes(
    pool: &mut Pool,
    given: &AtSwitchPoint,
    modes: &[Adjacent],
    extent: Extent,
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Undecided> {
    let Some(first) = modes.first() else { return Ok(None) };
    let set = input_set(given);
    let Some(sides) = set.sides(pool, &first.frame, &given.point.inputs) else { return Ok(None) };
    if extent.region == Region::Level && !modes.iter().all(|a| is_lipschitz(pool, a, extent.everywhere)) {
        return Ok(None);
    }
    let one_sided = sides.iter().any(Option::is_some);
    let linear = covectors(pool, modes, evidence)?;
    let states = symbols(pool, &first.fields.states);
    let mut as_function = |c: &[Expr]| {
        let sum = combination(pool, &states, c);
        pool.simplify(sum)
    };
    let linear: Vec<(Expr, Option<&[Expr]>)> = linear.iter().map(|c| (as_function(c), Some(&c[..]))).collect();
    let integrals = integrals_of_all(pool, modes, evidence)?;
    for (function, covector) in linear.into_iter().chain(integrals.into_iter().map(|f| (f, None))) {
        if let Some(limit) = pool.reached_limit() {
            return Err(limit.into());
        }
        let (mut up, mut down) = (true, true);
        for mode in modes {
            for sign in signs(pool, mode, function, covector, extent, &sides) {
                up &= sign.at_least_zero();
                down &= sign.opposite().at_least_zero();
            }
            if !up && !down {
                break;
            }
        }
        if up || down {
            let function = Function::new(pool, function);
            return Ok(Some(StlcReason::HalfSpace { function, change: change(up, down), one_sided }));
        }
    }
    Ok(None)
}

/// Functions with nonzero gradient at the point that are constant along all input fields of all modes, and not linear.
fn integrals_of_all(pool: &mut Pool, modes: &[Adjacent], evidence: &mut Evidence) -> Result<Vec<Expr>, Undecided> {
    let Some(first) = modes.first() else { return Ok(Vec::new()) };
    let (states, bindings) = (&first.fields.states, &first.fields.bindings);
    let mut controls: Vec<Field> = Vec::new();
    for g in modes.iter().flat_map(|a| &a.fields.controls) {
        if !controls.contains(g) {
            controls.push(g.clone());
        }
    }
    // Between modes the integrals of one are those of all, or there are none.
    if controls.is_empty() || controls.len() >= states.len() {
        return Ok(Vec::new());
    }
    let found = integrals(pool, states, &controls, &controls.concat(), bindings, evidence)?;
    let mut list = Vec::new();
    for f in found.functions {
        let gradient: Field = pool.gradient(f, states);
        let constant = !pool.symbols_of(&gradient).iter().any(|s| states.contains(s));
        let Ok(slopes) = first.frame.evaluate(pool, std::slice::from_ref(&gradient), evidence) else { continue };
        if !constant && slopes.concat().iter().any(|d| *d != Fp::ZERO) {
            list.push(f);
        }
    }
    Ok(list)
}

/// The signs of the rate of a function along the drift and, by the sides to which they move, of what the inputs add, in one
/// mode. The function is λ·x, or constant along all input fields; then its level set is no hyperplane, and the signs are
/// looked for on both sides of it.
fn signs(
    pool: &mut Pool,
    mode: &Adjacent,
    function: Expr,
    covector: Option<&[Expr]>,
    extent: Extent,
    sides: &[Option<Side>],
) -> Vec<Sign> {
    let bindings = &mode.fields.bindings;
    let (mut variables, offsets) = mode.frame.deviations(pool);
    let mut steps: Vec<FxHashMap<Expr, Expr>> = vec![offsets];
    if extent.region == Region::Level
        && let Some(covector) = covector
        && let Some(last) = covector.iter().rposition(|c| !pool.is_zero(*c))
    {
        // On the hyperplane the last coordinate is a combination of the others.
        let mut solved = pool.int(0);
        for i in (0..covector.len()).filter(|&i| i != last) {
            let quotient = pool.div(covector[i], covector[last]);
            let y = pool.sym(variables[i]);
            let term = pool.mul(quotient, y);
            solved = pool.sub(solved, term);
        }
        steps.push(std::iter::once((pool.sym(variables[last]), solved)).collect());
    }
    let states = variables.clone();
    let mut used: Vec<Symbol> = Vec::new();
    for (k, &(s, sign)) in mode.vanishing.iter().enumerate() {
        let s = steps.iter().fold(s, |s, map| pool.substitute(s, map));
        let root = pool.symbol(&format!("root of switch {k}"));
        let square = pool.sym(root);
        let square = pool.powi(square, 2);
        let target = if sign > 0 { square } else { pool.neg(square) };
        let solved = states.iter().filter(|x| !used.contains(x)).find_map(|&x| {
            let slope = pool.diff(s, x);
            let slope = pool.simplify(slope);
            let constant = !pool.symbols_of(&[slope]).iter().any(|y| variables.contains(y));
            if !constant || vanishes(pool, slope, bindings) {
                return None;
            }
            let (zero, of_x) = (pool.int(0), pool.sym(x));
            let rest = pool.substitute(s, &std::iter::once((of_x, zero)).collect());
            let gap = pool.sub(target, rest);
            let value = pool.div(gap, slope);
            Some((x, of_x, pool.expand(value)))
        });
        // Without it less is known of the mode, which is no harm.
        if let Some((x, of_x, value)) = solved {
            used.push(x);
            variables.push(root);
            steps.push(std::iter::once((of_x, value)).collect());
        }
    }
    let near = NearOrigin { frame: &mode.frame, variables, everywhere: extent.everywhere };
    let sign = |pool: &mut Pool, field: &Field| {
        let rate = pool.lie_derivative(function, &mode.fields.states, field);
        let rate = if covector.is_none() { tidy(pool, rate) } else { rate };
        let moved = steps.iter().fold(rate, |e, map| pool.substitute(e, map));
        if vanishes(pool, moved, bindings) {
            return Sign::Zero;
        }
        match near.sign(pool, moved) {
            Sign::Unknown => by_switches(pool, mode, &near, rate, &steps[0]),
            seen => seen,
        }
    };
    let mut list = vec![sign(pool, &mode.frame.fields.drift)];
    for (g, side) in mode.frame.fields.controls.iter().zip(sides) {
        let of_input = sign(pool, g);
        list.push(match side {
            Some(Side::Above) => of_input,
            Some(Side::Below) => of_input.opposite(),
            None if of_input == Sign::Zero => of_input,
            None => Sign::Unknown,
        });
    }
    list
}

/// The sign of a rate that is a multiple of a switching function, by the sign of that function in the mode.
fn by_switches(
    pool: &mut Pool,
    mode: &Adjacent,
    near: &NearOrigin,
    rate: Expr,
    offsets: &FxHashMap<Expr, Expr>,
) -> Sign {
    let states = &mode.fields.states;
    let at: FxHashMap<Expr, Expr> = states.iter().zip(mode.frame.point()).map(|(&s, &v)| (pool.sym(s), v)).collect();
    for &(switch, side) in &mode.vanishing {
        let quotient = pool.div(rate, switch);
        let quotient = tidy(pool, quotient);
        // The quotient with one that is no factor has a pole where the switching function vanishes.
        if !is_analytic(pool, quotient, &at) {
            continue;
        }
        let moved = pool.substitute(quotient, offsets);
        let switch = if side > 0 { Sign::NonNegative } else { Sign::NonPositive };
        let sign = near.sign(pool, moved).times(switch);
        if sign != Sign::Unknown {
            return sign;
        }
    }
    Sign::Unknown
}

/// Whether no root in the fields has a base that vanishes at the point, or that may vanish anywhere. With such a root, solutions may leave a half-space
/// though they are tangent to its boundary.
pub(crate) fn is_lipschitz(pool: &mut Pool, mode: &Adjacent, everywhere: bool) -> bool {
    let mut roots = mode.frame.fields.controls.concat();
    roots.extend(&mode.frame.fields.drift);
    let states = &mode.fields.states;
    let at: FxHashMap<Expr, Expr> = states.iter().zip(mode.frame.point()).map(|(&s, &v)| (pool.sym(s), v)).collect();
    for e in pool.reachable(&roots) {
        let Node::Pow(base, exponent) = pool.node(e) else { continue };
        if pool.integer(exponent).is_some() {
            continue;
        }
        if everywhere && states.iter().any(|&s| pool.depends_on(base, s)) {
            return false;
        }
        let base = pool.substitute(base, &at);
        if mode.frame.numbers(pool, &[base]).is_none_or(|v| v[0].abs() < CLEAR) {
            return false;
        }
    }
    true
}

/// Values nearer to zero count as zero.
const CLEAR: f64 = 1e-9;
/// Seed of the points at which constant covectors are sought; largest numerator and denominator in them.
const SEED: u64 = 0x6272_6163_6b65_7413;
const BOUND: u64 = 1 << 16;

/// The coordinates, and constant combinations that annihilate every input field of every mode.
fn covectors(pool: &mut Pool, modes: &[Adjacent], evidence: &mut Evidence) -> Result<Vec<Vec<Expr>>, Undecided> {
    let Some(first) = modes.first() else { return Ok(Vec::new()) };
    let n = first.fields.states.len();
    let (zero, one) = (pool.int(0), pool.int(1));
    let unit = |i: usize| -> Vec<Expr> { (0..n).map(|j| if i == j { one } else { zero }).collect() };
    let mut all: Vec<Vec<Expr>> = (0..n).map(unit).collect();
    let controls: Vec<Expr> = modes.iter().flat_map(|a| a.fields.controls.concat()).collect();
    if controls.is_empty() {
        return Ok(all);
    }
    let samples = pool.sample_in::<OFFSET>(&controls, &first.fields.bindings, n + 1, SEED)?;
    evidence.add_rank(&samples, n)?;
    let rows: Vec<Vec<Fp>> = samples.values.iter().flat_map(|v| v.chunks(n).map(<[Fp]>::to_vec)).collect();
    for covector in Echelon::new(&rows, n).null_space() {
        let Some(rational) = covector.iter().map(|c| c.to_rational(BOUND)).collect::<Option<Vec<_>>>() else {
            continue;
        };
        let covector: Vec<Expr> = rational.into_iter().map(|c| pool.rational(c)).collect();
        if !all.contains(&covector) {
            all.push(covector);
        }
    }
    Ok(all)
}
