//! Small-time local controllability at an equilibrium: sufficient and necessary conditions.

use std::fmt;

use bracketry_symbolic::Pool;
use serde::Serialize;

use crate::algebra::field::is_plain_zero;
use crate::answer::Answer;
use crate::controllability::canceling::canceling;
use crate::controllability::linearization::Linearization;
use crate::controllability::local::Frame;
use crate::controllability::necessary::{definite_form, half_space, stefani};
use crate::controllability::prolonged::{is_odd, with_integrators};
use crate::controllability::sussmann::{Brackets, Inputs, Obstruction, Outcome, choices, shortened};
use crate::evidence::Evidence;
use crate::options::Limits;
use crate::reason::StlcReason;
use crate::residues::Echelon;
use crate::undecided::Undecided;

/// Whether the inputs reach a full neighborhood in arbitrarily short time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// A sufficient condition holds.
    Yes,
    /// A necessary condition fails.
    No,
    /// Neither is known.
    Inconclusive,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Yes => "yes",
            Verdict::No => "no",
            Verdict::Inconclusive => "inconclusive",
        })
    }
}

/// What Sussmann's general sufficient condition says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GeneralCondition {
    /// It holds for some weights.
    Holds,
    /// For all weights that were tried a bad bracket is not neutralized.
    Obstructed,
    /// For some weights the brackets became too many or too large.
    Unknown,
}

/// Small-time local controllability (STLC) at the point x0: for every T > 0, the states that are reached within T contain a
/// neighborhood of x0.
///
/// Inputs take the values of their ranges; one without a range takes all real numbers, and trajectories may leave the
/// neighborhood of x0 meanwhile. With bounded inputs they cannot go far in a short time; the verdict for those, which is
/// the one of the literature (|u| ≤ 1), is in `bounded` where it differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stlc {
    /// The verdict.
    pub verdict: Verdict,
    /// The condition that holds or fails.
    pub reason: StlcReason,
    /// Weights, of the drift and then of the inputs (one number if they are all equal), for which
    /// Sussmann's condition holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<Vec<u32>>,
    /// What Sussmann's condition says; absent where a simpler test decides first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub general_condition: Option<GeneralCondition>,
    /// Weights that were tried.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub weights_tried: Vec<Vec<u32>>,
    /// The first bad bracket that is not neutralized, for the first of the weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub obstruction: Option<Obstruction>,
    /// The verdict for inputs within any bounds around their values at the point, where it is another one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounded: Option<BoundedStlc>,
}

/// Small-time local controllability with inputs u that are bounded by a constant, |u − u0| ≤ M, for every M.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoundedStlc {
    /// The verdict.
    pub verdict: Verdict,
    /// The condition that holds or fails.
    pub reason: StlcReason,
}

impl Stlc {
    /// The verdict for bounded inputs.
    pub fn with_bounded_inputs(&self) -> Verdict {
        self.bounded.as_ref().map_or(self.verdict, |b| b.verdict)
    }

    pub(crate) fn new(verdict: Verdict, reason: StlcReason) -> Self {
        Stlc {
            verdict,
            reason,
            weights: None,
            general_condition: None,
            weights_tried: Vec::new(),
            obstruction: None,
            bounded: None,
        }
    }

    /// With the weights for which Sussmann's condition holds.
    fn holding(self, weights: Vec<u32>) -> Self {
        Stlc { weights: Some(weights), general_condition: Some(GeneralCondition::Holds), ..self }
    }

    /// No verdict where a test gave up.
    pub(crate) fn or_inconclusive(decided: Result<Self, Undecided>) -> Self {
        decided.unwrap_or_else(|why| Stlc::inconclusive(why.into()))
    }

    /// No verdict, for a reason that lies outside of the brackets.
    pub fn inconclusive(reason: StlcReason) -> Self {
        Stlc::new(Verdict::Inconclusive, reason)
    }

    /// The orbit is a manifold of lower dimension (Nagano–Sussmann).
    pub(crate) fn not_accessible(dimension: usize, states: usize) -> Self {
        Stlc::new(Verdict::No, StlcReason::NotAccessible { dimension, states })
    }
}

/// Most new nodes that the weights of a condition may take that is known to hold.
const FEW_NODES: usize = 5_000;

/// Decides STLC with inputs that are free within bounds around their values at the point, as far as the conditions below go.
/// A "yes" holds for every bound, however small, and a "no" for every bound, however large.
///
/// - not an equilibrium and f(x0) outside span g(x0): no (bounded inputs cannot hold the state);
/// - dimension at x0 not full: no (the orbit is a lower-dimensional manifold, Nagano–Sussmann);
/// - controllable linearization: yes;
/// - no drift and full dimension: yes (Chow–Rashevskii);
/// - an invariant half-space: no (see [`half_space`]);
/// - f odd and the inputs' fields even about the point: yes (see [`is_odd`]);
/// - Sussmann's general condition, also after a change of the inputs: yes;
/// - one input: no where Stefani's necessary condition fails (see [`stefani`]);
/// - a definite second-order form: no (see [`definite_form`]);
/// - integrators in front of inputs bring forms of different depths to one weight: yes (see [`with_integrators`]).
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
    if let Some(reason) = half_space(pool, frame, &vec![None; inputs], false, evidence)? {
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
    if is_odd(pool, frame) {
        return Ok(Stlc::new(Verdict::Yes, StlcReason::Odd));
    }
    let mut stlc = general(pool, frame, limits, evidence)?;
    if stlc.verdict == Verdict::Yes {
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
    Ok(with_integrators(pool, frame, &vec![None; inputs], limits, evidence)?.unwrap_or(stlc))
}

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
