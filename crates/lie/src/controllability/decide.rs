//! Decides small-time local controllability with free inputs: the conditions in their order.

use bracketry_symbolic::Pool;

use crate::algebra::field::is_plain_zero;
use crate::answer::Answer;
use crate::controllability::linearization::Linearization;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::monotone::monotone_function;
use crate::controllability::necessary::{definite_form, half_space, stefani};
use crate::controllability::prolonged::{is_odd, with_integrators};
use crate::controllability::region::Extent;
use crate::controllability::search::general;
use crate::controllability::stlc::{Stlc, Verdict};
use crate::controllability::sussmann::{Brackets, Inputs, Outcome};
use crate::evidence::Evidence;
use crate::options::Limits;
use crate::reason::StlcReason;
use crate::residues::Echelon;
use crate::undecided::Undecided;

/// Most new nodes that the weights of a condition may take that is known to hold.
const FEW_NODES: usize = 5_000;

/// Decides STLC with inputs that are free within bounds around their values at the point, as far as the conditions below go.
/// A "yes" holds for every bound, however small, and a "no" for every bound, however large.
///
/// - not an equilibrium and f(x0) outside span g(x0): no (bounded inputs cannot hold the state);
/// - dimension at x0 not full: no (the orbit is a lower-dimensional manifold, Nagano 1966, Sussmann 1973);
/// - controllable linearization: yes;
/// - an invariant half-space: no (see [`half_space`]);
/// - no drift and full dimension: yes (Rashevskii 1938, Chow 1939);
/// - Sussmann's general condition, also after a change of the inputs: yes;
/// - f odd and the inputs' fields even about the point: yes (see [`is_odd`]);
/// - one input: no where Stefani's necessary condition fails (see [`stefani`]);
/// - a definite second-order form: no (see [`definite_form`]);
/// - integrators in front of inputs bring forms of different depths to one weight: yes (see [`with_integrators`]);
/// - a function that does not fall near the point: no (see [`monotone_function`]).
///
/// [`Stlc::or_inconclusive`] turns what an exact test leaves open into a verdict.
pub(crate) fn decide(
    pool: &mut Pool,
    frame: &Frame,
    dimension: &Answer<usize>,
    linearization: Option<&Linearization>,
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Stlc, Undecided> {
    let n = frame.fields.states.len();
    let Some(linearization) = linearization else {
        let mut span = Echelon::new(&frame.evaluate(pool, &frame.fields.controls, evidence)?, n);
        let drift = frame.evaluate(pool, std::slice::from_ref(&frame.fields.drift), evidence)?;
        return Ok(if drift.into_iter().any(|f| span.insert(f)) {
            Stlc::new(Verdict::No, StlcReason::NotBalanced)
        } else {
            Stlc::inconclusive(StlcReason::NoEquilibrium)
        });
    };
    match dimension {
        Answer::Known(d) if *d < n => {
            return Ok(Stlc::not_accessible(*d, n));
        }
        _ => {}
    }
    let controllable = linearization.controllable();
    let inputs = frame.fields.controls.len();
    if controllable.rank() == n {
        // Equal weights if few brackets show it; else brackets with one input, which span all,
        // weigh less than those with two.
        let few = Limits { nodes: limits.nodes.min(FEW_NODES), ..*limits };
        let mut brackets = Brackets::new(pool, frame, Inputs::given(frame), &few);
        let equal = vec![1; inputs + 1];
        let holds = matches!(brackets.test(pool, &equal, evidence), Ok(Outcome::Holds));
        let weights = if holds { vec![1, 1] } else { vec![1, linearization.index() as u32] };
        return Ok(Stlc::new(Verdict::Yes, StlcReason::Controllable).holding(weights));
    }
    if let Some(reason) = half_space(pool, frame, &vec![None; inputs], Extent::LOCAL_HALF_SPACE, evidence)? {
        let mut stlc = Stlc::new(Verdict::No, reason);
        if dimension.known().is_some() {
            let general = general(pool, frame, limits, evidence)?;
            stlc.general_condition = general.general_condition;
            stlc.weights_tried = general.weights_tried;
            stlc.obstruction = general.obstruction;
        }
        return Ok(stlc);
    }
    if let Answer::Unknown(why) = dimension {
        return Ok(Stlc::inconclusive(StlcReason::DimensionOpen(why.clone())));
    }
    if is_plain_zero(pool, &frame.fields.drift) {
        // No bracket with f is left to be neutralized.
        return Ok(Stlc::new(Verdict::Yes, StlcReason::NoDrift).holding(vec![1, 1]));
    }
    let mut stlc = general(pool, frame, limits, evidence)?;
    if stlc.verdict == Verdict::Yes {
        return Ok(stlc);
    }
    if is_odd(pool, frame) {
        stlc.verdict = Verdict::Yes;
        stlc.reason = StlcReason::Odd;
        return Ok(stlc);
    }
    if let [g] = frame.fields.controls.as_slice()
        && let Some(k) = stefani(pool, frame, g, &controllable, limits, evidence)?
    {
        stlc.verdict = Verdict::No;
        stlc.reason = StlcReason::Stefani(k);
        return Ok(stlc);
    }
    if let Some(k) = definite_form(pool, frame, evidence)? {
        stlc.verdict = Verdict::No;
        stlc.reason = StlcReason::DefiniteForm(k);
        return Ok(stlc);
    }
    let sides = vec![None; inputs];
    if let Some(found) = with_integrators(pool, frame, &sides, limits, evidence)? {
        return Ok(found);
    }
    if let Some(reason) = monotone_function(pool, frame, &sides, Extent::LOCAL_HALF_SPACE, evidence)? {
        stlc.verdict = Verdict::No;
        stlc.reason = reason;
    }
    Ok(stlc)
}
