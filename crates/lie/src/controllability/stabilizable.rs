//! Whether feedback makes an equilibrium asymptotically stable.

use bracketry_symbolic::{Expr, Function, Pool};
use rustc_hash::FxHashMap;

use crate::algebra::field::is_plain_zero;
use crate::answer::Answer;
use crate::controllability::at_equilibrium::AtEquilibrium;
use crate::controllability::critical_mode::{by_critical_modes, critical_modes_do_not_attract, in_the_plane};
use crate::controllability::growing_form::growing_form;
use crate::controllability::linearization::{exact_matrices, is_hurwitz, is_linear};
use crate::controllability::local_accessibility::Frame;
use crate::controllability::monotone::monotone_function;
use crate::controllability::necessary::half_space;
use crate::controllability::other_inputs::with_other_inputs;
use crate::controllability::region::{Extent, Region};
use crate::controllability::stlc::Verdict;
use crate::evidence::Evidence;
use crate::feedback::critical::Critical;
use crate::feedback::zero_dynamics::Set;
use crate::linear::spectrum::Spectrum;
use crate::linear::taylor::is_analytic;
use crate::reason::{MinimumPhaseReason, Reason, StabilizableReason, StlcReason};
use crate::undecided::Undecided;

/// Most states of which a Lyapunov function or center manifold is sought.
const MAX_STATES: usize = 8;

/// The verdict, from the linearization, from what no input changes or lowers, or from local controllability.
///
/// A "no" excludes every feedback, also of time or with jumps; where the system is not linear it does not rest on the
/// linearization alone, since x' = x − u³ has an unstable uncontrollable mode and u = 2 x^(1/3) stabilizes it.
pub(crate) fn stabilizable(
    pool: &mut Pool,
    at: &AtEquilibrium,
    evidence: &mut Evidence,
) -> (Answer<bool>, StabilizableReason) {
    let n = at.frame.fields.states.len();
    let known = |answer: bool, why: StabilizableReason| (Answer::Known(answer), why);
    let linear = is_linear(pool, &at.frame.fields);
    let all = at.rank == n;
    let by_linearization = if all { StabilizableReason::Controllable } else { StabilizableReason::ModesDecay };
    let restricted = at.sides.iter().any(Option::is_some);
    if restricted && is_hurwitz(pool, at.frame, evidence) {
        return known(true, StabilizableReason::Stable);
    }
    match &at.decays {
        // Inputs that move to one side only are looked at below: linear feedback does not have them.
        Answer::Known(true) if !restricted => return known(true, by_linearization),
        Answer::Known(false) if linear => return known(false, StabilizableReason::UnstableMode),
        Answer::Unknown(Reason::OnAxis) if linear => return known(false, StabilizableReason::ModeOnAxis),
        _ => {}
    }
    match obstacle(pool, at, evidence) {
        Ok(Some(why)) => return known(false, why),
        Ok(None) => {}
        Err(why) => return (Answer::Unknown(why.clone().into()), StabilizableReason::Open(why.into())),
    }
    if at.decays != Answer::Known(true) {
        match by_itself(pool, at.frame, evidence) {
            Some((true, _)) => return known(true, StabilizableReason::StableByItself),
            Some((false, why)) if at.inputs.is_empty() => {
                return known(false, StabilizableReason::QuotientDoesNotAttract(why));
            }
            _ => {}
        }
    }
    if let Some(why) = with_other_inputs(pool, at, evidence) {
        return known(true, why);
    }
    if at.decays == Answer::Known(true) {
        return known(true, by_linearization);
    }
    if at.stlc.with_bounded_inputs() == Verdict::Yes {
        // Kawski 1989: analytic systems x' = f + u g in the plane, g(x0) ≠ 0.
        if n == 2 && at.inputs.len() == 1 && at.inputs[0].iter().any(|v| !v.is_zero()) {
            return known(true, StabilizableReason::Planar);
        }
        // Coron 1995: the sufficient conditions for STLC used here give stabilization by continuous, periodic feedback in
        // any dimension but 2 and 3, which integrators raise; without drift (Coron 1992) in all.
        let driftless = is_plain_zero(pool, &at.frame.fields.drift);
        let directly = n != 2 && n != 3 || driftless;
        let why = if directly { StabilizableReason::Periodic } else { StabilizableReason::PeriodicDynamic };
        return known(true, why);
    }
    if !restricted {
        if n == 2 && at.inputs.len() == 1 && at.inputs[0].iter().any(|v| !v.is_zero()) {
            match in_the_plane(pool, at.frame, evidence) {
                Ok(Some(why)) => return known(true, why),
                Ok(None) => {}
                Err(why) => return (Answer::Unknown(why.clone().into()), StabilizableReason::Open(why.into())),
            }
        }
        if let Some(why) = by_critical_modes(pool, at.frame, evidence) {
            return known(true, why);
        }
    }
    if is_autonomous_quotient(at)
        && let Some(why) = critical_modes_do_not_attract(pool, at.frame, evidence)
    {
        return known(false, StabilizableReason::QuotientDoesNotAttract(why));
    }
    let why = match &at.decays {
        Answer::Unknown(why) => why.clone(),
        // Feedback with kinks, other values of the inputs at the point, or time may do what smooth feedback cannot.
        Answer::Known(_) => Reason::UnstableMode,
    };
    (Answer::Unknown(why.clone()), StabilizableReason::Open(why))
}

