//! Controller and plant together.

use crate::dynamics::Dynamics;
use crate::error::{MpcError, PlantError, check_length};
use crate::ocp::Ocp;
use crate::rti::{FallbackReason, Rti, Step, StepStatus, Timings};
use crate::shooting::Shooter;
use crate::sqp::{SolveStatus, Sqp};
use crate::trajectory::Trajectory;

/// The thing that is controlled.
pub trait Plant {
    /// Advances the state `x` from time `t` by `dt` under constant inputs `u`.
    ///
    /// # Errors
    /// Whatever stops the plant.
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError>;
}

/// A plant with the dynamics of a model, integrated by the classical Runge–Kutta method.
pub struct RungeKuttaPlant {
    dynamics: Box<dyn Dynamics>,
    shooter: Shooter,
    substeps: usize,
}

impl RungeKuttaPlant {
    /// A plant with `substeps` integration steps per call.
    pub fn new(dynamics: Box<dyn Dynamics>, substeps: usize) -> Self {
        Self { shooter: Shooter::new(dynamics.as_ref()), dynamics, substeps: substeps.max(1) }
    }
}

impl Plant for RungeKuttaPlant {
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError> {
        self.shooter.advance(self.dynamics.as_mut(), t, x, u, dt, self.substeps);
        Ok(())
    }
}

/// Something that answers a measured state with an input, sample by sample.
pub trait Controller {
    /// The input for the next interval.
    ///
    /// # Errors
    /// Only for misuse; trouble while solving is a status.
    fn step(&mut self, x: &[f64]) -> Result<Step, MpcError>;
    /// The problem that the controller solves.
    fn ocp(&self) -> &Ocp;
}

impl Controller for Rti {
    fn step(&mut self, x: &[f64]) -> Result<Step, MpcError> {
        let step = self.feedback(x)?;
        self.shift();
        Ok(step)
    }
    fn ocp(&self) -> &Ocp {
        Rti::ocp(self)
    }
}

/// Solves every sample to convergence, from the shifted solution of the last.
pub struct SqpController {
    sqp: Sqp,
    trajectory: Trajectory,
    k: usize,
    planned: usize,
}

impl SqpController {
    /// A controller that starts from the guess.
    pub fn new(sqp: Sqp, guess: Trajectory) -> Self {
        Self { sqp, planned: guess.steps(), trajectory: guess, k: 0 }
    }
}

impl Controller for SqpController {
    fn step(&mut self, x: &[f64]) -> Result<Step, MpcError> {
        self.sqp.set_start(self.k);
        let solution = self.sqp.solve(x, &self.trajectory)?;
        let status = match solution.status {
            SolveStatus::Converged => StepStatus::Solved,
            SolveStatus::Infeasible { .. } => StepStatus::Infeasible,
            SolveStatus::IterationLimit | SolveStatus::Stalled => StepStatus::Inaccurate,
            SolveStatus::QpFailed(s) => StepStatus::Fallback(FallbackReason::Qp(s)),
            SolveStatus::NotANumber => StepStatus::Fallback(FallbackReason::Measurement),
        };
        if matches!(status, StepStatus::Fallback(_)) {
            self.planned = self.planned.saturating_sub(1);
        } else {
            self.trajectory = solution.trajectory;
            self.planned = self.trajectory.steps();
        }
        let u = if self.planned > 0 { self.trajectory.u(0).to_vec() } else { vec![0.0; self.trajectory.inputs()] };
        self.k += 1;
        self.sqp.set_start(self.k);
        self.trajectory = self.sqp.shifted(&self.trajectory);
        Ok(Step { u, status, timings: Timings { qp: solution.seconds, ..Timings::default() } })
    }
    fn ocp(&self) -> &Ocp {
        self.sqp.ocp()
    }
}

/// How often each status occurred.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Inputs from programs solved to full accuracy.
    pub solved: usize,
    /// Inputs from less accurate solutions.
    pub inaccurate: usize,
    /// Inputs from programs in which a hard bound cannot be kept.
    pub infeasible: usize,
    /// Inputs planned earlier.
    pub fallback: usize,
    /// Samples after the end of a plan, for which nothing is solved.
    pub played_out: usize,
}

/// Times of the samples, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct SolveTimes {
    /// Half of the samples take less.
    pub median: f64,
    /// 99 % of the samples take less.
    pub p99: f64,
    /// Longest.
    pub max: f64,
}

impl SolveTimes {
    /// Order statistics of times in seconds; zeros for none.
    pub fn of(seconds: &[f64]) -> Self {
        let mut sorted = seconds.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |q: f64| {
            let i = (q * sorted.len() as f64).ceil() as usize;
            1e3 * sorted.get(i.saturating_sub(1).min(sorted.len().saturating_sub(1))).copied().unwrap_or(0.0)
        };
        Self { median: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}

/// A closed-loop run.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// Sampled times, s; one more than inputs.
    pub t: Vec<f64>,
    /// States at these times.
    pub x: Vec<Vec<f64>>,
    /// Inputs applied from each time on.
    pub u: Vec<Vec<f64>>,
    /// Outcome of each sample.
    pub steps: Vec<Step>,
    /// Σ dt·stage cost at the sampled states with the applied inputs.
    pub cost: f64,
    /// Counted outcomes.
    pub counts: Counts,
    /// Times per sample.
    pub times: SolveTimes,
}

/// Runs `controller` on `plant` from `x0` for a number of samples. `disturb` may change the measured state of sample k
/// (noise, dropouts).
///
/// # Errors
/// If a length is wrong or the plant stops ([`MpcError::Plant`]).
pub fn run_closed_loop(
    controller: &mut dyn Controller,
    plant: &mut dyn Plant,
    x0: &[f64],
    samples: usize,
    mut disturb: impl FnMut(usize, &mut [f64]),
) -> Result<ClosedLoop, MpcError> {
    let mut ocp = controller.ocp().clone();
    check_length("the initial state", x0.len(), ocp.states())?;
    let dt = ocp.dt;
    let mut run = ClosedLoop {
        t: vec![0.0],
        x: vec![x0.to_vec()],
        u: Vec::new(),
        steps: Vec::new(),
        cost: 0.0,
        counts: Counts::default(),
        times: SolveTimes::default(),
    };
    let mut x = x0.to_vec();
    for k in 0..samples {
        let t = k as f64 * dt;
        let mut measured = x.clone();
        disturb(k, &mut measured);
        let step = controller.step(&measured)?;
        run.cost += dt * ocp.stage_cost(k, t, &x, &step.u);
        let counter = match step.status {
            StepStatus::Solved => &mut run.counts.solved,
            StepStatus::PlayedOut => &mut run.counts.played_out,
            StepStatus::Inaccurate => &mut run.counts.inaccurate,
            StepStatus::Infeasible => &mut run.counts.infeasible,
            StepStatus::Fallback(_) => &mut run.counts.fallback,
        };
        *counter += 1;
        plant.step(t, &mut x, &step.u, dt).map_err(|source| MpcError::Plant { time: t, source })?;
        run.t.push((k + 1) as f64 * dt);
        run.x.push(x.clone());
        run.u.push(step.u.clone());
        run.steps.push(step);
    }
    let solved: Vec<f64> =
        run.steps.iter().filter(|s| s.status != StepStatus::PlayedOut).map(|s| s.timings.total()).collect();
    run.times = SolveTimes::of(&solved);
    Ok(run)
}
