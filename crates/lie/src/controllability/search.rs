//! The search for weights and inputs with which Sussmann's condition holds.

use bracketry_symbolic::Pool;

use crate::controllability::canceling_brackets::canceling;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::stlc::{GeneralCondition, Stlc, Verdict};
use crate::controllability::sussmann::{Brackets, Inputs, Outcome, choices, shortened};
use crate::evidence::Evidence;
use crate::options::Limits;
use crate::reason::StlcReason;
use crate::undecided::Undecided;

/// Greatest depth of the chains whose second-order brackets are canceled.
const MAX_CANCELED: usize = 2;

/// Sussmann's condition for all weights that are tried, and where inputs can be chosen so that
/// their bad brackets of second order cancel, also for those.
pub(crate) fn general(
    pool: &mut Pool,
    frame: &Frame,
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Stlc, Undecided> {
    let m = frame.fields.controls.len();
    let given = search(pool, frame, Inputs::given(frame), limits, evidence)?;
    if given.verdict == Verdict::Yes || m < 2 {
        return Ok(given);
    }
    for depth in 0..=MAX_CANCELED {
        let (inputs, combinations) = match canceling(pool, frame, depth, evidence) {
            Ok(Some(found)) => found,
            Ok(None) => continue,
            Err(Undecided::TooLarge { .. }) => break,
            Err(why) => return Err(why),
        };
        let changed = search(pool, frame, inputs, limits, evidence)?;
        if changed.verdict == Verdict::Yes {
            let reason = StlcReason::InputsAlong { reason: Box::new(changed.reason), inputs: combinations };
            return Ok(Stlc { reason, ..changed });
        }
    }
    Ok(given)
}

fn search(
    pool: &mut Pool,
    frame: &Frame,
    inputs: Inputs,
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Stlc, Undecided> {
    let m = inputs.fields.len();
    let mut brackets = Brackets::new(pool, frame, inputs, limits);
    let mut stlc = Stlc::inconclusive(StlcReason::TooManyBrackets);
    let mut open = false;
    for weights in choices(m) {
        stlc.weights_tried.push(shortened(&weights));
        match brackets.test(pool, &weights, evidence)? {
            Outcome::Holds => {
                let weights = shortened(&weights);
                let reason = StlcReason::Sussmann { weights: weights.clone() };
                let holds = Stlc::new(Verdict::Yes, reason).holding(weights);
                return Ok(Stlc { weights_tried: stlc.weights_tried, ..holds });
            }
            Outcome::Obstructed(o) => {
                stlc.obstruction.get_or_insert(o);
            }
            Outcome::TooLarge => open = true,
        }
    }
    stlc.general_condition = Some(if open { GeneralCondition::Unknown } else { GeneralCondition::Obstructed });
    if let Some(o) = &stlc.obstruction {
        stlc.reason = StlcReason::Obstructed {
            bracket: o.bracket.clone(),
            weights: o.weights.clone(),
            further: stlc.weights_tried.len() - 1,
            too_many: open,
        };
    }
    Ok(stlc)
}
