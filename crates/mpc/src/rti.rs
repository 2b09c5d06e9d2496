//! Real-time iteration: one quadratic program per sample.
//!
//! Preparation, before the measurement: linearise along the shifted trajectory and fill the program. Feedback, after it:
//! linearise the first interval at the measured state, solve, apply the first input.

use crate::dynamics::Dynamics;
use crate::error::{MpcError, check_length};
use crate::ocp::Ocp;
use crate::qp::{Qp, QpSettings, QpStatus};
use crate::shooting::Linearisation;
use crate::trajectory::Trajectory;
use crate::transcription::Transcription;
use std::time::Instant;

/// Violation of a hard bound, in units of its state's scale, above which a sample counts as infeasible. A trajectory that
/// is linearised once per sample misses its bounds by a little.
const HARD_TOLERANCE: f64 = 1e-3;

/// What happens to the horizon from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Horizon {
    /// It keeps its length and moves on.
    Receding,
    /// Its end stays where it is; after it, the inputs are those of [`RtiSettings::rest_input`]. With fewer than `min_steps`
    /// intervals left the last trajectory is played out.
    Shrinking {
        /// Fewest intervals for which a program is solved.
        min_steps: usize,
    },
}

/// Settings of [`Rti`].
#[derive(Clone, Debug, PartialEq)]
pub struct RtiSettings {
    /// Receding or shrinking horizon.
    pub horizon: Horizon,
    /// Smoothing width of switching functions; `None` keeps what the dynamics have.
    pub smoothing: Option<f64>,
    /// Weight λ of the proximal term; 0 is the plain real-time iteration.
    pub proximal: f64,
    /// Whether a step that does not lower the merit is shortened (to 1/2, 1/4, 1/10) or left out.
    pub guarded: bool,
    /// Input after the end of a shrinking horizon, and when everything planned has been used up; zero when empty.
    pub rest_input: Vec<f64>,
    /// Settings of the quadratic programs.
    pub qp: QpSettings,
}

impl Default for RtiSettings {
    fn default() -> Self {
        Self {
            horizon: Horizon::Receding,
            smoothing: None,
            proximal: 0.0,
            guarded: false,
            rest_input: Vec::new(),
            qp: QpSettings::default(),
        }
    }
}

/// Why the planned input was used in place of a new one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FallbackReason {
    /// The measurement has an entry that is not finite.
    Measurement,
    /// The linearisation has an entry that is not finite.
    Linearisation,
    /// The quadratic program was not solved.
    Qp(QpStatus),
}

/// Outcome of one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepStatus {
    /// A new input from a program solved to full accuracy.
    Solved,
    /// A new input from a program solved to reduced accuracy.
    Inaccurate,
    /// A new input, but a hard bound cannot be kept: the violation is as small as it can be.
    Infeasible,
    /// The shrinking horizon is (nearly) used up: the plan is played out.
    PlayedOut,
    /// The planned input, or the input of rest when the plan is used up.
    Fallback(FallbackReason),
}

/// Where the time of one sample went, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timings {
    /// Linearisation and filling of the program (preparation).
    pub linearise: f64,
    /// Quadratic program.
    pub qp: f64,
    /// Everything else of the feedback.
    pub rest: f64,
}

impl Timings {
    /// The whole sample.
    pub fn total(&self) -> f64 {
        self.linearise + self.qp + self.rest
    }
}

/// One sample's input.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Input to apply over the next interval.
    pub u: Vec<f64>,
    /// Where it comes from.
    pub status: StepStatus,
    /// Times taken.
    pub timings: Timings,
}

/// The controller.
pub struct Rti {
    problem: Transcription,
    settings: RtiSettings,
    qp: Qp,
    lin: Linearisation,
    trajectory: Trajectory,
    prepared: bool,
    linearise_seconds: f64,
    /// Intervals of the trajectory that have been planned and not yet used, when programs fail.
    planned: usize,
}

impl Rti {
    /// A controller that starts from `trajectory` (a plan, or [`Trajectory::constant`]).
    ///
    /// # Errors
    /// If the problem contradicts itself, the dynamics or the trajectory.
    pub fn new(
        dynamics: Box<dyn Dynamics>,
        ocp: Ocp,
        trajectory: Trajectory,
        settings: RtiSettings,
    ) -> Result<Self, MpcError> {
        let mut problem = Transcription::new(dynamics, ocp)?;
        problem.check_trajectory(&trajectory)?;
        let mut settings = settings;
        if settings.rest_input.is_empty() {
            settings.rest_input = vec![0.0; problem.ocp.inputs()];
        }
        check_length("the input of rest", settings.rest_input.len(), problem.ocp.inputs())?;
        if let Some(w) = settings.smoothing {
            problem.dynamics.set_smoothing(w);
        }
        problem.choose_substeps(&trajectory);
        let qp = Qp::new(&problem.ocp, trajectory.steps(), problem.shooter.closure(), settings.qp);
        Ok(Self {
            problem,
            settings,
            qp,
            lin: Linearisation::default(),
            planned: trajectory.steps(),
            trajectory,
            prepared: false,
            linearise_seconds: 0.0,
        })
    }

    /// The trajectory that the next input comes from.
    pub fn trajectory(&self) -> &Trajectory {
        &self.trajectory
    }

    /// The problem.
    pub fn ocp(&self) -> &Ocp {
        &self.problem.ocp
    }

