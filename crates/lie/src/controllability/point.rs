//! Statements at the point of a model.

use std::fmt;

use bracketry_symbolic::{Bindings, Expr, Function, Pool, Rational, ZeroTest};
use bracketry_system::{Point, System};
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::algebra::field::VectorFields;
use crate::answer::Answer;
use crate::as_text::serialized_as_text;
use crate::budget::release;
use crate::controllability::at_equilibrium::AtEquilibrium;
use crate::controllability::brockett::brockett_condition;
use crate::controllability::consistency::Statements;
use crate::controllability::decide::decide;
use crate::controllability::input_set::InputSet;
use crate::controllability::linearization::{Linearization, uncontrollable};
use crate::controllability::local_accessibility::Frame;
use crate::controllability::one_sided::{Given, held, one_sided};
use crate::controllability::stabilizable::stabilizable;
use crate::controllability::stlc::{Stlc, Verdict};
use crate::controllability::unbounded::unbounded;
use crate::controllability::uncontrollable::{UncontrollableMode, uncontrollable_modes};
use crate::controllability::uninfluenced::Reach;
use crate::dimensions::Dimensions;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::modes::ModeFields;
use crate::options::AnalysisOptions;
use crate::reason::{Reason, StabilizableReason, StlcReason};
use crate::undecided::Undecided;

/// What governs the motion at a point.
pub(crate) enum Regime {
    /// The mode with this index: no switching function vanishes.
    Mode(usize),
    /// The switching functions and unit vectors that vanish.
    Switching(Vec<Vanishing>),
}

/// The regime that holds at `point`.
pub(crate) fn regime(system: &mut System, point: &Point, modes: &[ModeFields]) -> Result<Regime, Error> {
    let form = system.set_valued_form();
    let switches = form.signs();
    let mut at: FxHashMap<Expr, Expr> = FxHashMap::default();
    for (&s, &v) in system.states.iter().zip(&point.states) {
        let s = system.pool.sym(s);
        at.insert(s, v);
    }
    for p in &system.parameters {
        let s = system.pool.sym(p.symbol);
        let v = system.pool.rational(p.value.clone());
        at.insert(s, v);
    }
    let mut signs: Vec<i8> = Vec::new();
    let mut vanishing: Vec<Vanishing> = Vec::new();
    for s in switches {
        for (t, &v) in switches.iter().zip(&signs) {
            let inner = system.pool.sym(t.sign);
            let v = system.pool.int(i64::from(v));
            at.insert(inner, v);
        }
        let value = system.pool.substitute(s.surface, &at);
        match system.pool.zero_test(value, &Bindings::new()) {
            ZeroTest::Zero(_) => vanishing.push(Vanishing::Switch(Function::new(&system.pool, s.surface))),
            ZeroTest::Unknown(why) if vanishing.is_empty() => return Err(Undecided::from(why).into()),
            ZeroTest::Unknown(_) | ZeroTest::NonZero => {}
        }
        // One that vanishes is enough to leave the modes, and has no sign for those that contain it.
        if !vanishing.is_empty() {
            continue;
        }
        let Some(number) = system.value(value).filter(|v| *v != 0.0) else {
            return Err(Error::NoValue { what: s.name.clone() });
        };
        signs.push(if number > 0.0 { 1 } else { -1 });
    }
    for vector in &form.unit_vectors {
        let components = &form.switches[vector.switches.clone()];
        let values: Vec<Expr> = components.iter().map(|s| system.pool.substitute(s.surface, &at)).collect();
        if values.into_iter().all(|v| matches!(system.pool.zero_test(v, &Bindings::new()), ZeroTest::Zero(_))) {
            let components = components.iter().map(|s| Function::new(&system.pool, s.surface));
            vanishing.push(Vanishing::UnitVector(components.collect()));
        }
    }
    if !vanishing.is_empty() {
        return Ok(Regime::Switching(vanishing));
    }
    let mode = modes.iter().position(|m| m.signs.0.iter().map(|s| s.1).eq(signs.iter().copied()));
    Ok(mode.map_or(Regime::Switching(vanishing), Regime::Mode))
}

/// Says that the dimensions and the linearization at a point are those of the smoothed model.
pub(crate) fn of_smoothed(report: PointReport, vanishing: Vec<Vanishing>, epsilon: &Rational) -> PointReport {
    PointReport { of: Subject::Smoothed, epsilon: Some(epsilon.to_f64().value()), vanishing, ..report }
}

