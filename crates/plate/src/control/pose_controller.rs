//! Position and orientation of the object at the same time, from any start to any target.

use super::displacement::{nearest_turn, repetition};
use super::interface::{Command, Measurement, PlateController};
use super::learned::{Learned, validate};
use super::leveling::leveling;
use super::motion_estimator::MotionEstimator;
use super::move_problem::MoveProblem;
use super::planned_commands::{GENTLE, command_of, is_over, rest_of};
use super::planner::{Plan, Planner, cost};
use super::replay::Replay;
use super::servo_lag::ServoLag;
use super::settings::{MoveReport, PoseReport, PoseSettings, PoseStatus};
use super::shortest::Search;
use crate::{Object, PlateError, PlateKinematics};
use bracketry_mpc::controller::StepStatus;
use bracketry_mpc::{PlannedTrajectory, Rti};
use std::collections::VecDeque;
use std::time::Instant;

/// Share of the bounds that plans and feedback leave free.
const MARGIN: f64 = 0.05;
/// Periods in an interval of plans.
const INTERVAL: usize = 2;
/// Intervals left at which the rest of a plan is played out.
const PLAYED_OUT: usize = 1;
/// Cost of the predicted end above which a move is made longer, intervals added at a time, and most of them.
const LATE: f64 = 8.0;
const EXTENSION: usize = 2;
const MOST_EXTENSION: usize = 20;
/// Errors of x and y (m) and of yaw (rad) at the end of a move that no program brings back, and replays in a row that have to
/// show them for it to be broken off.
const FAR: [f64; 3] = [0.12, 0.12, 2.0];
const LOST: usize = 3;
/// Most samples that the controller looks at the resting object before it believes the mean.
const LOOKS: usize = 25;
/// Standard deviations of the mean that a verdict has to be sure of.
const SURE: f64 = 2.5;
/// Least part of an error that a plan has to remove.
const PROGRESS: f64 = 0.8;
/// Samples of an object that has arrived whose mean decides whether it is still there.
const WATCHED: usize = 10;
/// Rates of the plate that count as rest, m/s and rad/s.
const STILL: f64 = 1e-7;
/// Share of a rate that is left after a move which is taken off within a period: less than all of it, since a servo follows late.
const BRAKING: f64 = 0.5;

enum Phase {
    /// Nothing has been measured yet.
    Start,
    /// Samples until the plan begins.
    Pause { plan: Plan, left: usize },
    /// A plan under way.
    Move(Box<Move>),
    /// A move that is broken off: the plate levels.
    Halt,
    /// Plate and object at rest; samples looked at.
    Look { samples: usize },
    /// Nothing to do but to watch: how many poses were measured since the last verdict, and their sum.
    Hold { seen: usize, sum: [f64; 3] },
}

/// The beginning of [`Phase::Hold`].
const HOLD: Phase = Phase::Hold { seen: 0, sum: [0.0; 3] };

/// A plan under way. An interval is two periods: at its second sample the next program is prepared, at the first sample of
/// the next interval it is solved for the state that the latest measurement gives.
struct Move {
    /// What is left, from the interval under way on.
    trajectory: PlannedTrajectory,
    /// Whether the first command of the interval has been given.
    half: bool,
    /// The program prepared for the next interval; absent where the plan goes on as it is.
    correction: Option<Rti>,
    /// Intervals by which it has been made longer.
    extended: usize,
    /// Programs in a row whose end misses the target.
    late: usize,
    /// Replays in a row that end far away.
    lost: usize,
}

