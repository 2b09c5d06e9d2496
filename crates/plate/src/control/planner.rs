//! Plans of moves from rest to rest of a given duration.

use super::interface::Command;
use super::move_problem::MoveProblem;
use super::oscillation::Oscillation;
use super::replay::Replay;
use crate::{PlateError, PlateKinematics};
use bracketry_mpc::qp::QpSettings;
use bracketry_mpc::{Dynamics, PlannedTrajectory, Rti, RtiSettings, Sqp, SqpSettings};

/// Width of rounded friction in m/s at which plans end.
const WIDTH: f64 = 0.005;
/// The same for feedback: wider is faster, and the replay sees to the end.
const FEEDBACK_WIDTH: f64 = 0.01;
/// Errors of x and y (m) and of yaw (rad) that are good enough for a plan.
const GOOD: [f64; 3] = [3e-4, 3e-4, 0.005];
/// Times a plan's aim is shifted by what its replay misses.
const AIMS: usize = 2;
/// Looser than elsewhere: plans are as short and as exact with 1e-4 as with 1e-8, and found faster.
fn qp_settings() -> QpSettings {
    QpSettings { tolerance: 1e-4, ..QpSettings::default() }
}

/// A move, proved by its replay with exact friction.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// States and inputs from sample to sample.
    pub(super) trajectory: PlannedTrajectory,
    /// Where it shall end.
    pub(super) target: [f64; 3],
    /// Where the optimizer aims, so that exact friction ends at the target.
    pub(super) aim: [f64; 3],
    /// What is missing at the end of the replay.
    pub(super) miss: [f64; 3],
    /// Quadratic programs solved.
    pub(super) programs: usize,
}

impl Plan {
    /// Whether it has fewer intervals.
    pub(super) fn is_shorter(&self, other: &Self) -> bool {
        self.trajectory.steps() < other.trajectory.steps()
    }

    /// Whether the replay with exact friction ends at the target.
    pub(super) fn is_good(&self) -> bool {
        cost(&self.miss) < 1.0
    }
}

/// Cost of a miss: the largest of its errors, each in units of what is good enough.
pub(super) fn cost(miss: &[f64; 3]) -> f64 {
    let worst = miss.iter().zip(GOOD).fold(0.0f64, |worst, (e, good)| worst.max(e.abs() / good));
    if miss.iter().all(|e| e.is_finite()) { worst } else { f64::INFINITY }
}

/// A solved problem.
struct Attempt {
    trajectory: PlannedTrajectory,
    miss: [f64; 3],
    programs: usize,
}

#[derive(Clone)]
pub(super) struct Planner {
    problem: MoveProblem,
}

impl Planner {
    pub(super) fn new(problem: MoveProblem) -> Self {
        Self { problem }
    }

    pub(super) fn problem(&self) -> &MoveProblem {
        &self.problem
    }

    pub(super) fn problem_mut(&mut self) -> &mut MoveProblem {
        &mut self.problem
    }

    /// A plan of so many intervals, solved from an oscillation.
    pub(super) fn plan(
        &self,
        start: &[f64; 10],
        target: [f64; 3],
        mu: f64,
        steps: usize,
        swing: &Oscillation,
    ) -> Result<Plan, PlateError> {
        let settings = SqpSettings {
            max_iterations: 15,
            tolerance: 1e-4,
            smoothing: vec![0.1, 0.03, 0.01, WIDTH],
            continuation_iterations: 20,
            filter_iterations: 0,
            proximal: 0.5,
            qp: qp_settings(),
            ..SqpSettings::default()
        };
        let ocp = self.problem.ocp(steps, target);
        let mut sqp = Sqp::new(Box::new(self.problem.dynamics(mu)), ocp, settings)?;
        let guess = sqp.guess(start, &swing.inputs(steps, self.problem.interval()))?;
        let attempt = Self::solved(&mut sqp, start, &guess)?;
        self.aimed(start, target, mu, attempt)
    }

    fn solved(sqp: &mut Sqp, start: &[f64; 10], guess: &PlannedTrajectory) -> Result<Attempt, PlateError> {
        let solution = sqp.solve(start, guess)?;
        let finite = solution.trajectory.is_finite();
        let miss = std::array::from_fn(|i| if finite { solution.miss[i] } else { f64::NAN });
        Ok(Attempt { trajectory: solution.trajectory, miss, programs: solution.iterations.len() })
    }

    /// Shifts the aim until the replay with exact friction ends at the target.
    fn aimed(&self, start: &[f64; 10], target: [f64; 3], mu: f64, first: Attempt) -> Result<Plan, PlateError> {
        let miss = self.replayed(start, &first.trajectory, mu, target)?;
        let mut best = Plan { trajectory: first.trajectory, target, aim: target, miss, programs: first.programs };
        // What the optimizer misses by itself no shift of the aim brings back.
        if cost(&first.miss) > 3.0 {
            return Ok(best);
        }
        for _ in 0..AIMS {
            // An object that tips or lifts off misses infinitely.
            if best.is_good() || !cost(&best.miss).is_finite() {
                break;
            }
            let aim: [f64; 3] = std::array::from_fn(|i| best.aim[i] - best.miss[i]);
            let refined = self.refined(start, aim, mu, &best.trajectory, 15)?;
            let miss = self.replayed(start, &refined.trajectory, mu, target)?;
            best.programs += refined.programs;
            if cost(&miss) < cost(&best.miss) {
                best = Plan { trajectory: refined.trajectory, aim, miss, ..best };
            } else {
                break;
            }
        }
        Ok(best)
    }

