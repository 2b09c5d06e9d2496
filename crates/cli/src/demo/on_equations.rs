//! Position and orientation together on the published equations, beside the published method of one after the other.

use bracketry::mpc::ControlProblem;
use bracketry::mpc::closed_loop::SolveTimes;
use bracketry::mpc::controller::Timings;
use bracketry::plate::control::Arrival;
use bracketry::plate::experiment::{AmplitudeStep, Experiment, TwoStep, two_step};
use bracketry::plate::{Shape, plate_move, published};
use bracketry::sim::SimulationSettings;

use super::loop_conditions::{measured, programs_of};
use super::settings::{StoryError, StorySettings};
use super::shortest::Shortest;
use bracketry::mpc::{Controlled, control};

/// Longest time of one stage of the two-step method (s).
const STAGE_LIMIT: f64 = 30.0;

/// The reference move on the exact stick–slip plant of the published equations.
#[derive(Clone)]
pub struct MoveOnEquations {
    /// The object.
    pub shape: Shape,
    /// Quadratic programs of the search for the shortest move, the plan, and the loop.
    pub programs: usize,
    /// The search for the shortest move.
    pub(super) shortest: Shortest,
    /// What was to be done.
    pub problem: ControlProblem,
    /// The closed loop.
    pub together: Controlled,
    /// What it achieved.
    pub arrival: Arrival,
    /// The published inputs on the same plant: orientation, then x, then y.
    pub two: TwoStep,
}

impl MoveOnEquations {
    /// Runs both methods.
    pub(super) fn run(
        shape: &Shape,
        settings: &StorySettings,
        working: &mut dyn FnMut(&str),
    ) -> Result<Self, StoryError> {
        let mut problem = plate_move(shape, settings.plant.mu)?;
        working("the shortest move");
        let shortest = Shortest::of(&problem)?;
        shortest.set(&mut problem);
        measured(&mut problem, &[], &settings.plant, settings.seed)?;
        // Afterwards everything has to stay where it is.
        problem.samples += settings.rest_samples;
        working("plan, then closed loop on exact stick–slip friction");
        let together = control(&problem)?;
        working("the published two-step method on the same plant");
        let two = published_method(shape, settings.plant.mu, &problem)?;
        let arrival = Arrival::of(&problem, &together.recording.trajectory);
        let programs = shortest.programs + programs_of(&together.run);
        Ok(Self { shape: shape.clone(), programs, shortest, problem, together, arrival, two })
    }

    /// Shortest duration (s) in which a plan arrives; absent if none was found.
    pub fn shortest_s(&self) -> Option<f64> {
        self.shortest.seconds()
    }

    /// When the last stage of the published method was stopped (s), if every stage met its target.
    pub fn two_step_time(&self) -> Option<f64> {
        self.two.stages.iter().all(|s| s.met).then(|| self.two.stages.last().map_or(0.0, |s| s.to))
    }

    /// Errors of x (m), y (m) and yaw (deg) at the end of the two-step method, whose stages go yaw, x, y.
    pub fn two_step_errors(&self) -> [Option<f64>; 3] {
        let error = |i: usize| self.two.final_errors.get(i).copied();
        [error(1), error(2), error(0).map(f64::to_degrees)]
    }

    /// Medians of linearization, quadratic program and rest over the solved samples (ms).
    pub fn step_split(&self) -> [f64; 3] {
        let of = |f: fn(&Timings) -> f64| {
            let solved = self.together.run.closed_loop.steps.iter().map(|s| &s.timings).filter(|t| t.total() > 0.0);
            SolveTimes::of(&solved.map(f).collect::<Vec<_>>()).median
        };
        [of(|t| t.linearize), of(|t| t.qp), of(|t| t.rest)]
    }

    /// Sampling periods in which a program was solved over the time that this took.
    pub fn real_time_factor(&self) -> f64 {
        let steps = &self.together.run.closed_loop.steps;
        let times: Vec<f64> = steps.iter().map(|s| s.timings.total()).filter(|t| *t > 0.0).collect();
        times.len() as f64 * self.problem.ocp.dt / times.iter().sum::<f64>()
    }
}

/// First orientation, then x, then y, with the published inputs. The published torque turns clockwise, so the tilt of
/// experiment 1 is flipped to aim at +90°.
fn published_method(shape: &Shape, mu: f64, problem: &ControlProblem) -> Result<TwoStep, StoryError> {
    let along_x = Experiment::translation_x(3).with_amplitude_step(AmplitudeStep::Smooth);
    let stages = [Experiment::orientation().with_reversed_tilt(), along_x, Experiment::translation_y()];
    // x, y, phi, vx, vy, w: the affine model's states without those of the plate.
    let start = &problem.x0[..6];
    Ok(two_step(&published(shape, mu)?, &stages, start, STAGE_LIMIT, &SimulationSettings::default())?)
}