/// Whether the equilibrium is asymptotically stable with the inputs of the point, by terms of higher order than the linearization.
fn by_itself(pool: &mut Pool, frame: &Frame, evidence: &mut Evidence) -> Option<(bool, MinimumPhaseReason)> {
    let fields = &frame.fields;
    if fields.states.len() > MAX_STATES {
        return None;
    }
    let (a, _) = exact_matrices(pool, frame, evidence)?;
    let spectrum = Spectrum::of_reals(&a)?;
    if spectrum.right > 0 || spectrum.on_axis == 0 {
        return None;
    }
    let set = Set::of(fields, frame.point(), fields.states.clone());
    let (states, equations) = (&fields.states[..], &fields.drift[..]);
    let critical = Critical { set: &set, states, equations, on_axis: spectrum.on_axis };
    critical.decide(pool, evidence)
}

/// What keeps states near the point from it, whatever the inputs.
///
/// - The accessibility algebra has the same dimension r < n at the point as generically: near the point the state space is
///   foliated by orbits of dimension r (Frobenius), and a motion that stays near the point does not change its leaf.
/// - The strong algebra has the same dimension at the point as generically and as Kalman's matrix: in coordinates z of the
///   leaves of that foliation z' = h(z), whatever the inputs, and the uncontrollable modes are those of h.
/// - A function that changes to one side only near the point, or only where it exceeds its value there: from there it does not
///   fall back.
/// - A function that nothing changes and that is analytic at the point.
/// - A quadratic form of uncontrollable modes that does not fall near the point.
fn obstacle(
    pool: &mut Pool,
    at: &AtEquilibrium,
    evidence: &mut Evidence,
) -> Result<Option<StabilizableReason>, Undecided> {
    let n = at.frame.fields.states.len();
    let dimension = at.local.dimension.known().copied();
    if dimension == Some(at.generic[0]) && at.generic[0] < n {
        return Ok(Some(StabilizableReason::Leaves { dimension: at.generic[0], states: n }));
    }
    if at.decays == Answer::Known(false) && is_autonomous_quotient(at) {
        return Ok(Some(StabilizableReason::UnstableQuotient));
    }
    for region in [Region::All, Region::Above, Region::Below] {
        let near = Extent::near(region);
        let barrier = match half_space(pool, at.frame, at.sides, near, evidence)? {
            None => monotone_function(pool, at.frame, at.sides, near, evidence)?,
            found => found,
        };
        if let Some(StlcReason::HalfSpace { function, change, .. }) = barrier {
            return Ok(Some(match region {
                Region::Above | Region::Below => {
                    StabilizableReason::NoReturn { function, above: region == Region::Above }
                }
                _ => StabilizableReason::OneWay { function, change },
            }));
        }
    }
    if let Some(function) = conserved(pool, at, evidence)? {
        return Ok(Some(StabilizableReason::Conserved(function)));
    }
    Ok(growing_form(pool, at.frame, evidence))
}

/// Whether the uncontrollable modes are those of z' = h(z) for coordinates z that no input influences.
fn is_autonomous_quotient(at: &AtEquilibrium) -> bool {
    at.local.strong_dimension.known() == Some(&at.generic[1]) && at.generic[1] == at.rank
}

/// A function that is analytic at the point and that nothing changes, though its gradient vanishes there: a state with another value of it
/// does not approach the point, and there are such states arbitrarily near.
fn conserved(pool: &mut Pool, at: &AtEquilibrium, evidence: &mut Evidence) -> Result<Option<Function>, Undecided> {
    let fields = &at.frame.fields;
    if at.generic[0] == fields.states.len() {
        return Ok(None);
    }
    let found = fields.autonomous(pool, &at.reach.basis, evidence)?;
    let (variables, offsets) = at.frame.deviations(pool);
    let zero = pool.int(0);
    let origin: FxHashMap<Expr, Expr> = variables.iter().map(|&s| (pool.sym(s), zero)).collect();
    let function = found.functions.into_iter().find(|&h| {
        let moved = pool.substitute(h, &offsets);
        let moved = at.frame.constants_in(pool, moved);
        is_analytic(pool, moved, &origin)
    });
    Ok(function.map(|h| Function::new(pool, h)))
}
