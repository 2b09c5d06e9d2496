//! Inputs that move to one side only, and inputs that balance the drift.

use bracketry_symbolic::{Expr, Function, Pool, Rational};

use crate::algebra::field::VectorFields;
use crate::answer::Answer;
use crate::controllability::balance::balance;
use crate::controllability::decide::decide;
use crate::controllability::holding::{Holding, deviations, holding, points_to_one_side};
use crate::controllability::input_set::InputSet;
use crate::controllability::input_values::{InputValues, Side};
use crate::controllability::linearization::Linearization;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::monotone::monotone_function;
use crate::controllability::necessary::half_space;
use crate::controllability::prolonged::with_integrators;
use crate::controllability::region::Extent;
use crate::controllability::stlc::{Stlc, Verdict};
use crate::error::Error;
use crate::evidence::Evidence;
use crate::options::Limits;
use crate::reason::StlcReason;

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
/// - where constant inputs inside their ranges hold the point, and the system around these is STLC;
/// - where the system is STLC whose one-sided inputs are squares of integrals of free ones (see [`with_integrators`]).
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
    if let Some(reason) = half_space(pool, frame, sides, Extent::LOCAL_HALF_SPACE, evidence)? {
        return Ok(Stlc::new(Verdict::No, reason));
    }
    if points_to_one_side(pool, frame, sides, evidence)? {
        return Ok(Stlc::new(Verdict::No, StlcReason::OneSidedCone));
    }
    if let Some(reason) = monotone_function(pool, frame, sides, Extent::LOCAL_HALF_SPACE, evidence)? {
        return Ok(Stlc::new(Verdict::No, reason));
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
    if let Some(inside) = deviations(pool, frame, sides, evidence)?
        && sides.iter().zip(&inside).all(|(s, u)| s.is_none() || !pool.is_zero(*u))
    {
        // The drift of the frame holds the inputs at the point already.
        let stlc = free(pool, &frame.fields, frame.point(), &inside, limits, evidence)?;
        if stlc.verdict == Verdict::Yes {
            let reason = StlcReason::InsideRanges(Box::new(stlc.reason));
            return Ok(Stlc { reason, ..stlc });
        }
    }
    if let Some(stlc) = with_integrators(pool, frame, sides, limits, evidence)? {
        return Ok(stlc);
    }
    Ok(Stlc::inconclusive(StlcReason::OneSidedOpen))
}

/// The frame at the inputs given with the point, and the sides to which they can move; absent where they lie outside of their
/// ranges.
pub(crate) struct Given<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) sides: Option<&'a [Option<Side>]>,
}

/// STLC around inputs that hold the point, where those given with it do not, lie outside of their ranges or at an end of
/// them; `None` if there is nothing to add to the verdict at the inputs given.
///
/// If no inputs in their ranges hold it, some λ·x rises at a positive rate, with bounded inputs for a short time: no.
/// Inputs that all of these have at one end of their ranges stay one-sided.
pub(crate) fn held(
    pool: &mut Pool,
    system: &VectorFields,
    set: &InputSet<'_>,
    given: &Given<'_>,
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
    let states = given.frame.point();
    let at_rest = given.sides.is_some() && given.frame.is_equilibrium(pool, evidence)?;
    let mut base = None;
    if !at_rest {
        let zeros = vec![pool.int(0); set.names.len()];
        let inputs = balance(pool, system, states, &zeros, evidence)?;
        base = base_at(pool, system, set, states, inputs)?;
    }
    // Where all are inside of their ranges nothing is restricted; else others may be farther inside.
    let mut all_at_ends = true;
    if base.as_ref().is_none_or(|b| b.sides.iter().any(Option::is_some)) {
        match holding(pool, system, set, states, evidence)? {
            Holding::With(inputs) => base = base_at(pool, system, set, states, Some(inputs))?,
            Holding::Never(covector) => return Ok(Some(separated(pool, system, covector))),
            Holding::Open => all_at_ends = false,
        }
    }
    let Some(Base { frame, inputs, sides }) = base else { return Ok(None) };
    if at_rest && given.sides == Some(&sides) {
        return Ok(None);
    }
    let linearization = Linearization::at(pool, &frame, evidence)?;
    let stlc = Stlc::or_inconclusive(decide(pool, &frame, dimension, Some(&linearization), limits, evidence));
    let stlc = one_sided(pool, &frame, &sides, stlc, limits, evidence)?;
    let one_sided = sides.iter().any(Option::is_some);
    match stlc.verdict {
        Verdict::No if one_sided && !all_at_ends => return Ok(None),
        Verdict::Inconclusive if at_rest => return Ok(None),
        _ => {}
    }
    let reason = Box::new(stlc.reason);
    let reason = if at_rest && !one_sided {
        StlcReason::InsideRanges(reason)
    } else {
        let inputs = set.names.iter().zip(&inputs).map(|(n, &u)| (n.clone(), Function::new(pool, u))).collect();
        StlcReason::Around { inputs, reason }
    };
    Ok(Some(Stlc { reason, ..stlc }))
}

/// Inputs that hold the point, and to which sides they can move.
struct Base {
    frame: Frame,
    inputs: Vec<Expr>,
    sides: Vec<Option<Side>>,
}

/// `None` where the inputs do not lie in their ranges.
fn base_at(
    pool: &mut Pool,
    system: &VectorFields,
    set: &InputSet<'_>,
    states: &[Expr],
    inputs: Option<Vec<Expr>>,
) -> Result<Option<Base>, Error> {
    let Some(inputs) = inputs else { return Ok(None) };
    let frame = Frame::new(pool, system, states, &inputs)?;
    let sides = set.sides(pool, &frame, &inputs);
    Ok(sides.map(|sides| Base { frame, inputs, sides }))
}

fn separated(pool: &mut Pool, system: &VectorFields, covector: Vec<Rational>) -> Stlc {
    let mut function = pool.int(0);
    for (&s, c) in system.states.iter().zip(covector) {
        let (s, c) = (pool.sym(s), pool.rational(c));
        let term = pool.mul(c, s);
        function = pool.add(function, term);
    }
    let function = pool.simplify(function);
    Stlc::new(Verdict::No, StlcReason::Separated(Function::new(pool, function)))
}
