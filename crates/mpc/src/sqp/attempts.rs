//! Ways from a guess to the solution of a smooth problem: the interior-point method from several first barriers, and the filter method.

use super::filter::WIDEST;
use super::interior_point::{BARRIERS, InteriorPoint, InteriorSolution};
use super::settings::Hessian;
use super::solution::{Iteration, Solution, SolveStatus};
use super::solver::{Sqp, Stop};
use crate::error::MpcError;
use crate::qp::{NonlinearProgram, QpStatus};
use crate::trajectory::PlannedTrajectory;

/// Steps of the interior-point method beyond which another way from the guess may lead to a better solution.
const LONG: usize = 50;

/// Tolerances that it is asked for; the programs after it go on.
const FINEST: f64 = 1e-9;
const COARSEST: f64 = 1e-6;

/// The share of the tolerance where no program follows.
const UNCONFIRMED: f64 = 0.1;

/// Most programs that confirm a solution of it.
const CONFIRMING: usize = 3;

/// Programs from the shifted solution of the last sample after which the interior-point method takes over, where it takes the problem.
const FOLLOWING: usize = 15;

/// Programs of a cold start beyond which its guess counts as far from any solution: another way from it may lead to a better one.
const FAR: usize = 30;

/// Where an attempt starts.
#[derive(Clone, Copy, PartialEq)]
enum Start {
    /// At what the interior-point method finds from the guess, with this first barrier.
    Interior(f64),
    /// At the guess, and within narrower limits.
    Guess,
    Narrow,
}

/// How an attempt of the filter method ended.
struct Attempt {
    number: usize,
    end: PlannedTrajectory,
    stop: Stop,
    merit: f64,
    exact: bool,
    /// Whether programs confirm it.
    confirmed: bool,
    residual: f64,
}

impl Attempt {
    fn is_better_than(&self, other: &Self) -> bool {
        let converged = [self, other].map(|a| a.stop == Stop::Converged);
        if converged[0] == converged[1] { self.merit < other.merit } else { converged[0] }
    }
}

