//! Dimensions of a large system by its linearization.

use std::time::Instant;

use bracketry_symbolic::Pool;
use bracketry_system::Point;

use crate::algebra::closure::Closure;
use crate::algebra::field::{Field, VectorFields};
use crate::algebra::krylov::LARGE;
use crate::controllability::linearization::Linearization;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::uninfluenced::Reach;
use crate::error::Error;
use crate::evidence::Evidence;

/// Of the time that is left, the share for brackets that only tell how the dimension grows.
const SHARE_FOR_GROWTH: u32 = 4;

/// A linearization of more states takes too many products in one step.
const MAX_STATES: usize = 600;

impl Reach {
    /// [`Reach::of`] a model. Where brackets of a large system cannot be closed, a controllable linearization at its point (at the
    /// origin, of a model without one) decides: the brackets ad_f^k g_i are A^k b_i at an equilibrium, up to their sign, and what is
    /// independent at one point is independent at almost every point.
    pub(crate) fn of_model(
        pool: &mut Pool,
        fields: &VectorFields,
        point: Option<&Point>,
        first: usize,
        evidence: &mut Evidence,
    ) -> Reach {
        let n = fields.states.len();
        let mut linear = evidence.clone();
        let zero = pool.int(0);
        let origin = || Point { states: vec![zero; n], inputs: vec![zero; fields.controls.len()] };
        let controllable = (LARGE..=MAX_STATES).contains(&n) && {
            let point = point.cloned().unwrap_or_else(origin);
            linearly_controllable(pool, fields, &point, &mut linear).unwrap_or(false)
        };
        if !controllable {
            return Self::of(pool, fields, first, evidence);
        }
        let (deadline, now) = (pool.deadline(), Instant::now());
        pool.set_deadline(deadline.map(|end| now + end.saturating_duration_since(now) / SHARE_FOR_GROWTH));
        let mut closing = evidence.clone();
        let closed = Self::of(pool, fields, first, &mut closing);
        pool.set_deadline(deadline);
        let Some(why) = closed.all.as_ref().err().or(closed.strong.as_ref().err()).cloned() else {
            *evidence = closing;
            return closed;
        };
        *evidence = linear;
        let one = pool.int(1);
        let unit = |i: usize| -> Field { (0..n).map(|j| if i == j { one } else { zero }).collect() };
        let everything = Closure { growth: Vec::new(), basis: (0..n).map(unit).collect(), words: Vec::new() };
        Reach { all: Ok(everything.clone()), strong: Ok(everything), not_closed: Some(why) }
    }
}

/// Whether the point is an equilibrium with a controllable linearization.
fn linearly_controllable(
    pool: &mut Pool,
    fields: &VectorFields,
    point: &Point,
    evidence: &mut Evidence,
) -> Result<bool, Error> {
    let frame = Frame::new(pool, fields, &point.states, &point.inputs)?;
    if !frame.is_equilibrium(pool, evidence)? {
        return Ok(false);
    }
    let linearization = Linearization::at(pool, &frame, evidence)?;
    Ok(linearization.controllable().rank() == fields.states.len())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use bracketry_symbolic::Bindings;

    /// A ring of pendulums without friction, x_i' = sin x_{i+1} + c sin x_{i−1}, with an input at the first: by reflection, its linearization
    /// is controllable only where the coupling has a direction (c ≠ 1).
    fn ring(pool: &mut Pool, coupling: &str) -> (VectorFields, Point) {
        let n = LARGE;
        let states = (0..n).map(|i| pool.symbol(&format!("x{i}"))).collect();
        let drift = (0..n).map(|i| {
            let (next, last) = ((i + 1) % n, (i + n - 1) % n);
            pool.parse(&format!("sin(x{next}) + {coupling}*sin(x{last})")).unwrap()
        });
        let drift: Field = drift.collect();
        let (zero, one) = (pool.int(0), pool.int(1));
        let control = (0..n).map(|i| if i == 0 { one } else { zero }).collect();
        let fields = VectorFields::new(states, drift, vec![control], Bindings::new()).unwrap();
        (fields, Point { states: vec![zero; n], inputs: vec![zero] })
    }

    /// Evidence that leaves room for a few products only, so that no closure ends.
    fn exhausted() -> Evidence {
        let mut evidence = Evidence::default();
        while evidence.spend(1e6).is_ok() {}
        evidence
    }

    #[test]
    fn a_controllable_linearization_decides_where_brackets_are_not_closed() {
        let mut pool = Pool::new();
        let (fields, point) = ring(&mut pool, "0");
        let reach = Reach::of_model(&mut pool, &fields, Some(&point), 0, &mut exhausted());
        assert_eq!(reach.all.unwrap().dimension(), LARGE);
        assert_eq!(reach.strong.unwrap().dimension(), LARGE);
        assert!(reach.not_closed.is_some());
        // One that is not controllable decides nothing, nor does a point that is no equilibrium.
        let (fields, _) = ring(&mut pool, "0");
        assert!(Reach::of_model(&mut pool, &fields, None, 0, &mut exhausted()).all.is_ok());
        let (fields, point) = ring(&mut pool, "1");
        assert!(Reach::of_model(&mut pool, &fields, Some(&point), 0, &mut exhausted()).all.is_err());
        let (fields, mut point) = ring(&mut pool, "0");
        point.states[0] = pool.int(1);
        assert!(Reach::of_model(&mut pool, &fields, Some(&point), 0, &mut exhausted()).all.is_err());
    }
}
