//! The modes that meet at a point where switching functions vanish.

use bracketry_symbolic::{Bindings, Expr, Pool, ZeroTest};
use bracketry_system::Point;
use rustc_hash::FxHashMap;

use crate::algebra::field::VectorFields;
use crate::answer::Answer;
use crate::controllability::input_set::InputSet;
use crate::controllability::input_values::InputValues;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::stlc::{BoundedStlc, Stlc};
use crate::controllability::switched::Invariant;
use crate::error::Error;
use crate::modes::ModeFields;
use crate::options::AnalysisOptions;
use crate::reason::{Monotone, StabilizableReason, StlcReason};
use crate::undecided::Undecided;

/// Rates nearer to zero do not count.
pub(crate) const CLEAR: f64 = 1e-9;

/// A point where switching functions vanish.
pub(crate) struct AtSwitchPoint<'a> {
    pub(crate) modes: &'a [ModeFields],
    pub(crate) point: &'a Point,
    pub(crate) names: &'a [String],
    pub(crate) options: &'a AnalysisOptions,
    /// Continuous functions that no mode changes.
    pub(crate) invariants: &'a [Invariant],
    /// Whether a unit vector vanishes too, which no mode describes.
    pub(crate) unit_vector: bool,
}

/// A mode that meets others at the point.
pub(crate) struct Adjacent<'a> {
    pub(crate) number: usize,
    pub(crate) fields: &'a VectorFields,
    /// The switching functions that vanish at the point (or all, away from it), with their signs in this mode.
    pub(crate) vanishing: Vec<(Expr, i8)>,
    /// Their numbers.
    pub(crate) switches: Vec<usize>,
    pub(crate) frame: Frame,
}

/// What is decided at the point.
pub(crate) struct Verdicts {
    pub(crate) equilibrium: Answer<bool>,
    pub(crate) stlc: Option<Stlc>,
    pub(crate) stabilizable: Option<(bool, StabilizableReason)>,
    pub(crate) brockett: Option<bool>,
}

/// The modes that may meet at the point: those in which every switching function vanishes there or has its sign.
pub(crate) fn adjacent<'a>(pool: &mut Pool, given: &AtSwitchPoint<'a>) -> Result<Vec<Adjacent<'a>>, Error> {
    let mut list = Vec::new();
    for (number, mode) in given.modes.iter().enumerate() {
        if let Some(limit) = pool.reached_limit() {
            return Err(Undecided::from(limit).into());
        }
        let frame = Frame::new(pool, &mode.fields, &given.point.states, &given.point.inputs)?;
        let (mut vanishing, mut switches, mut meets) = (Vec::new(), Vec::new(), true);
        let at: FxHashMap<Expr, Expr> =
            mode.fields.states.iter().zip(&given.point.states).map(|(&s, &v)| (pool.sym(s), v)).collect();
        for (i, (&s, sign)) in mode.surfaces.iter().zip(mode.sign_list()).enumerate() {
            let value = pool.substitute(s, &at);
            let value = frame.constants_in(pool, value);
            let sure = frame.numbers(pool, &[value]).map(|v| v[0] * f64::from(sign));
            match pool.zero_test(value, &Bindings::new()) {
                ZeroTest::NonZero if sure.is_some_and(|v| v > 0.0) => {}
                ZeroTest::NonZero if sure.is_some_and(|v| v < 0.0) => meets = false,
                // What is not decided counts as zero: more modes are looked at.
                _ => {
                    vanishing.push((s, sign));
                    switches.push(i);
                }
            }
        }
        if meets {
            list.push(Adjacent { number, fields: &mode.fields, vanishing, switches, frame });
        }
    }
    Ok(list)
}

/// What bounded inputs do not reach, others may.
pub(crate) fn only_bounded(bounded: BoundedStlc) -> Stlc {
    Stlc { bounded: Some(bounded), ..Stlc::inconclusive(StlcReason::Unbounded) }
}

/// All modes of the model, each with the signs of all its switching functions.
pub(crate) fn all_modes<'a>(pool: &mut Pool, given: &AtSwitchPoint<'a>) -> Result<Vec<Adjacent<'a>>, Error> {
    let mut list = Vec::new();
    for (number, mode) in given.modes.iter().enumerate() {
        let frame = Frame::new(pool, &mode.fields, &given.point.states, &given.point.inputs)?;
        let vanishing = mode.surfaces.iter().copied().zip(mode.sign_list()).collect();
        let switches = (0..mode.surfaces.len()).collect();
        list.push(Adjacent { number, fields: &mode.fields, vanishing, switches, frame });
    }
    Ok(list)
}

/// The values that the inputs take.
pub(crate) struct Ranges {
    /// One per input; infinite where the values are not known.
    pub(crate) ends: Vec<(f64, f64)>,
    /// Whether the values are all real numbers.
    pub(crate) free: Vec<bool>,
}

impl Ranges {
    pub(crate) fn new(given: &AtSwitchPoint) -> Ranges {
        let said = |name: &String| given.options.one_sided.iter().any(|o| o.0 == *name);
        let value = |name: &String| given.options.ranges.iter().find(|r| r.0 == *name).map(|r| r.1);
        let (mut ends, mut free) = (Vec::new(), Vec::new());
        for name in given.names {
            ends.push(match value(name) {
                Some(InputValues::Between(lower, upper)) => (lower, upper),
                _ => (f64::NEG_INFINITY, f64::INFINITY),
            });
            let all = match value(name) {
                Some(InputValues::Between(lower, upper)) => lower == f64::NEG_INFINITY && upper == f64::INFINITY,
                Some(InputValues::Unknown) => false,
                None => true,
            };
            free.push(all && !said(name));
        }
        Ranges { ends, free }
    }

    /// The inputs at the point alone. What holds for them with a margin holds for inputs within small bounds around them.
    pub(crate) fn smallest(pool: &mut Pool, given: &AtSwitchPoint, modes: &[Adjacent]) -> Option<Ranges> {
        let values = modes.first()?.frame.numbers(pool, &given.point.inputs)?;
        let free = vec![false; values.len()];
        Some(Ranges { ends: values.into_iter().map(|u| (u, u)).collect(), free })
    }

    pub(crate) fn bounded(&self) -> bool {
        self.ends.iter().all(|e| e.0.is_finite() && e.1.is_finite())
    }
}

/// The inputs with their ranges.
pub(crate) fn input_set<'a>(given: &AtSwitchPoint<'a>) -> InputSet<'a> {
    let named = |n: &String| given.options.ranges.iter().find(|r| r.0 == *n).map(|r| r.1);
    let said = |n: &String| given.options.one_sided.iter().find(|o| o.0 == *n).map(|o| o.1);
    InputSet {
        names: given.names,
        values: given.names.iter().map(named).collect(),
        one_sided: given.names.iter().map(said).collect(),
    }
}

/// How a function changes.
pub(crate) fn change(up: bool, down: bool) -> Monotone {
    match (up, down) {
        (true, true) => Monotone::Constant,
        (true, false) => Monotone::Rises,
        _ => Monotone::Falls,
    }
}