/// Plans moves from rest to rest, follows them with one quadratic program every second sample, and corrects what they missed
/// by further moves until the object rests within the tolerance.
///
/// A plan is found on the area contact with rounded friction and proved on the exact one: the optimizer's aim is shifted until
/// a replay with set-valued friction ends at the target, before the move and on the way. On the way the friction coefficient
/// is estimated from the measured positions. At the end of each move the plate is level and friction holds the object, so
/// that the mean of the measurements tells where it is, and what has arrived stays. From then on the plate is kept at rest,
/// also where a servo follows its commands only nearly, and an object that is pushed away is brought back.
///
/// The first plan is made by the first call of [`PlateController::command`], which takes about a second. For corrections the
/// plate rests [`PoseSettings::planning_samples`] samples.
pub struct PoseController {
    settings: PoseSettings,
    target: [f64; 3],
    /// Where the move under way is aimed: the target, shifted by what moves like it have missed.
    aim: [f64; 3],
    /// The displacement that the last move was to make, x, y (m), yaw (rad).
    last_way: [f64; 3],
    planner: Planner,
    estimator: Option<MotionEstimator>,
    servo: ServoLag,
    phase: Phase,
    report: PoseReport,
    /// The plate at the last sample.
    plate: PlateKinematics,
    /// Commands that have been given and do not act yet.
    queue: VecDeque<Command>,
    /// The command that acted last, and the one before it.
    acted: Command,
    before: Command,
    /// Moves since the last arrival that were broken off: what one has taught lets the next go on longer.
    broken_off: usize,
    /// Moves up to the last arrival.
    moves_before: usize,
}

impl PoseController {
    /// A controller that brings the object to `target`: x, y (m), yaw (rad).
    ///
    /// # Errors
    /// [`PlateError`] if object, settings or target have no meaning.
    pub fn new(object: &Object, target: [f64; 3], settings: &PoseSettings) -> Result<Self, PlateError> {
        if let Some(value) = target.iter().find(|v| !v.is_finite()) {
            return Err(PlateError::BadState { value: *value });
        }
        validate(&settings.uncertainty, settings.mu_deviation)?;
        let problem = move_problem(object, settings)?;
        Ok(Self {
            target,
            aim: target,
            last_way: [0.0; 3],
            planner: Planner::new(problem),
            estimator: None,
            servo: ServoLag::new(),
            phase: Phase::Start,
            report: PoseReport {
                status: PoseStatus::Working,
                moves: Vec::new(),
                mu: settings.mu,
                learned: Learned::default(),
                lost: 0,
                unsolved: 0,
                sample_seconds: Vec::new(),
            },
            plate: PlateKinematics::default(),
            queue: std::iter::repeat_n(Command::default(), settings.delay).collect(),
            acted: Command::default(),
            before: Command::default(),
            broken_off: 0,
            moves_before: 0,
            settings: settings.clone(),
        })
    }

    /// What has been done so far.
    pub fn report(&self) -> &PoseReport {
        &self.report
    }

    /// The estimated state of the object `x, y, phi, vx, vy, w`; absent before the first measurement.
    pub fn estimate(&self) -> Option<[f64; 6]> {
        self.estimator.as_ref().map(MotionEstimator::state)
    }

    /// Plans from the estimated pose, at rest; where no plan makes progress, gives up.
    fn plan(&mut self, pause: usize) -> Result<(), PlateError> {
        let Some(estimator) = &mut self.estimator else { return Ok(()) };
        let unexplained = estimator.restart()?;
        let (state, (object, mu)) = (estimator.state(), estimator.object());
        if object != *self.planner.problem().object() {
            self.planner = Planner::new(move_problem(&object, &self.settings)?);
        }
        self.tell();
        let error: [f64; 3] = std::array::from_fn(|i| state[i] - self.target[i]);
        if self.report.moves.len() - self.moves_before >= self.settings.moves {
            self.report.status = PoseStatus::MovesUsedUp { miss: error };
            self.phase = HOLD;
            return Ok(());
        }
        let start = [state[0], state[1], state[2], 0.0, 0.0, 0.0, self.plate.displacement, 0.0, self.plate.tilt, 0.0];
        let way = error.map(|e| -e);
        let repeated = repetition(&way, &self.last_way);
        self.aim = std::array::from_fn(|i| self.target[i] - repeated * unexplained[i]);
        self.last_way = way;
        let clock = Instant::now();
        let budget =
            if self.report.moves.is_empty() { self.settings.first_plan } else { self.settings.correction_plan };
        let plan = Search { planner: &self.planner, start, target: self.aim, mu, budget }.run()?;
        let best = plan.as_ref().map_or(error, |p| if cost(&p.miss) < cost(&error) { p.miss } else { error });
        let Some(plan) = plan.filter(|p| cost(&p.miss) < PROGRESS * cost(&error)) else {
            // What was learned may be wrong.
            if let Some(estimator) = &mut self.estimator
                && estimator.forget_learned()?
            {
                return self.plan(pause);
            }
            self.report.status = PoseStatus::Unreachable { miss: best };
            self.phase = HOLD;
            return Ok(());
        };
        // The way round that is shorter.
        let turns = plan.target[2] - self.aim[2];
        self.target[2] += turns;
        self.aim[2] += turns;
        self.last_way[2] += turns;
        self.report.moves.push(MoveReport {
            duration: (plan.trajectory.steps() * INTERVAL) as f64 * self.settings.period,
            extended: 0,
            programs: plan.programs,
            seconds: clock.elapsed().as_secs_f64(),
            miss: plan.miss,
            mu,
        });
        self.phase = Phase::Pause { plan, left: pause };
        Ok(())
    }