impl Sqp {
    /// Smooth dynamics. From a guess, the interior-point method leads; where it does not converge, or takes long, the filter method starts
    /// from the guess too, and the better trajectory counts. Programs confirm what the interior-point method finds, unless the first sample
    /// will. From the shifted solution of the last sample, the filter method leads while it converges quickly; once programs do
    /// not confirm what the interior-point method finds, that leads alone.
    pub(super) fn solve_smooth(
        &mut self,
        z: &mut PlannedTrajectory,
        warm: bool,
        log: &mut Vec<Iteration>,
    ) -> Result<SolveStatus, MpcError> {
        let guess = self.spare.copy(z);
        self.interior_point_steps = 0;
        let mut best: Option<Attempt> = None;
        let (mut last, mut led) = (0, false);
        let following = warm && self.prepare_interior_point();
        let [barrier, wide, small] = BARRIERS.map(Start::Interior);
        let leads = std::mem::take(&mut self.interior_leads) && following;
        let order = match (warm, leads) {
            (false, _) => [barrier, wide, small, Start::Guess, Start::Narrow],
            (true, false) => [Start::Guess, small, barrier, wide, Start::Narrow],
            (true, true) => [small, barrier, Start::Guess, wide, Start::Narrow],
        };
        // A solution of the interior-point method that is good for programs takes few of them.
        let following_programs = if std::mem::take(&mut self.unconfirmed) { CONFIRMING } else { FOLLOWING };
        for (number, start) in order.into_iter().enumerate() {
            let interior = matches!(start, Start::Interior(_));
            if !interior && led {
                // The filter method from the guess is for what the other does not solve.
                break;
            }
            let (mut end, before) = (self.spare.copy(&guess), log.len());
            if number > 0 {
                self.start_afresh()?;
            }
            let solution =
                if let Start::Interior(barrier) = start { self.interior_point(&guess, barrier)? } else { None };
            if let Some(solution) = &solution {
                end.clone_from(&solution.trajectory);
                if !self.is_exact() {
                    self.change_hessian()?;
                }
                self.qp.set_multipliers(&solution.multipliers, &solution.row_multipliers);
            } else if interior {
                continue;
            }
            let steps = solution.as_ref().map_or(0, |s| s.steps);
            self.interior_point_steps += steps;
            last = number;
            let widest = if start == Start::Narrow { WIDEST[1] } else { WIDEST[0] };
            let programs = match solution {
                Some(_) => CONFIRMING,
                None if following && start == Start::Guess => following_programs.min(self.settings.filter_iterations),
                None => self.settings.filter_iterations,
            };
            let confirmed = solution.is_none() || (self.confirming && !leads);
            let mut stop =
                if confirmed { self.filter_method(&mut end, 0.0, (widest, programs), log)? } else { Stop::Converged };
            // Programs that do not confirm it are less accurate than it is.
            self.interior_leads |= solution.is_some() && (leads || stop != Stop::Converged);
            let error = solution.as_ref().map(|s| s.error).filter(|_| !confirmed || stop != Stop::Converged);
            let residual = error.unwrap_or_else(|| self.qp.residual());
            if let Some(solution) = solution.filter(|_| stop != Stop::Converged) {
                self.qp.set_multipliers(&solution.multipliers, &solution.row_multipliers);
                (end, stop) = (solution.trajectory, Stop::Converged);
            }
            led |= interior && stop == Stop::Converged;
            let merit = self.problem.merit(&end, self.settings.qp.hard_weight);
            let weight = 1e2 * merit.objective.abs().max(1.0);
            let this =
                Attempt { number, end, stop, merit: merit.value(weight), exact: self.is_exact(), confirmed, residual };
            if best.as_ref().is_none_or(|best| this.is_better_than(best)) {
                best = Some(this);
            } else {
                self.spare.give(this.end);
            }
            let tried = steps <= LONG && log.len() - before <= FAR;
            // One other first barrier is enough.
            let near = stop == Stop::Converged && (warm || tried || (interior && number > 0));
            if near || matches!(stop, Stop::QpFailed(QpStatus::NotANumber | QpStatus::Limit)) {
                break;
            }
        }
        self.spare.give(guess);
        let Some(best) = best else { return Ok(SolveStatus::NotANumber) };
        if best.number < last {
            // The multipliers are those of the other attempt.
            self.qp.forget_multipliers();
        }
        self.unconfirmed = !best.confirmed && !leads;
        self.residual = best.residual;
        self.spare.replace(z, best.end);
        if best.exact != self.is_exact() {
            self.change_hessian()?;
        }
        Ok(self.status(best.stop))
    }

    /// As [`Sqp::solve`], for a controller whose first sample solves on from there: no program confirms what the interior-point method finds.
    pub(crate) fn solve_first(&mut self, x0: &[f64], guess: &PlannedTrajectory) -> Result<Solution, MpcError> {
        self.confirming = false;
        let solution = self.solve(x0, guess);
        self.confirming = true;
        solution
    }

    /// The interior-point method from a guess, where it takes the problem and converges.
    fn interior_point(
        &mut self,
        guess: &PlannedTrajectory,
        barrier: f64,
    ) -> Result<Option<InteriorSolution>, MpcError> {
        if !self.prepare_interior_point() {
            return Ok(None);
        }
        let share = if self.confirming { 1.0 } else { UNCONFIRMED };
        let tolerance = (share * self.settings.tolerance).clamp(FINEST, COARSEST);
        let Some(Some((program, field))) = &mut self.interior else { return Ok(None) };
        InteriorPoint::solve(&mut self.problem, program, field, guess, (barrier, tolerance, &self.settings.stop))
    }

    /// Whether the interior-point method is asked for and takes the problem, whose layout is made at the first call.
    pub(crate) fn prepare_interior_point(&mut self) -> bool {
        let asked = self.settings.interior_point && self.settings.hessian != Hessian::GaussNewton;
        // Smoothed friction is curved most where it is least true.
        if !asked || self.problem.dynamics.has_jumps() {
            return false;
        }
        let (problem, hard) = (&mut self.problem, self.settings.qp.hard_weight);
        let interior = self.interior.get_or_insert_with(|| {
            let program = NonlinearProgram::new(&problem.ocp, problem.shooter.closure(), hard)?;
            Some((program, problem.dynamics.second_derivatives().ok()?))
        });
        interior.is_some()
    }
}
