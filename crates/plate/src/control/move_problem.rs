//! The optimal control problem of a move from rest to rest.

use super::limits::PlateLimits;
use super::rounded_contact::RoundedContact;
use crate::object::Patch;
use crate::{GRAVITY, Object, PlateError, Shape};
use bracketry_mpc::ocp::{Bounds, PathConstraint, Softness, Substeps, VectorFunction};
use bracketry_mpc::{CostFunction, CostKind, MpcError, Ocp, TerminalTarget};
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
        let pressures = pressure(object, &Patch::of(object, POINTS)?, interval);
        let template = template(&pressures, limits, interval, margin)?;
        Ok(Self { object: object.clone(), template, contact, feedback })
    }

    /// The same problem with the models of an object that differs a little. The constraint on its pressure stays.
    pub(super) fn set_object(&mut self, object: &Object) -> Result<(), PlateError> {
        if *object != self.object {
            self.contact = RoundedContact::new(object, 0.3, POINTS)?;
            self.feedback = RoundedContact::new(object, 0.3, FEEDBACK_POINTS)?;
            self.object = object.clone();
        }
        Ok(())
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

fn template(pressures: &[String], limits: &PlateLimits, interval: f64, margin: f64) -> Result<Ocp, MpcError> {
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
    for (number, text) in pressures.iter().enumerate() {
        let function = VectorFunction::parse(&system, &[], &[text])?;
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

/// The least pressure on the bearing in units of gravity at the beginning of an interval and, with the tilt's rate of its
/// end, at the end: one expression for an ellipse, one for each corner of a polygon. See [`Patch::response`].
fn pressure(object: &Object, patch: &Patch, interval: f64) -> Vec<String> {
    let rates = ["thetad".to_owned(), format!("(thetad + {interval}*thetadd)")];
    let [dx, dy] = object.center_of_mass;
    let (y, vy) = if [dx, dy] == [0.0; 2] {
        ("y".to_owned(), "vy".to_owned())
    } else {
        (format!("(y + ({dx})*sin(phi) + ({dy})*cos(phi))"), format!("(vy + w*(({dx})*cos(phi) - ({dy})*sin(phi)))"))
    };
    rates
        .iter()
        .flat_map(|rate| {
            let mean = format!("({GRAVITY}*cos(theta) + {y}*thetadd + 2*{vy}*{rate} - {}*{rate}^2)", object.height);
            // The rates of the pressure that inertia asks for along the object's own axes.
            let along = format!("(2*{rate}*w*cos(phi) + thetadd*sin(phi))");
            let across = format!("(thetadd*cos(phi) - 2*{rate}*w*sin(phi))");
            let combined = |(level, [p, q]): (f64, [f64; 2])| {
                let terms = [(level, &mean), (p, &along), (q, &across)];
                let terms: Vec<String> =
                    terms.iter().filter(|t| t.0 != 0.0).map(|(c, e)| format!("({c})*{e}")).collect();
                if terms.is_empty() { "0".to_owned() } else { format!("({})", terms.join(" + ")) }
            };
            let at = |point: [f64; 2]| patch.response(object, point);
            let [x, y] = patch.center;
            let ellipse = |a: f64, b: f64| {
                let middle = at([x, y]);
                // How the pressure changes from the middle to the rim along an axis.
                let change = |point: [f64; 2]| {
                    let (level, [p, q]) = at(point);
                    combined((level - middle.0, [p - middle.1[0], q - middle.1[1]]))
                };
                let (right, upper) = (change([x + patch.scale * a, y]), change([x, y + patch.scale * b]));
                vec![format!("({} - sqrt({right}^2 + {upper}^2 + 1e-4))/{GRAVITY}", combined(middle))]
            };
            match &patch.hull {
                Shape::Disk { radius } => ellipse(*radius, *radius),
                Shape::Ellipse { a, b } => ellipse(*a, *b),
                // Of rectangles and polygons the rim is asked for with few points: it always has the corners.
                shape => {
                    let corners = shape.rim(1).into_iter();
                    corners
                        .map(|[p, q]| format!("{}/{GRAVITY}", combined(at([x + patch.scale * p, y + patch.scale * q]))))
                        .collect()
                }
            }
        })
        .collect()
}