    /// A plan of so many intervals, solved from one of fewer or more.
    pub(super) fn replan(&self, start: &[f64; 10], mu: f64, steps: usize, plan: &Plan) -> Result<Plan, PlateError> {
        let settings = SqpSettings {
            max_iterations: 15,
            tolerance: 1e-4,
            smoothing: vec![0.01, WIDTH],
            continuation_iterations: 10,
            filter_iterations: 0,
            qp: qp_settings(),
            proximal: 0.2,
            ..SqpSettings::default()
        };
        let ocp = self.problem.ocp(steps, plan.target);
        let mut sqp = Sqp::new(Box::new(self.problem.dynamics(mu)), ocp, settings)?;
        let guess = rescaled(&plan.trajectory, steps, self.problem.interval())?;
        let attempt = Self::solved(&mut sqp, start, &guess)?;
        self.aimed(start, plan.target, mu, attempt)
    }

    /// Solves on from a trajectory, at the narrowest width.
    fn refined(
        &self,
        start: &[f64; 10],
        aim: [f64; 3],
        mu: f64,
        trajectory: &PlannedTrajectory,
        programs: usize,
    ) -> Result<Attempt, PlateError> {
        let settings = SqpSettings {
            max_iterations: programs,
            tolerance: 1e-4,
            smoothing: vec![WIDTH],
            filter_iterations: 0,
            qp: qp_settings(),
            proximal: 0.05,
            ..SqpSettings::default()
        };
        let ocp = self.problem.ocp(trajectory.steps(), aim);
        let mut sqp = Sqp::new(Box::new(self.problem.dynamics(mu)), ocp, settings)?;
        Self::solved(&mut sqp, start, trajectory)
    }

    /// The program that brings a plan under way back to the target, prepared for a state near `state`, and what the plan misses
    /// as it is; no program where exact friction says that it arrives.
    pub(super) fn correction(
        &self,
        state: &[f64; 10],
        target: [f64; 3],
        mu: f64,
        trajectory: &PlannedTrajectory,
        time_limit: f64,
    ) -> Result<([f64; 3], Option<Rti>), PlateError> {
        let miss = self.replayed(state, trajectory, mu, target)?;
        if cost(&miss) < 1.0 {
            return Ok((miss, None));
        }
        let mut dynamics = self.problem.feedback_dynamics(mu);
        dynamics.set_smoothing(FEEDBACK_WIDTH);
        let predicted = dynamics.rolled_out(state, trajectory, self.problem.interval())?;
        // The end of the model has to move by what exact friction misses.
        let end = predicted.x(predicted.steps());
        let aim = std::array::from_fn(|i| if miss[i].is_finite() { end[i] - miss[i] } else { target[i] });
        let settings = RtiSettings {
            smoothing: Some(FEEDBACK_WIDTH),
            proximal: 0.05,
            guarded: true,
            time_limit,
            qp: qp_settings(),
            ..RtiSettings::default()
        };
        let mut rti = Rti::new(Box::new(dynamics), self.problem.ocp(trajectory.steps(), aim), predicted, settings)?;
        rti.prepare()?;
        Ok((miss, Some(rti)))
    }

    /// What the inputs of a trajectory miss with exact friction.
    fn replayed(
        &self,
        start: &[f64; 10],
        trajectory: &PlannedTrajectory,
        mu: f64,
        target: [f64; 3],
    ) -> Result<[f64; 3], PlateError> {
        let mut object = Replay::new(self.problem.object(), mu)?;
        object.set_state(std::array::from_fn(|i| start[i]))?;
        let mut plate = PlateKinematics {
            displacement: start[6],
            velocity: start[7],
            tilt: start[8],
            tilt_rate: start[9],
            ..PlateKinematics::default()
        };
        let dt = self.problem.interval();
        for k in 0..trajectory.steps() {
            let u = trajectory.u(k);
            let command = Command { displacement_acceleration: u[0], tilt_acceleration: u[1] };
            object.advance(&plate, command, dt)?;
            plate = command.applied_to(&plate).after(dt);
        }
        for _ in 0..10 {
            let still = PlateKinematics { displacement: plate.displacement, ..PlateKinematics::default() };
            object.advance(&still, Command::default(), dt)?;
        }
        let state = object.state();
        Ok(std::array::from_fn(|i| if object.ended() { f64::INFINITY } else { state[i] - target[i] }))
    }
}

/// The way of a trajectory in another number of intervals: what moves, moves faster or slower.
fn rescaled(trajectory: &PlannedTrajectory, steps: usize, interval: f64) -> Result<PlannedTrajectory, PlateError> {
    let ratio = trajectory.steps() as f64 / steps as f64;
    let interpolated = |k: usize| -> Vec<f64> {
        let place = (k as f64 * ratio).min(trajectory.steps() as f64);
        let before = (place as usize).min(trajectory.steps() - 1);
        let (a, b, part) = (trajectory.x(before), trajectory.x(before + 1), place - before as f64);
        let rate = |i: usize| if matches!(i, 0..3 | 6 | 8) { 1.0 } else { ratio };
        (0..a.len()).map(|i| rate(i) * (a[i] + part * (b[i] - a[i]))).collect()
    };
    let x: Vec<Vec<f64>> = (0..=steps).map(interpolated).collect();
    let u: Vec<Vec<f64>> =
        x.windows(2).map(|pair| [7, 9].map(|i| (pair[1][i] - pair[0][i]) / interval).to_vec()).collect();
    Ok(PlannedTrajectory::from_rows(&x, &u)?)
}