/// All statements at a point, made of the fields of one mode or of the smoothed model.
pub(crate) fn point_report(
    pool: &mut Pool,
    fields: &VectorFields,
    names: &[String],
    reach: &Reach,
    point: &Point,
    options: &AnalysisOptions,
    evidence: &mut Evidence,
) -> Result<PointReport, Error> {
    let n = fields.states.len();
    let frame = Frame::new(pool, fields, &point.states, &point.inputs)?;
    let values = names.iter().map(|n| options.ranges.iter().find(|r| r.0 == *n).map(|r| r.1)).collect();
    let said = names.iter().map(|n| options.one_sided.iter().find(|o| o.0 == *n).map(|o| o.1)).collect();
    let set = InputSet { names, values, one_sided: said };
    let outside_ranges = set.outside(pool, &frame, &point.inputs);
    let equilibrium = outside_ranges.is_empty() && frame.is_equilibrium(pool, evidence)?;
    let all = reach.all.as_ref().map_err(Clone::clone)?;
    let strong = reach.strong.as_ref().map_err(Clone::clone)?;
    let before = pool.len();
    let local = frame.accessibility(pool, all, strong, &options.limits, evidence)?;
    release(pool, before, &mut []);
    let linearization = if equilibrium { Some(Linearization::at(pool, &frame, evidence)?) } else { None };
    let limits = &options.limits;
    let before = pool.len();
    let stlc = match &local.dimension {
        // The dimension at a point is no larger than the generic one.
        Answer::Unknown(_) if all.dimension() < n => Stlc::not_accessible(all.dimension(), n),
        dimension => Stlc::or_inconclusive(decide(pool, &frame, dimension, linearization.as_ref(), limits, evidence)),
    };
    release(pool, before, &mut []);
    let sides = set.sides(pool, &frame, &point.inputs);
    let restricted = sides.as_ref().is_none_or(|s| s.iter().any(Option::is_some));
    let around = if stlc.verdict != Verdict::No && (!equilibrium || restricted) {
        let given = Given { frame: &frame, sides: sides.as_deref() };
        held(pool, fields, &set, &given, &local.dimension, limits, evidence)?
    } else {
        None
    };
    let stlc = match (around, &sides) {
        (Some(around), _) => around,
        (None, Some(sides)) => one_sided(pool, &frame, sides, stlc, limits, evidence)?,
        (None, None) if stlc.verdict == Verdict::No => stlc,
        (None, None) => Stlc::inconclusive(StlcReason::NotInRanges),
    };
    let sides = sides.unwrap_or_else(|| vec![None; names.len()]);
    let stlc = unbounded(pool, &frame, &set, &point.inputs, &sides, stlc, evidence)?;
    let rank = linearization.as_ref().map(|l| l.controllable().rank());
    let unreached = rank.map(|rank| uncontrollable(pool, &frame, rank, evidence));
    let decays = unreached.as_ref().map(|u| match u {
        Ok(found) => found.decays.clone(),
        Err(why) => Answer::Unknown(why.clone()),
    });
    let decays_known = decays.as_ref().and_then(Answer::known).copied();
    let stabilizable = linearization.as_ref().zip(rank).zip(decays).map(|((l, rank), decays)| {
        let generic = [all.dimension(), strong.dimension()];
        let (inputs, local, stlc, sides) = (&l.b[..], &local, &stlc, &sides[..]);
        let (frame, set, values) = (&frame, &set, &point.inputs[..]);
        let at = AtEquilibrium { frame, rank, inputs, decays, generic, local, reach: all, stlc, sides, set, values };
        stabilizable(pool, &at, evidence)
    });
    let (stabilizable, stabilizable_reason) = stabilizable.unzip();
    let restricted = sides.iter().any(Option::is_some);
    let brockett_condition = linearization.as_ref().map(|l| match &stabilizable_reason {
        // A function with dφ(x0) ≠ 0 does not change to one side: −λ dφ(x0) is no rate of it.
        Some(StabilizableReason::OneWay { .. } | StabilizableReason::Leaves { .. }) if !restricted => {
            Answer::Known(false)
        }
        _ => match (brockett_condition(pool, &frame, l, evidence), &stabilizable_reason) {
            // Continuous feedback that stabilizes needs the condition (Zabczyk 1989).
            (Answer::Unknown(_), Some(why)) if why.is_by_continuous_state_feedback() => Answer::Known(true),
            (found, _) => found,
        },
    });
    let statements = Statements {
        states: n,
        generic: [all.dimension(), strong.dimension()],
        local: [local.dimension.known().copied(), local.strong_dimension.known().copied()],
        rank,
        restricted,
        stlc: stlc.with_bounded_inputs(),
        decays: decays_known,
        stabilizable: stabilizable.as_ref().and_then(Answer::known).copied(),
        continuous: stabilizable_reason.as_ref().is_some_and(StabilizableReason::is_by_continuous_state_feedback),
        brockett: brockett_condition.as_ref().and_then(Answer::known).copied(),
    };
    if let Some(contradiction) = statements.contradiction() {
        debug_assert!(false, "{contradiction}");
        return Ok(PointReport::undecided(contradiction.into()));
    }
    Ok(PointReport {
        of: Subject::Model,
        epsilon: None,
        vanishing: Vec::new(),
        equilibrium: Answer::Known(equilibrium),
        outside_ranges,
        dimensions: Dimensions::new(local.growth, local.dimension, local.strong_growth, local.strong_dimension),
        linear_controllability_rank: rank,
        stabilizable,
        stabilizable_reason,
        uncontrollable_modes: unreached.map(|u| u.map(|found| uncontrollable_modes(pool, &frame, &found)).into()),
        brockett_condition,
        stlc,
        smoothed_stlc: None,
        relative_degree_defined: None,
    })
}