    /// Grid point of the run at which the horizon starts.
    pub fn start(&self) -> usize {
        self.problem.k0
    }

    /// Number of integration steps per interval in use.
    pub fn substeps(&self) -> usize {
        self.problem.substeps
    }

    fn used_up(&self) -> bool {
        match self.settings.horizon {
            Horizon::Receding => false,
            Horizon::Shrinking { min_steps } => self.trajectory.steps() < min_steps.max(1),
        }
    }

    /// Everything that does not need the measurement. Called by [`Rti::feedback`] when it has not been before.
    pub fn prepare(&mut self) {
        if self.prepared || self.used_up() {
            return;
        }
        let start = Instant::now();
        let steps = self.trajectory.steps();
        if self.qp.steps() != steps {
            self.qp = Qp::new(&self.problem.ocp, steps, self.problem.shooter.closure(), self.settings.qp);
        }
        self.problem.linearise(&self.trajectory, 0, steps, &mut self.lin);
        let (k0, lambda) = (self.problem.k0, self.settings.proximal);
        self.qp.assemble(&mut self.problem.ocp, k0, &self.trajectory, &self.lin, lambda);
        self.linearise_seconds = start.elapsed().as_secs_f64();
        self.prepared = true;
    }

    /// The input for the measured state `x`. Does not move the horizon: [`Rti::shift`] does.
    ///
    /// # Errors
    /// If `x` has the wrong length.
    pub fn feedback(&mut self, x: &[f64]) -> Result<Step, MpcError> {
        check_length("the measured state", x.len(), self.problem.ocp.states())?;
        if self.used_up() {
            return Ok(Step { u: self.planned_input(), status: StepStatus::PlayedOut, timings: Timings::default() });
        }
        self.prepare();
        self.prepared = false;
        let start = Instant::now();
        let (status, qp_seconds) = if x.iter().all(|v| v.is_finite()) {
            self.solve_from(x)?
        } else {
            (StepStatus::Fallback(FallbackReason::Measurement), 0.0)
        };
        let u = if let StepStatus::Fallback(_) = status {
            self.planned_input()
        } else {
            self.planned = self.trajectory.steps();
            self.trajectory.u(0).to_vec()
        };
        let rest = start.elapsed().as_secs_f64() - qp_seconds;
        Ok(Step { u, status, timings: Timings { linearise: self.linearise_seconds, qp: qp_seconds, rest } })
    }

    fn planned_input(&self) -> Vec<f64> {
        let left = self.planned > 0 && self.trajectory.steps() > 0;
        if left { self.trajectory.u(0).to_vec() } else { self.settings.rest_input.clone() }
    }

    fn solve_from(&mut self, x: &[f64]) -> Result<(StepStatus, f64), MpcError> {
        let mut z = self.trajectory.clone();
        z.x_mut(0).copy_from_slice(x);
        self.problem.linearise(&z, 0, 1, &mut self.lin);
        self.qp.update_first_interval(&mut self.problem.ocp, self.problem.k0, &z, &self.lin);
        let start = Instant::now();
        let status = self.qp.solve()?;
        let seconds = start.elapsed().as_secs_f64();
        let outcome = match status {
            QpStatus::Solved => StepStatus::Solved,
            QpStatus::Inaccurate => StepStatus::Inaccurate,
            QpStatus::NotANumber => return Ok((StepStatus::Fallback(FallbackReason::Linearisation), seconds)),
            s => return Ok((StepStatus::Fallback(FallbackReason::Qp(s)), seconds)),
        };
        let (dx, du) = (&self.qp.solution.dx, &self.qp.solution.du);
        let step = |alpha: f64, bounds: &[(f64, f64)]| {
            let mut t = z.moved(alpha, dx, du);
            t.clamp_inputs(bounds);
            t
        };
        if !self.settings.guarded {
            self.trajectory = step(1.0, &self.problem.ocp.input_bounds);
            return Ok((self.judged(outcome), seconds));
        }
        let hard = self.settings.qp.hard_weight;
        let weight = self.problem.penalty_weight(&self.qp.solution.multipliers);
        let before = self.problem.merit_with(&z, &self.lin.end, hard).value(weight);
        let mut chosen = None;
        for alpha in [1.0, 0.5, 0.25, 0.1] {
            let trial = step(alpha, &self.problem.ocp.input_bounds);
            if self.problem.merit(&trial, hard).value(weight) < before {
                chosen = Some(trial);
                break;
            }
        }
        self.trajectory = chosen.unwrap_or(z);
        Ok((self.judged(outcome), seconds))
    }

    /// The outcome of a solved program whose trajectory may still break a hard bound.
    fn judged(&mut self, outcome: StepStatus) -> StepStatus {
        if self.problem.ocp.hard_violation(self.problem.k0, &self.trajectory) > HARD_TOLERANCE {
            StepStatus::Infeasible
        } else {
            outcome
        }
    }

    /// Moves the horizon by one interval.
    pub fn shift(&mut self) {
        self.prepared = false;
        self.planned = self.planned.saturating_sub(1);
        if self.trajectory.steps() == 0 {
            return;
        }
        match self.settings.horizon {
            Horizon::Shrinking { .. } => {
                self.trajectory.drop_first();
                self.problem.ocp.steps = self.trajectory.steps();
                self.problem.k0 += 1;
            }
            Horizon::Receding => {
                self.trajectory.shift();
                self.problem.k0 += 1;
                self.problem.extend_last(&mut self.trajectory);
            }
        }
    }
}
