//! The optimal control problem of a move from rest to rest.

use super::limits::PlateLimits;
use super::rounded_contact::RoundedContact;
use crate::{GRAVITY, Object, PlateError, Shape};
use bracketry_mpc::{
    Bounds, CostFunction, CostKind, MpcError, Ocp, PathConstraint, Softness, Substeps, TerminalTarget, VectorFunction,
};
use bracketry_system::System;

/// Names for costs and constraints; the equations are those of [`RoundedContact`].
const NAMES: &str = r#"
states   = ["x", "y", "phi", "vx", "vy", "w", "X", "Xd", "theta", "thetad"]
inputs   = ["Xdd", "thetadd"]
dynamics = { x = "vx", y = "vy", phi = "w", vx = "-Xdd", vy = "0", w = "0", X = "Xd", Xd = "Xdd", theta = "thetad", thetad = "thetadd" }
"#;

/// Miss of each state that costs about 1.5: what targets and defects are measured in.
const TOLERANCE: [f64; 10] = [0.01, 0.01, 0.1, 0.05, 0.05, 0.3, 0.01, 0.02, 0.05, 0.2];
/// How much more a miss of the plate's own rest costs than one of the object: what is level and at rest stays.
const REST: f64 = 30.0;
/// Least pressure at the rim, in units of gravity, that plans keep.
const LEAST_PRESSURE: f64 = 0.14;
/// Contact points of the model: 16 agree with 48 to a few per mille.
const POINTS: usize = 16;
/// The same for feedback, which corrects the model's error at the end by a replay.
const FEEDBACK_POINTS: usize = 12;

/// Moves of one object on a plate with bounds.
#[derive(Clone)]
pub(super) struct MoveProblem {
    object: Object,
    template: Ocp,
    contact: RoundedContact,
    feedback: RoundedContact,
}

impl MoveProblem {
    /// Inputs are constant over intervals of `interval` seconds; `margin` is the share of every bound that is left to feedback
    /// and to what happens within an interval.
    pub(super) fn new(object: &Object, limits: &PlateLimits, interval: f64, margin: f64) -> Result<Self, PlateError> {
        limits.validate()?;
        let contact = RoundedContact::new(object, 0.3, POINTS)?;
        let feedback = RoundedContact::new(object, 0.3, FEEDBACK_POINTS)?;
        let template = template(object, limits, interval, margin)?;
        Ok(Self { object: object.clone(), template, contact, feedback })
    }

    pub(super) fn object(&self) -> &Object {
        &self.object
    }

    /// Length of an interval in s.
    pub(super) fn interval(&self) -> f64 {
        self.template.dt
    }

    /// The model of plans with a friction coefficient.
    pub(super) fn dynamics(&self, mu: f64) -> RoundedContact {
        self.contact.with_mu(mu)
    }

    /// The model of feedback, with fewer contact points.
    pub(super) fn feedback_dynamics(&self, mu: f64) -> RoundedContact {
        self.feedback.with_mu(mu)
    }

    /// The problem of reaching a pose, at rest, after `steps` intervals.
    pub(super) fn ocp(&self, steps: usize, target: [f64; 3]) -> Ocp {
        let mut ocp = self.template.clone();
        ocp.steps = steps;
        for (target, value) in ocp.targets.iter_mut().zip(target) {
            target.value = value;
        }
        ocp
    }
}

fn template(object: &Object, limits: &PlateLimits, interval: f64, margin: f64) -> Result<Ocp, MpcError> {
    let system = System::parse("plate_move", NAMES).map_err(|_| MpcError::Value {
        what: "the period of the plate's controller".into(),
        value: interval,
        remedy: "give a positive number",
    })?;
    let mut ocp = Ocp::new(10, 2, 1, interval);
    ocp.substeps = Substeps::AtLeast(1);
    let share = 1.0 - margin;
    let (along, turning) = (limits.displacement_acceleration, limits.tilt_acceleration);
    let cost = format!("0.05*(Xdd/{along})^2 + 0.05*(thetadd/{turning})^2");
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], &cost)?);
    ocp.input_bounds = vec![(-along * share, along * share), (-turning * share, turning * share)];
    ocp.input_trust = vec![along, turning];
    let soft = |max: f64, weight: f64| Bounds {
        min: -max * share,
        max: max * share,
        softness: Softness::Soft { linear: weight, quadratic: weight },
    };
    ocp.state_bounds[6] = soft(limits.stroke, 5e4);
    ocp.state_bounds[8] = soft(limits.tilt, 1e4);
    for (number, text) in pressure(object, interval).into_iter().enumerate() {
        let function = VectorFunction::parse(&system, &[], &[&text])?;
        let softness = Softness::Soft { linear: 1e3, quadratic: 1e3 };
        ocp.path_constraints.push(PathConstraint {
            name: format!("pressure {}", number + 1),
            function,
            bounds: Bounds { min: LEAST_PRESSURE, max: f64::INFINITY, softness },
            at_end: false,
        });
    }
    ocp.targets = TOLERANCE
        .iter()
        .enumerate()
        .map(|(state, e)| {
            let weight = if state > 6 { REST } else { 1.0 };
            TerminalTarget { state, value: 0.0, linear: weight / e, quadratic: 0.5 / (e * e) }
        })
        .collect();
    ocp.state_scale = TOLERANCE.to_vec();
    for (state, trust) in [(3, 0.1), (4, 0.1), (5, 1.0)] {
        ocp.state_trust[state] = trust;
    }
    Ok(ocp)
}

/// The least pressure on the footprint in units of gravity at the beginning of an interval and, with the tilt's rate of its
/// end, at the end: one expression for an ellipse, one for each corner of a polygon.
fn pressure(object: &Object, interval: f64) -> Vec<String> {
    let rates = ["thetad".to_owned(), format!("(thetad + {interval}*thetadd)")];
    rates
        .iter()
        .flat_map(|rate| {
            let uniform = format!("{GRAVITY}*cos(theta) + y*thetadd + 2*vy*{rate} - {}*{rate}^2", object.height);
            // The slope of the pressure along the object's own axes.
            let along = format!("(2*{rate}*w*cos(phi) + thetadd*sin(phi))");
            let across = format!("(thetadd*cos(phi) - 2*{rate}*w*sin(phi))");
            let ellipse = |a: f64, b: f64| {
                vec![format!("({uniform} - sqrt(({a}*{along})^2 + ({b}*{across})^2 + 1e-4))/{GRAVITY}")]
            };
            match &object.shape {
                Shape::Disk { radius } => ellipse(*radius, *radius),
                Shape::Ellipse { a, b } => ellipse(*a, *b),
                // Of rectangles and polygons the rim is asked for with few points: it always has the corners.
                shape => shape
                    .rim(1)
                    .into_iter()
                    .map(|[p, q]| format!("({uniform} + ({p})*{along} + ({q})*{across})/{GRAVITY}"))
                    .collect(),
            }
        })
        .collect()
}