    /// The verdict on an object at rest: arrived, to be corrected, or to be looked at longer.
    fn look(&mut self, samples: usize) -> Result<(), PlateError> {
        let Some(estimator) = &self.estimator else { return Ok(()) };
        let (state, deviation) = (estimator.state(), estimator.deviation());
        let [position, yaw] = self.settings.tolerance;
        let tolerance = [position, position, yaw];
        let error: [f64; 3] = std::array::from_fn(|i| (state[i] - self.target[i]).abs());
        let outside = (0..3).any(|i| error[i] - SURE * deviation[i] > tolerance[i]);
        let inside = (0..3).all(|i| error[i] + SURE * deviation[i] < tolerance[i]);
        let near = (0..3).all(|i| error[i] < 0.8 * tolerance[i]);
        let over = samples >= LOOKS;
        if inside && (over || deviation[0] < 0.1 * position) || (over && near) {
            self.report.status = PoseStatus::Arrived;
            (self.moves_before, self.broken_off) = (self.report.moves.len(), 0);
            self.phase = HOLD;
            return Ok(());
        }
        if outside || over {
            return self.plan(self.settings.planning_samples);
        }
        self.phase = Phase::Look { samples: samples + 1 };
        Ok(())
    }

    /// Whether the mean of so many measured poses is farther from the target than tolerance and noise explain.
    fn is_measured_away(&self, mean: [f64; 3], count: usize) -> bool {
        let ([position, yaw], noise) = (self.settings.tolerance, self.settings.noise);
        let beyond = |i: usize, tolerance: f64| {
            (mean[i] - self.target[i]).abs() > tolerance + SURE * noise[i / 2] / (count as f64).sqrt()
        };
        beyond(0, position) || beyond(1, position) || beyond(2, yaw)
    }

    /// Watches an object that has arrived, and sets out again if it is no longer there.
    fn watch(&mut self, measured: &[f64; 3], seen: usize, sum: [f64; 3]) -> Result<(), PlateError> {
        if measured.iter().any(|v| !v.is_finite()) {
            return Ok(());
        }
        let (seen, sum) = (seen + 1, std::array::from_fn(|i| sum[i] + measured[i]));
        self.phase = if seen < WATCHED { Phase::Hold { seen, sum } } else { HOLD };
        let away = seen == WATCHED && self.is_measured_away(sum.map(|s| s / seen as f64), seen);
        if away && let Some(estimator) = &mut self.estimator {
            estimator.forget_pose()?;
            self.report.status = PoseStatus::Working;
            self.phase = Phase::Look { samples: 0 };
        }
        Ok(())
    }

    /// Commands that are under way to the plate or in the queue, with the times for which they act.
    fn pending(&self) -> Vec<(Command, f64)> {
        let lag = self.lag();
        let under_way = (lag > 0.0).then_some((self.acted, lag));
        under_way.into_iter().chain(self.queue.iter().map(|c| (*c, self.settings.period))).collect()
    }

    /// The plate at the time from which the next command acts.
    fn expected_plate(&self) -> PlateKinematics {
        self.pending().iter().fold(self.plate, |plate, (command, time)| command.applied_to(&plate).after(*time))
    }

