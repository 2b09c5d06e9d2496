//! The solver of a problem, from a guess to convergence.

use super::filter::WIDEST;
use super::settings::{Hessian, SqpSettings};
use super::solution::{Iteration, Solution, SolveStatus};
use super::trajectory_pool::TrajectoryPool;
use crate::controller::{SolverEffort, StepLimits};
use crate::dynamics::Dynamics;
use crate::error::{MpcError, check_flag, check_length, check_value};
use crate::ocp::{FINEST_ROUNDING, Ocp};
use crate::qp::{NonlinearProgram, Qp, QpStatus};
use crate::trajectory::PlannedTrajectory;
use crate::transcription::{Merit, ShootingLinearization, Transcription};
use std::time::Instant;

/// Widths of norms, as shares of their sizes, before the last one where the interior-point method does not apply, and most programs for each.
const ROUNDINGS: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];
const SHARPENING: usize = 30;

/// The solver: problem, dynamics and memory.
pub struct Sqp {
    pub(crate) problem: Transcription,
    pub(crate) settings: SqpSettings,
    pub(crate) qp: Qp,
    pub(crate) lin: ShootingLinearization,
    /// Places of the field's second derivatives while programs have the exact Hessian.
    field: Option<Vec<(usize, usize)>>,
    /// The programs with the other Hessian, where the choice is automatic.
    other: Other,
    /// The problem as the interior-point method sees it, once it was asked for.
    pub(super) interior: Option<Interior>,
    /// Steps of the interior-point method in this solution.
    pub(super) interior_point_steps: usize,
    /// Whether the last sample needed the interior-point method, and programs did not confirm it quickly.
    pub(super) interior_leads: bool,
    /// Residual of the conditions of optimality of the last solution.
    pub(super) residual: f64,
    /// Whether programs confirm what the interior-point method finds.
    pub(super) confirming: bool,
    /// Whether the last solution is one of the interior-point method that no program has confirmed.
    pub(super) unconfirmed: bool,
    pub(super) spare: TrajectoryPool,
}

/// The layout of the problem for the interior-point method, with the places of the field's second derivatives; none where it does not take
/// the problem.
pub(super) type Interior = Option<(NonlinearProgram, Vec<(usize, usize)>)>;

/// The programs that are not in use.
enum Other {
    /// Not made yet.
    Possible,
    /// As [`Sqp::qp`] and [`Sqp::field`].
    Made(Option<Vec<(usize, usize)>>, Box<Qp>),
    /// The settings or the dynamics rule them out.
    Impossible,
}

/// How an iteration ended.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Stop {
    Converged,
    Limit,
    Stalled,
    QpFailed(QpStatus),
}

impl Sqp {
    /// A solver for the problem.
    ///
    /// # Errors
    /// If the problem contradicts itself or the dynamics; [`MpcError::NoSecondDerivatives`] if the exact Hessian is asked of
    /// dynamics that do not have it.
    pub fn new(dynamics: Box<dyn Dynamics>, ocp: Ocp, settings: SqpSettings) -> Result<Self, MpcError> {
        // Where the interior-point method leads, cones are rows with exact curvature; the other programs keep them.
        let smooth = settings.interior_point && settings.hessian != Hessian::GaussNewton && !dynamics.has_jumps();
        let ocp = if smooth { ocp.with_norm_rows() } else { ocp };
        let mut problem = Transcription::new(dynamics, ocp)?;
        for &w in &settings.smoothing {
            check_value(w > 0.0 && w.is_finite(), "a smoothing width", w, "give a positive number")?;
        }
        let field = match settings.hessian {
            Hessian::Automatic | Hessian::GaussNewton => None,
            Hessian::Exact => Some(problem.dynamics.second_derivatives()?),
        };
        let automatic = settings.hessian == Hessian::Automatic && !problem.dynamics.has_jumps();
        let other = if automatic { Other::Possible } else { Other::Impossible };
        let (steps, closure) = (problem.ocp.steps, problem.shooter.closure());
        let qp = Qp::with_hessian(&problem.ocp, steps, closure, field.is_some(), settings.qp);
        Ok(Self {
            problem,
            settings,
            qp,
            lin: ShootingLinearization::default(),
            field,
            other,
            interior: None,
            interior_point_steps: 0,
            interior_leads: false,
            residual: 0.0,
            confirming: true,
            unconfirmed: false,
            spare: TrajectoryPool::default(),
        })
    }

