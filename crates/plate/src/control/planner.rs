//! Plans of moves from rest to rest.

use super::interface::Command;
use super::move_problem::MoveProblem;
use super::oscillation::Oscillation;
use super::replay::Replay;
use crate::{PlateError, PlateKinematics};
use bracketry_mpc::{Dynamics, QpSettings, Rti, RtiSettings, Sqp, SqpSettings, Trajectory};
use std::time::Instant;

/// Width of rounded friction in m/s at which plans end.
const WIDTH: f64 = 0.005;
/// The same for feedback: wider is faster, and the replay sees to the end.
const FEEDBACK_WIDTH: f64 = 0.01;
/// Errors of x and y (m) and of yaw (rad) that are good enough for a plan.
const GOOD: [f64; 3] = [3e-4, 3e-4, 0.005];
/// Times a plan's aim is shifted by what its replay misses.
const AIMS: usize = 2;
/// Shortest and longest duration of a move in s.
const SHORTEST: f64 = 0.5;
const LONGEST: f64 = 4.0;
/// Durations tried for one move.
const DURATIONS: usize = 3;
/// Oscillations that the search starts from.
const SWINGS: [Oscillation; 3] = [
    Oscillation { frequency: 2.5, displacement: 0.03, tilt: 0.1, phase: 0.0 },
    Oscillation { frequency: 2.0, displacement: 0.04, tilt: 0.12, phase: 0.0 },
    Oscillation { frequency: 3.2, displacement: 0.02, tilt: 0.08, phase: 0.0 },
];

/// Duration in s at which the search for a move by x, y (m) and yaw (rad) begins.
fn expected_duration([x, y, yaw]: [f64; 3]) -> f64 {
    (0.4 + yaw.abs() / 1.4 + 3.0 * x.abs().max(y.abs())).clamp(SHORTEST, LONGEST)
}

fn qp_settings() -> QpSettings {
    QpSettings { tolerance: 1e-6, ..QpSettings::default() }
}

/// A move, proved by its replay with exact friction.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// States and inputs from sample to sample.
    pub(super) trajectory: Trajectory,
    /// Where the optimizer aims, so that exact friction ends at the target.
    pub(super) aim: [f64; 3],
    /// What is missing at the end of the replay.
    pub(super) miss: [f64; 3],
    /// Quadratic programs solved.
    pub(super) programs: usize,
    /// Wall time in s.
    pub(super) seconds: f64,
}

/// Cost of a miss: the largest of its errors, each in units of what is good enough.
pub(super) fn cost(miss: &[f64; 3]) -> f64 {
    let worst = miss.iter().zip(GOOD).fold(0.0f64, |worst, (e, good)| worst.max(e.abs() / good));
    if miss.iter().all(|e| e.is_finite()) { worst } else { f64::INFINITY }
}

/// A solved problem.
struct Attempt {
    trajectory: Trajectory,
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

    /// The best plan found from a state at rest to a pose; absent if no program could be solved at all.
    ///
    /// Oscillations of several frequencies are tried, then longer durations.
    pub(super) fn plan(&self, start: &[f64; 10], target: [f64; 3], mu: f64) -> Result<Option<Plan>, PlateError> {
        let clock = Instant::now();
        let delta: [f64; 3] = std::array::from_fn(|i| target[i] - start[i]);
        let mut duration = expected_duration(delta);
        let dt = self.problem.interval();
        let (mut best, mut programs): (Option<Attempt>, usize) = (None, 0);
        'search: for _ in 0..DURATIONS {
            let mut least = f64::INFINITY;
            for swing in SWINGS {
                let attempt = self.attempt(start, target, mu, (duration / dt).ceil() as usize, swing)?;
                programs += attempt.programs;
                let found = cost(&attempt.miss);
                least = least.min(found);
                if best.as_ref().is_none_or(|b| found < cost(&b.miss)) {
                    best = Some(attempt);
                }
                if found < 1.0 {
                    break 'search;
                }
            }
            duration = (duration * if least > 30.0 { 1.35 } else { 1.15 }).min(LONGEST);
        }
        let Some(best) = best else {
            return Ok(None);
        };
        let mut plan = self.aimed(start, target, mu, best)?;
        plan.programs += programs;
        plan.seconds = clock.elapsed().as_secs_f64();
        Ok(Some(plan))
    }

    /// Solves for a number of intervals from an oscillation.
    fn attempt(
        &self,
        start: &[f64; 10],
        target: [f64; 3],
        mu: f64,
        steps: usize,
        swing: Oscillation,
    ) -> Result<Attempt, PlateError> {
        let dt = self.problem.interval();
        let duration = steps as f64 * dt;
        let oscillation = Oscillation {
            frequency: (swing.frequency * duration).round().max(1.0) / duration,
            tilt: swing.tilt.copysign(target[2] - start[2]),
            ..swing
        };
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
        let guess = sqp.guess(start, &oscillation.inputs(steps, dt))?;
        Self::solved(&mut sqp, start, &guess)
    }

    fn solved(sqp: &mut Sqp, start: &[f64; 10], guess: &Trajectory) -> Result<Attempt, PlateError> {
        let solution = sqp.solve(start, guess)?;
        let finite = solution.trajectory.is_finite();
        let miss = std::array::from_fn(|i| if finite { solution.miss[i] } else { f64::NAN });
        Ok(Attempt { trajectory: solution.trajectory, miss, programs: solution.iterations.len() })
    }

    /// Shifts the aim until the replay with exact friction ends at the target.
    fn aimed(&self, start: &[f64; 10], target: [f64; 3], mu: f64, first: Attempt) -> Result<Plan, PlateError> {
        let miss = self.replayed(start, &first.trajectory, mu, target)?;
        let mut best = Plan { trajectory: first.trajectory, aim: target, miss, programs: 0, seconds: 0.0 };
        // What the optimizer misses by itself no shift of the aim brings back.
        if cost(&first.miss) > 3.0 {
            return Ok(best);
        }
        for _ in 0..AIMS {
            if cost(&best.miss) < 1.0 {
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

    /// Solves on from a trajectory, at the narrowest width.
    fn refined(
        &self,
        start: &[f64; 10],
        aim: [f64; 3],
        mu: f64,
        trajectory: &Trajectory,
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
        trajectory: &Trajectory,
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
        trajectory: &Trajectory,
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