    /// The command that takes off a share of the plate's rates within a period, as far as the bounds allow.
    fn braking(&self, share: f64) -> Command {
        let (limits, period) = (self.settings.limits, self.settings.period);
        let plate = self.expected_plate();
        let braked = |rate: f64, limit: f64| {
            if rate.abs() <= STILL { 0.0 } else { (-share * rate / period).clamp(-limit, limit) }
        };
        Command {
            displacement_acceleration: braked(plate.velocity, limits.displacement_acceleration),
            tilt_acceleration: braked(plate.tilt_rate, limits.tilt_acceleration),
        }
    }

    /// Time in s by which the plate follows commands late.
    fn lag(&self) -> f64 {
        self.report.learned.servo_lag.value
    }

    /// Puts down what is known now.
    fn tell(&mut self) {
        if let Some(estimator) = &self.estimator {
            let servo_lag = self.servo.estimate(self.settings.period);
            self.report.learned = Learned { servo_lag, ..estimator.learned() };
            self.report.mu = self.report.learned.mu.value;
        }
    }

    /// The state at the time from which the next command acts, after those that are under way to the plate and in the queue.
    fn predicted(&mut self) -> Result<[f64; 10], PlateError> {
        let mut state = self.estimator.as_ref().map_or([0.0; 6], MotionEstimator::state);
        let mut plate = self.plate;
        let pending = self.pending();
        if !pending.is_empty() {
            let mut object = Replay::new(self.planner.problem().object(), self.report.mu)?;
            object.set_state(state)?;
            for (command, time) in pending {
                object.advance(&plate, command, time)?;
                plate = command.applied_to(&plate).after(time);
            }
            state = object.state();
        }
        let [x, y, phi, vx, vy, w] = state;
        Ok([x, y, phi, vx, vy, w, plate.displacement, plate.velocity, plate.tilt, plate.tilt_rate])
    }

    /// The command of a sample of a move.
    fn follow(&mut self, mut ongoing: Box<Move>) -> Result<Command, PlateError> {
        if ongoing.half {
            return self.second_half(ongoing);
        }
        if let Some(mut rti) = ongoing.correction.take() {
            let state = self.predicted()?;
            let solved = matches!(
                rti.feedback(&state)?.status,
                StepStatus::Solved | StepStatus::Inaccurate | StepStatus::Infeasible
            );
            // Bounds are soft to the program, which a state far from all plans may leave no other way.
            if solved && rti.trajectory().is_finite() && self.settings.limits.keep(rti.trajectory()) {
                ongoing.trajectory = rti.trajectory().clone();
                let end = ongoing.trajectory.x(ongoing.trajectory.steps());
                let miss = std::array::from_fn(|i| end[i] - rti.ocp().targets[i].value);
                ongoing.late = if cost(&miss) > LATE { ongoing.late + 1 } else { 0 };
            } else {
                self.report.unsolved += 1;
            }
        }
        ongoing.half = true;
        let command = command_of(&ongoing.trajectory);
        self.phase = Phase::Move(ongoing);
        Ok(command)
    }

    /// The command of the second sample of an interval, and the program for the next interval.
    fn second_half(&mut self, mut ongoing: Box<Move>) -> Result<Command, PlateError> {
        if ongoing.trajectory.steps() == 1 || is_over(&ongoing.trajectory) {
            self.phase = Phase::Look { samples: 0 };
            return Ok(self.braking(1.0));
        }
        let command = command_of(&ongoing.trajectory);
        let extend = ongoing.late >= 2 && ongoing.extended < MOST_EXTENSION;
        ongoing.trajectory = rest_of(&ongoing.trajectory, if extend { EXTENSION } else { 0 })?;
        if extend {
            ongoing.extended += EXTENSION;
            ongoing.late = 0;
            if let Some(report) = self.report.moves.last_mut() {
                report.extended = ongoing.extended * INTERVAL;
            }
        }
        if ongoing.trajectory.steps() > PLAYED_OUT {
            self.queue.push_back(command);
            let state = self.predicted();
            self.queue.pop_back();
            let (mu, limit) = (self.report.mu, self.settings.time_limit);
            if let Some(estimator) = &self.estimator {
                self.planner.problem_mut().set_object(&estimator.object().0)?;
            }
            let (miss, correction) = self.planner.correction(&state?, self.aim, mu, &ongoing.trajectory, limit)?;
            ongoing.correction = correction;
            let far = miss.iter().zip(FAR).any(|(e, far)| !e.is_finite() || e.abs() > far);
            ongoing.lost = if far { ongoing.lost + 1 } else { 0 };
            if ongoing.lost >= LOST << self.broken_off.min(5) {
                self.broken_off += 1;
                self.phase = Phase::Halt;
                return Ok(command);
            }
        }
        ongoing.half = false;
        self.phase = Phase::Move(ongoing);
        Ok(command)
    }

