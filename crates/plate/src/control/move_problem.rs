//! The optimal control problem of a move from rest to rest.

use super::{PlateLimits, RoundedContact};
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
/// Least pressure at the rim, in units of gravity, that plans keep.
const LEAST_PRESSURE: f64 = 0.08;
/// Contact points of the model: 16 agree with 48 to a few per mille.
const POINTS: usize = 16;

/// Moves of one object on a plate with bounds.
#[derive(Clone)]
pub(super) struct MoveProblem {
    object: Object,
    template: Ocp,
    contact: RoundedContact,
}

/// Intervals of a problem.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    /// How many.
    pub(super) steps: usize,
    /// Their length in s.
    pub(super) dt: f64,
}

impl MoveProblem {
    /// `margin` is the share of every bound that is left to feedback.
    pub(super) fn new(object: &Object, limits: &PlateLimits, period: f64, margin: f64) -> Result<Self, PlateError> {
        limits.validate()?;
        let contact = RoundedContact::new(object, 0.3, POINTS)?;
        let template = template(object, limits, period, margin)?;
        Ok(Self { object: object.clone(), template, contact })
    }

    pub(super) fn object(&self) -> &Object {
        &self.object
    }

    pub(super) fn period(&self) -> f64 {
        self.template.dt
    }

    /// The model with a friction coefficient.
    pub(super) fn dynamics(&self, mu: f64) -> RoundedContact {
        self.contact.with_mu(mu)
    }

    /// The problem of reaching a pose, at rest, on a grid of intervals.
    pub(super) fn ocp(&self, grid: Grid, target: [f64; 3]) -> Ocp {
        let mut ocp = self.template.clone();
        ocp.steps = grid.steps;
        ocp.dt = grid.dt;
        for (target, value) in ocp.targets.iter_mut().zip(target) {
            target.value = value;
        }
        ocp
    }
}

fn template(object: &Object, limits: &PlateLimits, period: f64, margin: f64) -> Result<Ocp, MpcError> {
    let system = System::parse("plate_move", NAMES).map_err(|_| MpcError::Value {
        what: "the period of the plate's controller".into(),
        value: period,
        remedy: "give a positive number",
    })?;
    let mut ocp = Ocp::new(10, 2, 1, period);
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
    for text in pressure(object) {
        let function = VectorFunction::parse(&system, &[], &[&text])?;
        let softness = Softness::Soft { linear: 1e3, quadratic: 1e3 };
        ocp.path_constraints
            .push(PathConstraint { function, bounds: Bounds { min: LEAST_PRESSURE, max: f64::INFINITY, softness } });
    }
    ocp.targets = TOLERANCE
        .iter()
        .enumerate()
        .map(|(state, e)| TerminalTarget { state, value: 0.0, linear: 1.0 / e, quadratic: 0.5 / (e * e) })
        .collect();
    ocp.state_scale = TOLERANCE.to_vec();
    for (state, trust) in [(3, 0.1), (4, 0.1), (5, 1.0)] {
        ocp.state_trust[state] = trust;
    }
    Ok(ocp)
}

/// The least pressure on the footprint in units of gravity, as expressions whose least value it is: one for an ellipse, one
/// for each corner of a polygon.
fn pressure(object: &Object) -> Vec<String> {
    let uniform = format!("{GRAVITY}*cos(theta) + y*thetadd + 2*vy*thetad - {}*thetad^2", object.height);
    // The slope of the pressure along the object's own axes.
    let along = "(2*thetad*w*cos(phi) + thetadd*sin(phi))";
    let across = "(thetadd*cos(phi) - 2*thetad*w*sin(phi))";
    let ellipse = |a: f64, b: f64| {
        let slope = format!("sqrt(({a}*{along})^2 + ({b}*{across})^2 + 1e-4)");
        vec![format!("({uniform} - {slope})/{GRAVITY}")]
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
}
