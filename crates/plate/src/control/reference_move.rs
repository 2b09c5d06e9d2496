//! The reference move: position and orientation of the object on the plate at the same time.

use bracketry_mpc::ControlProblem;
use bracketry_mpc::problem::ProblemError;
use bracketry_sim::Trajectory;
use bracketry_system::System;
use serde::Serialize;

use super::area_loop_plant::RESOLUTION;
use super::oscillation::Oscillation;
use crate::{PlateError, Shape, published};

/// The plate rests within 1 mm and 0.1° of its middle and slower than 1 mm/s and 0.1 °/s.
const PLATE_REST: f64 = 1e-3;
const PLATE_REST_DEG: f64 = 0.1;

/// The oscillation of the file's guess: Hz, m, deg.
const GUESS_FREQUENCY: f64 = 3.0;
const GUESS_DISPLACEMENT: f64 = 0.03;
const GUESS_TILT_DEG: f64 = 8.0;

/// A constraint of the move on top of those in the file. The equations know neither lift-off nor tipping, and other models than the
/// published one go where these happen: the load that the friction law contains is kept above three tenths of the weight.
const IN_CONTACT: &str = "load = { expression = \"g*cos(theta) + y*thetadd\", min = \"0.3*g\" }\n";

/// A move that cannot be set up.
#[derive(Debug, thiserror::Error)]
pub enum MoveError {
    /// The object or the friction coefficient.
    #[error(transparent)]
    Plate(#[from] PlateError),
    /// The problem.
    #[error(transparent)]
    Problem(#[from] ProblemError),
}

/// The reference move of `models/plate_move.toml`, the object kept in contact, with another object or friction coefficient, in model and plant:
/// (0.48 m, −0.03 m, 0°) to (0.54 m, 0 m, 90°), stroke ±0.1 m, tilt ±20°, |X''| ≤ 15 m/s², |θ''| ≤ 60 rad/s².
///
/// # Errors
/// [`MoveError`] if a length or coefficient has no meaning.
pub fn plate_move(shape: &Shape, mu: f64) -> Result<ControlProblem, MoveError> {
    move_with(&published(shape, mu)?)
}

/// The reference move with another model of the plate as the controller's model.
///
/// # Errors
/// [`MoveError::Problem`] for a model without the states of the plate.
pub fn move_with(model: &System) -> Result<ControlProblem, MoveError> {
    let text =
        include_str!("../../models/plate_move.toml").replacen("\n[target]", &format!("{IN_CONTACT}\n[target]"), 1);
    Ok(ControlProblem::parse("plate_move.toml", &text, |_| Ok(model.clone()))?)
}

/// Gives a move another duration, `steps` sampling periods, and as a guess a plain oscillation of about `frequency` Hz.
pub fn with_duration(problem: &mut ControlProblem, steps: usize, frequency: f64) {
    let duration = steps as f64 * problem.ocp.dt;
    let frequency = (frequency * duration).round().max(1.0) / duration;
    // Accelerations of this size stay within the bounds.
    let slower = (GUESS_FREQUENCY / frequency).powi(2);
    let guess = Oscillation {
        frequency,
        displacement: GUESS_DISPLACEMENT * slower,
        tilt: GUESS_TILT_DEG.to_radians() * slower,
        phase: 0.0,
    };
    problem.guess = guess.inputs(steps, problem.ocp.dt);
    problem.ocp.steps = steps;
    problem.samples = steps;
}

/// What a move achieved, from the recording of the plant. States are those of the affine plate:
/// x, y, phi, vx, vy, w, X, Xd, theta, thetad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Arrival {
    /// Error in x at the end (m).
    pub x_m: f64,
    /// Error in y at the end (m).
    pub y_m: f64,
    /// Error in yaw at the end (deg).
    pub phi_deg: f64,
    /// Spin at the end (deg/s).
    pub spin_deg_s: f64,
    /// First time (s) from which on the object stays within 2 mm, 2° and 2 °/s of its target while the plate is and
    /// stays at rest; absent if it does not.
    pub settled_s: Option<f64>,
    /// How far |X| exceeds the stroke at most, looked at every millisecond (m); 0 when kept.
    pub stroke_excess_m: f64,
    /// How far |θ| exceeds the tilt bound at most (deg); 0 when kept.
    pub tilt_excess_deg: f64,
}

/// Where a move shall end: x (m), y (m), yaw (rad), from the targets of the problem; 0 where there is none.
pub fn target_of(problem: &ControlProblem) -> [f64; 3] {
    std::array::from_fn(|i| problem.ocp.targets.iter().find(|t| t.state == i).map_or(0.0, |t| t.value))
}

impl Arrival {
    /// How near the object is to its target where it has arrived: m along x and y.
    pub const TOLERANCE_M: f64 = 2e-3;
    /// The same in yaw, deg, and in spin, deg/s.
    pub const TOLERANCE_DEG: f64 = 2.0;

    /// Measures the recorded move of a plant against the problem's targets and bounds.
    pub fn of(problem: &ControlProblem, trajectory: &Trajectory) -> Arrival {
        let count = (trajectory.end() / RESOLUTION).round() as usize;
        let states = (0..=count).map(|k| trajectory.sample(k as f64 * RESOLUTION));
        Self::of_states(problem, states, trajectory.final_state())
    }

    /// The same from the states at every millisecond and the last one.
    pub fn of_states(
        problem: &ControlProblem,
        states: impl IntoIterator<Item = impl AsRef<[f64]>>,
        end: &[f64],
    ) -> Arrival {
        let target = target_of(problem);
        let (mut stroke, mut tilt) = (0.0f64, 0.0f64);
        let mut last_bad = None;
        let mut count = 0;
        for (k, x) in states.into_iter().enumerate() {
            let x = x.as_ref();
            count = k;
            let near = |i: usize, tolerance: f64| (x[i] - target[i]).abs() <= tolerance;
            let (distance, angle) = (Self::TOLERANCE_M, Self::TOLERANCE_DEG.to_radians());
            let object = near(0, distance) && near(1, distance) && near(2, angle) && x[5].abs() <= angle;
            let plate = [x[6], x[7]].iter().all(|v| v.abs() <= PLATE_REST)
                && [x[8], x[9]].iter().all(|v| v.abs() <= PLATE_REST_DEG.to_radians());
            if !(object && plate) {
                last_bad = Some(k);
            }
            let beyond = |i: usize| {
                let b = problem.ocp.state_bounds[i];
                (x[i] - b.max).max(b.min - x[i])
            };
            stroke = stroke.max(beyond(6));
            tilt = tilt.max(beyond(8));
        }
        let settled_s = match last_bad {
            None => Some(0.0),
            Some(k) if k == count => None,
            Some(k) => Some((k + 1) as f64 * RESOLUTION),
        };
        Arrival {
            x_m: end[0] - target[0],
            y_m: end[1] - target[1],
            phi_deg: (end[2] - target[2]).to_degrees(),
            spin_deg_s: end[5].to_degrees(),
            settled_s,
            stroke_excess_m: stroke,
            tilt_excess_deg: tilt.to_degrees(),
        }
    }
}