    fn decide(&mut self, measured: &[f64; 3]) -> Result<Command, PlateError> {
        if let Phase::Start = self.phase {
            if self.is_measured_away(*measured, 1) {
                self.plan(0)?;
            } else {
                self.phase = Phase::Look { samples: 0 };
            }
        }
        if let (&Phase::Hold { seen, sum }, PoseStatus::Arrived) = (&self.phase, self.report.status) {
            self.watch(measured, seen, sum)?;
        }
        if let Phase::Look { samples } = self.phase {
            let gentle = |c: &Command| c.displacement_acceleration.abs() < GENTLE && c.tilt_acceleration.abs() < GENTLE;
            let resting =
                self.estimator.as_ref().is_some_and(MotionEstimator::at_rest) && self.queue.iter().all(gentle);
            if resting {
                self.look(samples)?;
            }
        }
        match std::mem::replace(&mut self.phase, HOLD) {
            Phase::Pause { plan, left: 0 } => {
                let trajectory = plan.trajectory;
                self.follow(Box::new(Move { trajectory, half: false, correction: None, extended: 0, late: 0, lost: 0 }))
            }
            Phase::Pause { plan, left } => {
                self.phase = Phase::Pause { plan, left: left - 1 };
                Ok(self.braking(BRAKING))
            }
            Phase::Move(ongoing) => self.follow(ongoing),
            Phase::Halt => {
                let y = self.estimator.as_ref().map_or(0.0, |e| e.state()[1]);
                if let Some(command) = leveling(&self.expected_plate(), y, &self.settings.limits, MARGIN) {
                    self.phase = Phase::Halt;
                    return Ok(command);
                }
                self.phase = Phase::Look { samples: 0 };
                Ok(self.braking(BRAKING))
            }
            phase => {
                self.phase = phase;
                Ok(self.braking(BRAKING))
            }
        }
    }
}

/// The problem of moves with an object.
fn move_problem(object: &Object, settings: &PoseSettings) -> Result<MoveProblem, PlateError> {
    MoveProblem::new(object, &settings.limits, settings.period * INTERVAL as f64, MARGIN)
}

impl PlateController for PoseController {
    fn period(&self) -> f64 {
        self.settings.period
    }

    fn command(&mut self, measurement: &Measurement) -> Result<Command, PlateError> {
        let clock = Instant::now();
        let seen = measurement.object.iter().all(|v| v.is_finite());
        self.report.lost += usize::from(!seen);
        let period = self.settings.period;
        if let Some(estimator) = &mut self.estimator {
            // What the plate really did since the last sample.
            let acted = Command {
                displacement_acceleration: (measurement.plate.velocity - self.plate.velocity) / period,
                tilt_acceleration: (measurement.plate.tilt_rate - self.plate.tilt_rate) / period,
            };
            estimator.step(&self.plate, acted, &measurement.object)?;
            self.servo.take(
                [&self.plate, &measurement.plate],
                [self.before, self.acted],
                period,
                &self.settings.limits,
            );
            self.tell();
        } else if seen {
            self.target[2] = nearest_turn(self.target[2], measurement.object[2]);
            let object = self.planner.problem().object();
            self.estimator = Some(MotionEstimator::new(object, &self.settings, measurement.object)?);
            self.tell();
        }
        self.plate = measurement.plate;
        let moving = matches!(self.phase, Phase::Move(_));
        let command = if self.estimator.is_some() { self.decide(&measurement.object)? } else { Command::default() };
        self.queue.push_back(command);
        self.before = self.acted;
        self.acted = self.queue.pop_front().unwrap_or(command);
        if moving {
            self.report.sample_seconds.push(clock.elapsed().as_secs_f64());
        }
        Ok(command)
    }

    fn finished(&self) -> bool {
        matches!(self.phase, Phase::Hold { .. })
    }
}