impl PointReport {
    /// No statement, where the equations cannot be evaluated at the point.
    pub(crate) fn undecided(why: Reason) -> PointReport {
        let open = || Answer::Unknown(why.clone());
        PointReport {
            of: Subject::Model,
            epsilon: None,
            vanishing: Vec::new(),
            equilibrium: Answer::Unknown(why.clone()),
            outside_ranges: Vec::new(),
            dimensions: Dimensions::new(Vec::new(), open(), Vec::new(), open()),
            linear_controllability_rank: None,
            stabilizable: None,
            stabilizable_reason: None,
            uncontrollable_modes: None,
            brockett_condition: None,
            stlc: Stlc::inconclusive(StlcReason::Withheld(why)),
            smoothed_stlc: None,
            relative_degree_defined: None,
        }
    }
}

/// Which equations a statement speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Subject {
    /// The model as it stands.
    Model,
    /// The model with every switching function replaced by a smooth one.
    Smoothed,
}

/// What vanishes at a point and is set-valued there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Vanishing {
    /// A switching function.
    Switch(Function),
    /// All components of a unit vector.
    UnitVector(Vec<Function>),
}

impl fmt::Display for Vanishing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Vanishing::Switch(function) => write!(f, "{function}"),
            Vanishing::UnitVector(list) => {
                let list: Vec<String> = list.iter().map(ToString::to_string).collect();
                write!(f, "({})", list.join(", "))
            }
        }
    }
}

serialized_as_text!(Vanishing);

/// What holds at the point of the model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointReport {
    /// Whether dimensions, rank and uncontrollable modes are of the model or, where switching functions vanish at the
    /// point, of the smoothed model. All other statements are of the model.
    pub of: Subject,
    /// Width of the smoothing; absent if the statements are of the model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epsilon: Option<f64>,
    /// Switching functions that vanish at the point; absent if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub vanishing: Vec<Vanishing>,
    /// Whether the state rests there under the inputs given with the point.
    pub equilibrium: Answer<bool>,
    /// Inputs whose values given with the point lie outside of their ranges, so that it is no equilibrium; absent if there
    /// are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outside_ranges: Vec<String>,
    /// Dimensions at the point.
    #[serde(flatten)]
    pub dimensions: Dimensions,
    /// Rank of the Kalman matrix; absent if the point is no equilibrium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linear_controllability_rank: Option<usize>,
    /// Whether feedback can make the equilibrium asymptotically stable; absent if the point is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stabilizable: Option<Answer<bool>>,
    /// What `stabilizable` rests on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stabilizable_reason: Option<StabilizableReason>,
    /// Eigenvalues of the linearization that no input reaches; absent if the point is no equilibrium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncontrollable_modes: Option<Answer<Vec<UncontrollableMode>>>,
    /// Brockett's necessary condition for stabilization by continuous state feedback; absent if
    /// the point is no equilibrium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub brockett_condition: Option<Answer<bool>>,
    /// Small-time local controllability.
    pub stlc: Stlc,
    /// That of the smoothed model, which says nothing of the model; absent if no switching function vanishes at the point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothed_stlc: Option<Stlc>,
    /// Whether the outputs have a vector relative degree at the point; absent for a model without inputs or outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_degree_defined: Option<Answer<bool>>,
}
