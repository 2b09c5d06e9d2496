//! Inputs that move to one side only, and inputs that balance the drift.

use bracketry_symbolic::{Bindings, Expr, Function, Pool, ZeroTest};
use nalgebra::DVector;
use rustc_hash::FxHashMap;

use crate::algebra::field::VectorFields;
use crate::answer::Answer;
use crate::controllability::input_set::InputSet;
use crate::controllability::input_values::{InputValues, Side};
use crate::controllability::linearization::Linearization;
use crate::controllability::local::Frame;
use crate::controllability::necessary::half_space;
use crate::controllability::stlc::{Stlc, Verdict, decide};
use crate::error::Error;
use crate::evidence::Evidence;
use crate::options::Limits;
use crate::reason::StlcReason;
use crate::residues::{Echelon, Fp};

/// STLC of the system around the point with these inputs there, all free to move.
pub(crate) fn free(
    pool: &mut Pool,
    system: &VectorFields,
    states: &[Expr],
    inputs: &[Expr],
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Stlc, Error> {
    let frame = Frame::new(pool, system, states, inputs)?;
    let all = system.accessibility(pool, evidence)?;
    let strong = system.strong_accessibility(pool, evidence)?;
    let local = frame.accessibility(pool, &all, &strong, limits, evidence)?;
    let linearization =
        if frame.is_equilibrium(pool, evidence)? { Some(Linearization::at(pool, &frame, evidence)?) } else { None };
    Ok(Stlc::or_inconclusive(decide(pool, &frame, &local.dimension, linearization.as_ref(), limits, evidence)))
}

/// STLC where some inputs move to one side only, given the verdict `unrestricted` for free inputs.
///
/// No:
/// - where free inputs do not suffice;
/// - where a half-space is invariant under the inputs that are allowed;
/// - where every input moves to one side only, unless its field vanishes at the point, and some λ
///   is positive on all their fields there: then λ·x ≥ (c − c'T) Σ∫v_i ≥ 0 for small T.
///
/// Yes:
/// - where the inputs that are free to both sides suffice;
/// - where constant inputs inside their ranges hold the point, and the system around these is STLC.
pub(crate) fn one_sided(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    unrestricted: Stlc,
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Stlc, Error> {
    if unrestricted.verdict == Verdict::No || sides.iter().all(Option::is_none) {
        return Ok(unrestricted);
    }
    if !frame.is_equilibrium(pool, evidence)? {
        return Ok(Stlc::inconclusive(StlcReason::OneSidedNoEquilibrium));
    }
    if let Some(reason) = half_space(pool, frame, sides, false, evidence)? {
        return Ok(Stlc::new(Verdict::No, reason));
    }
    if points_to_one_side(pool, frame, sides, evidence)? {
        return Ok(Stlc::new(Verdict::No, StlcReason::OneSidedCone));
    }
    let free_inputs: Vec<usize> = (0..sides.len()).filter(|&i| sides[i].is_none()).collect();
    if !free_inputs.is_empty() {
        // The others stay where they are, as part of the drift.
        let mut rest = frame.fields.clone();
        rest.controls = free_inputs.iter().map(|&i| frame.fields.controls[i].clone()).collect();
        let zeros = vec![pool.int(0); free_inputs.len()];
        let stlc = free(pool, &rest, frame.point(), &zeros, limits, evidence)?;
        if stlc.verdict == Verdict::Yes {
            let reason = StlcReason::TwoSidedInputs(Box::new(stlc.reason));
            return Ok(Stlc { reason, ..stlc });
        }
    }
    if let Some(inside) = inside_ranges(pool, frame, sides, evidence)? {
        // The drift of the frame holds the inputs at the point already.
        let stlc = free(pool, &frame.fields, frame.point(), &inside, limits, evidence)?;
        if stlc.verdict == Verdict::Yes {
            let reason = StlcReason::InsideRanges(Box::new(stlc.reason));
            return Ok(Stlc { reason, ..stlc });
        }
    }
    Ok(Stlc::inconclusive(StlcReason::OneSidedOpen))
}

/// Rounds of a search by perceptron.
const ROUNDS: usize = 1000;

fn points_to_one_side(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    evidence: &mut Evidence,
) -> Result<bool, Error> {
    let n = frame.fields.states.len();
    let exact = frame.evaluate(pool, &frame.fields.controls, evidence)?;
    let Some(values) = frame.numbers(pool, &frame.fields.controls.concat()) else { return Ok(false) };
    let mut directions = Vec::new();
    for ((exact, value), side) in exact.iter().zip(values.chunks(n)).zip(sides) {
        if exact.iter().all(|x| *x == Fp::ZERO) {
            continue;
        }
        let (Some(side), v) = (side, DVector::from_column_slice(value)) else { return Ok(false) };
        if v.norm() == 0.0 {
            return Ok(false);
        }
        directions.push(v.normalize() * side.sign() as f64);
    }
    let mut lambda: DVector<f64> = directions.iter().fold(DVector::zeros(n), |s, v| s + v);
    for _ in 0..ROUNDS {
        match directions.iter().find(|v| lambda.dot(v) <= 1e-6 * lambda.norm()) {
            None => return Ok(true),
            Some(v) => lambda += v,
        }
    }
    Ok(false)
}

/// Largest numerator and denominator of constant inputs; most vectors that are combined.
const BOUND: u64 = 1 << 16;
const MAX_COMBINED: usize = 4;

/// Deviations of the inputs, strictly inside the one-sided ranges, that leave the state at rest.
fn inside_ranges(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    evidence: &mut Evidence,
) -> Result<Option<Vec<Expr>>, Error> {
    let (n, m) = (frame.fields.states.len(), sides.len());
    let values = frame.evaluate(pool, &frame.fields.controls, evidence)?;
    let rows: Vec<Vec<Fp>> = (0..n).map(|c| values.iter().map(|v| v[c]).collect()).collect();
    let annihilator: Option<Vec<Vec<(i64, i64)>>> =
        Echelon::new(&rows, m).nullspace().iter().map(|v| v.iter().map(|x| x.to_fraction(BOUND)).collect()).collect();
    let Some(annihilator) = annihilator.filter(|k| k.len() <= MAX_COMBINED) else { return Ok(None) };
    for code in 0..3usize.pow(annihilator.len() as u32) {
        let factors: Vec<i64> = (0..annihilator.len() as u32).map(|k| (code / 3usize.pow(k) % 3) as i64 - 1).collect();
        let inside = |i: usize| {
            let sum: f64 =
                annihilator.iter().zip(&factors).map(|(v, &c)| c as f64 * v[i].0 as f64 / v[i].1 as f64).sum();
            sides[i].is_none_or(|s| sum * s.sign() as f64 > 1e-9)
        };
        if !(0..m).all(inside) {
            continue;
        }
        let mut found = Vec::new();
        for i in 0..m {
            let terms: Vec<Expr> =
                annihilator.iter().zip(&factors).map(|(v, &c)| pool.ratio(c * v[i].0, v[i].1)).collect();
            found.push(pool.sum(terms));
        }
        return Ok(Some(found));
    }
    Ok(None)
}

/// Inputs, as expressions of parameters, for which the state rests at the point: f + Σ u_i g_i = 0
/// there, with 0 for inputs that are not needed. `None` if there are none.
pub(crate) fn balance(
    pool: &mut Pool,
    system: &VectorFields,
    states: &[Expr],
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
    let mut inputs = vec![zero; m];
    for &(r, column) in &pivots {
        let quotient = pool.div(rows[r][m], rows[r][column]);
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

/// STLC around the inputs that balance the drift at a point that is no equilibrium for the inputs
/// given with it; `None` if no inputs do within their ranges.
pub(crate) fn balanced(
    pool: &mut Pool,
    system: &VectorFields,
    set: &InputSet<'_>,
    states: &[Expr],
    dimension: &Answer<usize>,
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Option<Stlc>, Error> {
    // What is said of an input at the point says nothing of it at other values.
    let open = |(v, s): (&Option<InputValues>, &Option<Side>)| match v {
        Some(InputValues::Between(..)) => false,
        Some(InputValues::Unknown) => true,
        None => s.is_some(),
    };
    if set.values.iter().zip(&set.one_sided).any(open) {
        return Ok(None);
    }
    let Some(inputs) = balance(pool, system, states, evidence)? else { return Ok(None) };
    let frame = Frame::new(pool, system, states, &inputs)?;
    let Some(sides) = set.sides(pool, &frame, &inputs) else { return Ok(None) };
    let linearization = Linearization::at(pool, &frame, evidence)?;
    let stlc = Stlc::or_inconclusive(decide(pool, &frame, dimension, Some(&linearization), limits, evidence));
    let stlc = one_sided(pool, &frame, &sides, stlc, limits, evidence)?;
    // Other inputs, farther on in their ranges, may hold the point as well.
    if stlc.verdict == Verdict::No && sides.iter().any(Option::is_some) {
        return Ok(None);
    }
    let inputs = set.names.iter().zip(&inputs).map(|(n, &u)| (n.clone(), Function::new(pool, u))).collect();
    let reason = StlcReason::Around { inputs, reason: Box::new(stlc.reason) };
    Ok(Some(Stlc { reason, ..stlc }))
}
