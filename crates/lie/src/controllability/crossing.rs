//! Small-time local controllability where two modes without drift meet.

use std::cmp::Ordering;

use bracketry_symbolic::{Function, Pool};

use crate::algebra::span::vanishes;
use crate::answer::Answer;
use crate::controllability::cone::is_lipschitz;
use crate::controllability::meeting::{Adjacent, AtSwitchPoint, input_set};
use crate::error::Error;
use crate::evidence::Evidence;
use crate::reason::StlcReason;

/// Whether an input crosses the surface between two modes without drift, in one of which the input fields have full dimension at
/// the point.
///
/// Then the system is STLC, for any bound of the inputs. Proof. With L_g s > 0 in both modes, the flow of g crosses s = 0
/// transversally near x0 and maps neighborhoods of x0 to neighborhoods of a point p with s(p) > 0, where the input fields span all
/// directions as well. By Chow and Rashevskii, a neighborhood of p is reached from p within s > 0, and the flow of −g maps it to a
/// neighborhood of x0. All this takes as little time as wanted.
pub(crate) fn crossed(
    pool: &mut Pool,
    given: &AtSwitchPoint,
    modes: &[Adjacent],
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Error> {
    let [a, b] = modes else { return Ok(None) };
    let ([(s, _)], [(t, _)]) = (&a.vanishing[..], &b.vanishing[..]) else { return Ok(None) };
    let two_sided =
        input_set(given).sides(pool, &a.frame, &given.point.inputs).is_some_and(|s| s.iter().all(Option::is_none));
    if s != t || !two_sided {
        return Ok(None);
    }
    for mode in modes {
        let drift = &mode.frame.fields.drift;
        if !drift.iter().all(|&e| vanishes(pool, e, &mode.fields.bindings)) || !is_lipschitz(pool, mode, false) {
            return Ok(None);
        }
    }
    let mut crosses = false;
    for (g, h) in a.fields.controls.iter().zip(&b.fields.controls) {
        let mut sign = |mode: &Adjacent, field: &[_]| {
            let rate = pool.lie_derivative(*s, &mode.fields.states, field);
            let rate = mode.frame.value_at_point(pool, rate);
            mode.frame.sign(pool, rate)
        };
        let signs = (sign(a, g), sign(b, h));
        crosses |= signs.0 == signs.1 && matches!(signs.0, Some(Ordering::Less | Ordering::Greater));
    }
    if !crosses {
        return Ok(None);
    }
    for mode in modes {
        let point = given.point;
        let local = mode.fields.at_point(pool, &point.states, &point.inputs, &given.options.limits, evidence)?;
        if local.dimension == Answer::Known(mode.fields.states.len()) {
            return Ok(Some(StlcReason::Crossing(Function::new(pool, *s))));
        }
    }
    Ok(None)
}
