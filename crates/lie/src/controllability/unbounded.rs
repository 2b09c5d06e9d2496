//! Verdicts on inputs without bounds, from those on bounded ones.

use bracketry_symbolic::{Expr, Pool};

use crate::controllability::impulses::surrounded_by_jumps;
use crate::controllability::input_set::InputSet;
use crate::controllability::input_values::Side;
use crate::controllability::linearization::is_linear;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::monotone::monotone_function;
use crate::controllability::necessary::half_space;
use crate::controllability::region::Extent;
use crate::controllability::stlc::{BoundedStlc, Stlc, Verdict};
use crate::evidence::Evidence;
use crate::reason::StlcReason;
use crate::undecided::Undecided;

/// STLC where some inputs have no bounds, from the verdict `stlc` for bounded ones.
///
/// A "yes" holds with fewer inputs already. A "no" rests on fields near the point, where bounded inputs leave the state for a
/// short time; without bounds the state may go far and return. It stays
/// - where the accessibility algebra is not full (Nagano–Sussmann: no input leaves the orbit);
/// - where a half-space is invariant everywhere, or a function of the state that no input moves rises everywhere;
/// - where f is linear, the g_i are constant, and all push to one side: |x − x0| ≤ c Σ∫v_i there, however large the inputs.
///
/// It becomes a yes, as does an inconclusive verdict, where jumps along the input fields surround the point with rates
/// (see [`surrounded_by_jumps`]); else it is inconclusive.
pub(crate) fn unbounded(
    pool: &mut Pool,
    frame: &Frame,
    set: &InputSet<'_>,
    inputs: &[Expr],
    sides: &[Option<Side>],
    stlc: Stlc,
    evidence: &mut Evidence,
) -> Result<Stlc, Undecided> {
    let far = (0..inputs.len()).any(|i| set.reaches_infinity(i));
    if !far || stlc.verdict == Verdict::Yes || matches!(stlc.reason, StlcReason::NotAccessible { .. }) {
        return Ok(stlc);
    }
    let half_space = match set.within_ranges(pool, frame, inputs) {
        Some(moves) => outside(pool, frame, set, inputs, &moves, evidence)?,
        None => half_space(pool, frame, sides, Extent::HALF_SPACE, evidence)?,
    };
    let barrier = match half_space {
        None => monotone_function(pool, frame, sides, Extent::HALF_SPACE, evidence)?,
        found => found,
    };
    if let Some(reason) = barrier {
        return Ok(Stlc { verdict: Verdict::No, reason, ..stlc });
    }
    let bounded = BoundedStlc { verdict: stlc.verdict, reason: stlc.reason.clone() };
    if surrounded_by_jumps(pool, frame, set, inputs) {
        return Ok(Stlc { verdict: Verdict::Yes, reason: StlcReason::Jumps, bounded: Some(bounded), ..stlc });
    }
    let free = (0..inputs.len()).any(|i| set.unbounded(i));
    if !free && matches!(stlc.reason, StlcReason::OneSidedCone) && is_linear(pool, &frame.fields) {
        return Ok(stlc);
    }
    if stlc.verdict == Verdict::No {
        let reason = StlcReason::Unbounded;
        return Ok(Stlc { verdict: Verdict::Inconclusive, reason, bounded: Some(bounded), ..stlc });
    }
    Ok(stlc)
}

/// An invariant half-space where the inputs at the point do not lie in their ranges, from inputs moved into these.
fn outside(
    pool: &mut Pool,
    frame: &Frame,
    set: &InputSet<'_>,
    inputs: &[Expr],
    moves: &[Expr],
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Undecided> {
    let moved: Vec<Expr> = inputs.iter().zip(moves).map(|(&u, &d)| pool.add(u, d)).collect();
    let Ok(inside) = Frame::new(pool, &frame.fields, frame.point(), moves) else { return Ok(None) };
    match set.sides(pool, frame, &moved) {
        Some(sides) => half_space(pool, &inside, &sides, Extent::HALF_SPACE, evidence),
        None => Ok(None),
    }
}