    /// Changes from one Hessian to the other, where that is possible; multipliers are kept.
    pub(crate) fn change_hessian(&mut self) -> Result<bool, MpcError> {
        if matches!(self.other, Other::Possible) {
            self.other = match self.problem.dynamics.second_derivatives() {
                Ok(field) => {
                    let (steps, closure) = (self.problem.ocp.steps, self.problem.shooter.closure());
                    let qp = Qp::with_hessian(&self.problem.ocp, steps, closure, true, self.settings.qp);
                    Other::Made(Some(field), Box::new(qp))
                }
                Err(_) => Other::Impossible,
            };
        }
        let Other::Made(field, qp) = &mut self.other else { return Ok(false) };
        qp.take_over(&self.qp)?;
        std::mem::swap(field, &mut self.field);
        std::mem::swap(qp.as_mut(), &mut self.qp);
        Ok(true)
    }

    /// Whether programs have the exact Hessian.
    pub(crate) fn is_exact(&self) -> bool {
        self.field.is_some()
    }

    /// The problem.
    pub fn ocp(&self) -> &Ocp {
        &self.problem.ocp
    }

    /// Sets the grid point of the run at which the horizon starts (time and references follow it).
    pub fn set_start(&mut self, k0: usize) {
        self.problem.k0 = k0;
    }

    /// Limits the programs that follow on top of the settings.
    pub(crate) fn limit_programs(&mut self, limits: StepLimits) -> Result<(), MpcError> {
        let qp = &self.settings.qp;
        self.qp.set_limits(qp.max_iterations.min(limits.iterations), qp.time_limit.min(limits.time))
    }

    /// What has been solved since the last call, but for the interior-point steps that solutions state.
    pub(crate) fn take_effort(&mut self) -> SolverEffort {
        let mut effort = self.qp.take_effort();
        if let Other::Made(_, qp) = &mut self.other {
            effort += qp.take_effort();
        }
        effort
    }

    /// Residual of the conditions of optimality of the last solution, as [`Step::residual`](crate::controller::Step) has it.
    pub(crate) fn residual(&self) -> f64 {
        self.residual
    }

    /// Gives the live parameters of the dynamics these values at every grid point, for instance those of an estimator.
    ///
    /// # Errors
    /// If their number is not that of the live parameters.
    pub fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        self.problem.set_parameters(parameters)
    }

    /// Changes the problem; a change that contradicts it is undone.
    pub(crate) fn change(&mut self, change: impl FnOnce(&mut Ocp)) -> Result<(), MpcError> {
        self.interior = None;
        if self.problem.change(change)? {
            let (ocp, closure) = (&self.problem.ocp, self.problem.shooter.closure());
            self.qp = Qp::with_hessian(ocp, ocp.steps, closure, self.field.is_some(), self.settings.qp);
        }
        Ok(())
    }

    /// Inputs put to use from `x0`: a guess whose states obey the dynamics at the first smoothing width.
    ///
    /// # Errors
    /// If a length is wrong.
    pub fn guess(&mut self, x0: &[f64], inputs: &[Vec<f64>]) -> Result<PlannedTrajectory, MpcError> {
        let n = self.problem.ocp.states();
        check_length("the initial state", x0.len(), n)?;
        check_length("the list of inputs", inputs.len(), self.problem.ocp.steps)?;
        let mut g = PlannedTrajectory::from_rows(&vec![x0.to_vec(); inputs.len() + 1], inputs)?;
        self.problem.check_trajectory(&g)?;
        if let Some(&w) = self.settings.smoothing.first() {
            self.problem.dynamics.set_smoothing(w);
        }
        self.problem.choose_substeps(&g);
        self.problem.roll_out(&mut g);
        Ok(g)
    }

    /// Solves from a guess, whose first state is replaced by `x0` and whose inputs are brought into their bounds.
    ///
    /// # Errors
    /// If a length is wrong; everything else is a status.
    pub fn solve(&mut self, x0: &[f64], guess: &PlannedTrajectory) -> Result<Solution, MpcError> {
        self.start_afresh()?;
        self.solve_from(x0, guess, false)
    }

    /// As [`Sqp::solve`], for the sample after the last one: with its multipliers, one interval later, and its Hessian.
    pub(crate) fn solve_next(&mut self, x0: &[f64], guess: &PlannedTrajectory) -> Result<Solution, MpcError> {
        self.solve_from(x0, guess, true)
    }

    /// Uses the memory of a solution for the next ones.
    pub(crate) fn recycle(&mut self, solution: Solution) {
        self.spare.give_solution(solution);
    }

    fn solve_from(&mut self, x0: &[f64], guess: &PlannedTrajectory, warm: bool) -> Result<Solution, MpcError> {
        let start = Instant::now();
        check_length("the initial state", x0.len(), self.problem.ocp.states())?;
        self.problem.check_trajectory(guess)?;
        let mut z = self.spare.copy(guess);
        z.x_mut(0).copy_from_slice(x0);
        z.clamp_inputs(&self.problem.ocp.input_bounds);
        self.problem.ocp.start_as_decided(&mut z);
        let mut log = self.spare.log();
        let mut widths = if self.problem.dynamics.is_smoothed() { self.settings.smoothing.clone() } else { Vec::new() };
        let mut wide_steps = 0;
        let mut kinks = None;
        if !self.problem.dynamics.has_jumps() && self.settings.filter_iterations > 0 {
            // Kinks are smooth functions that get sharper.
            if let Some(last) = widths.pop().filter(|_| z.is_finite()) {
                let wider = std::mem::take(&mut widths);
                wide_steps = if warm { 0 } else { self.sharpen_kinks(&mut z, &wider, last, &mut log)? };
                self.problem.dynamics.set_smoothing(last);
                kinks = warm.then(|| (wider, last, self.spare.copy(&z)));
            }
            widths.clear();
        }
        let mut lambda = self.settings.proximal;
        let mut status = SolveStatus::NotANumber;
        if z.is_finite() && widths.is_empty() && self.settings.filter_iterations > 0 {
            if !warm && self.problem.ocp.has_norms() && !self.prepare_interior_point() {
                self.sharpen_norms(&mut z, &mut log)?;
            }
            status = self.solve_smooth(&mut z, warm, &mut log)?;
            self.interior_point_steps += wide_steps;
            if let Some((wider, last, before)) = kinks {
                status = self.beyond_kinks(&mut z, status, (&wider, last), before, &mut log)?;
            }
        } else if z.is_finite() {
            self.qp.forget_multipliers();
            let last = widths.len().saturating_sub(1);
            for i in 0..=last {
                if let Some(&w) = widths.get(i) {
                    self.problem.dynamics.set_smoothing(w);
                }
                let width = widths.get(i).copied().unwrap_or(0.0);
                if i > 0 {
                    lambda = lambda.max(1e-2 * self.settings.proximal);
                }
                let stop = self.iterate(&mut z, width, i == last, &mut lambda, &mut log)?;
                self.residual = self.qp.residual();
                status = self.status(stop);
                if matches!(status, SolveStatus::NotANumber | SolveStatus::IntegratorFailed) {
                    break;
                }
            }
        }
        let unsolved = matches!(status, SolveStatus::IterationLimit | SolveStatus::Stalled);
        if let Some(&width) = widths.last().filter(|_| unsolved)
            && self.filter_method(&mut z, width, (WIDEST[0], self.settings.filter_iterations), &mut log)?
                == Stop::Converged
        {
            status = SolveStatus::Converged;
        }
        let violation = self.problem.ocp.hard_violation(self.problem.k0, &z);
        if status == SolveStatus::Converged && violation > 1e-5 {
            status = SolveStatus::Infeasible { violation };
        }
        let merit = self.problem.merit(&z, self.settings.qp.hard_weight);
        let ocp = &mut self.problem.ocp;
        let mut miss = self.spare.miss();
        miss.extend(ocp.targets.iter().map(|t| z.x(z.steps())[t.state] - t.value));
        // What is reported has exact norms.
        ocp.round_norms(0.0);
        let cost = ocp.cost(self.problem.k0, &z);
        ocp.round_norms(FINEST_ROUNDING);
        Ok(Solution {
            trajectory: z,
            status,
            cost,
            defect: merit.worst_defect,
            miss,
            hessian: if self.is_exact() { Hessian::Exact } else { Hessian::GaussNewton },
            interior_point_steps: self.interior_point_steps,
            iterations: log,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// Goes from the guess to a solution by norms that get sharper, as the interior-point method does by itself.
    fn sharpen_norms(&mut self, z: &mut PlannedTrajectory, log: &mut Vec<Iteration>) -> Result<(), MpcError> {
        for share in ROUNDINGS {
            let before = self.spare.copy(z);
            self.problem.ocp.round_norms(share);
            let stop = self.filter_method(z, 0.0, (WIDEST[0], SHARPENING), log)?;
            if matches!(stop, Stop::QpFailed(_)) || !z.is_finite() {
                self.spare.replace(z, before);
            } else {
                self.spare.give(before);
            }
        }
        self.problem.ocp.round_norms(FINEST_ROUNDING);
        Ok(())
    }

    /// Forgets multipliers, and the Hessian where the choice is automatic.
    pub(super) fn start_afresh(&mut self) -> Result<(), MpcError> {
        self.qp.forget_multipliers();
        if self.is_exact() {
            self.change_hessian()?;
        }
        Ok(())
    }

    pub(super) fn status(&mut self, stop: Stop) -> SolveStatus {
        match stop {
            Stop::QpFailed(QpStatus::NotANumber) if self.problem.shooter.take_failure() => {
                SolveStatus::IntegratorFailed
            }
            Stop::QpFailed(QpStatus::NotANumber) => SolveStatus::NotANumber,
            Stop::QpFailed(s) => SolveStatus::QpFailed(s),
            Stop::Converged => SolveStatus::Converged,
            Stop::Limit => SolveStatus::IterationLimit,
            Stop::Stalled => SolveStatus::Stalled,
        }
    }

    /// Moves a trajectory on by one interval: the last input is held for one more.
    pub(crate) fn shift(&mut self, trajectory: &mut PlannedTrajectory) {
        self.problem.ocp.move_on(trajectory);
        self.qp.shift_multipliers();
        self.problem.extend_last(trajectory);
    }

    /// Fills the program in at a trajectory that has been linearized, the exact Hessian with the multipliers of the last program.
    pub(crate) fn assemble(&mut self, z: &PlannedTrajectory, proximal: f64) {
        if let Some(field) = &self.field {
            self.problem.curvatures(z, &self.qp.solution.multipliers, field, &mut self.lin);
        }
        self.qp.assemble(&mut self.problem.ocp, self.problem.k0, z, &self.lin, proximal);
    }

    /// The line of the log for a program that has just been solved, before anything is known of its step.
    pub(crate) fn line(&self, width: f64, now: &Merit, proximal: f64, qp: QpStatus) -> Iteration {
        Iteration {
            smoothing: width,
            objective: now.objective,
            defect: now.worst_defect,
            predicted: 0.0,
            ratio: 0.0,
            proximal,
            fraction: 0.0,
            correction: false,
            qp,
            qp_iterations: self.qp.solution.iterations,
        }
    }

    fn iterate(
        &mut self,
        z: &mut PlannedTrajectory,
        width: f64,
        last: bool,
        lambda: &mut f64,
        log: &mut Vec<Iteration>,
    ) -> Result<Stop, MpcError> {
        let s = self.settings.clone();
        let steps = z.steps();
        self.problem.choose_substeps(z);
        self.problem.linearize(z, 0, steps, &mut self.lin);
        let (limit, tolerance, defect_tolerance) = if last {
            (s.max_iterations, s.tolerance, s.defect_tolerance)
        } else {
            (s.continuation_iterations, s.continuation_tolerance, s.defect_tolerance.max(1e-2))
        };
        let mut weight = 0.0_f64;
        let mut failures = 0;
        for _ in 0..limit {
            check_flag(&s.stop)?;
            let proximal = if *lambda < s.min_proximal { 0.0 } else { *lambda };
            self.assemble(z, proximal);
            let now = self.problem.merit_with(z, &self.lin.end, s.qp.hard_weight);
            let qp = self.qp.solve()?;
            let mut line = self.line(width, &now, proximal, qp);
            if !qp.is_usable() {
                log.push(line);
                if qp == QpStatus::NotANumber || failures > 8 {
                    return Ok(Stop::QpFailed(qp));
                }
                failures += 1;
                *lambda = (*lambda * 5.0).max(s.min_proximal * 5.0);
                continue;
            }
            weight = self.problem.penalty_weight(&self.qp.solution.multipliers).max(0.8 * weight);
            let before = now.value(weight);
            let (trial, after) = self.trial(z, 1.0);
            let predicted = before - after.objective;
            let fall = before - after.value(weight);
            line.predicted = predicted;
            line.ratio = fall / predicted.max(f64::MIN_POSITIVE);
            let taken = fall.is_finite() && line.ratio > 0.05;
            line.fraction = f64::from(u8::from(taken));
            log.push(line);
            let near = predicted <= tolerance * now.objective.abs().max(1e-12);
            if near && now.worst_defect <= defect_tolerance {
                // The last step is still worth taking when it helps.
                if fall > 0.0 {
                    *z = trial;
                }
                return Ok(Stop::Converged);
            }
            if taken {
                *z = trial;
                self.problem.linearize(z, 0, steps, &mut self.lin);
                if line.ratio > 0.7 {
                    *lambda = (*lambda / 5.0).max(s.min_proximal / 5.0);
                } else if line.ratio < 0.25 {
                    *lambda *= 2.0;
                }
                failures = 0;
            } else {
                failures += 1;
                *lambda = (*lambda * 5.0).max(s.min_proximal * 5.0);
                if failures > 10 {
                    return Ok(Stop::Stalled);
                }
            }
        }
        Ok(Stop::Limit)
    }
}
