//! Dynamics with kinks, as of limits written with `min` and `max`: smooth functions that get sharper.

use super::solution::{Iteration, SolveStatus};
use super::solver::Sqp;
use crate::error::MpcError;
use crate::trajectory::PlannedTrajectory;

/// Widths of kinks before the last one, in units of it, where the settings give no others.
const WIDER: [f64; 2] = [100.0, 10.0];
/// Share of its cost by which a solution is worse than the trajectory that it starts from.
const WORSE: f64 = 1e-3;
/// Change of an input that may lead across a kink, in units of its size.
const FAR: f64 = 0.1;

impl Sqp {
    /// Goes from the guess to a solution by kinks that get sharper: at the widths given, or without any at [`WIDER`] ones than the `last`. The
    /// steps of the interior-point method.
    pub(super) fn sharpen_kinks(
        &mut self,
        z: &mut PlannedTrajectory,
        widths: &[f64],
        last: f64,
        log: &mut Vec<Iteration>,
    ) -> Result<usize, MpcError> {
        let wider = WIDER.map(|factor| factor * last);
        let mut steps = 0;
        for &width in if widths.is_empty() { &wider[..] } else { widths } {
            let mut trial = self.spare.copy(z);
            self.problem.dynamics.set_smoothing(width);
            let status = self.solve_smooth(&mut trial, false, log)?;
            steps += self.interior_point_steps;
            if status == SolveStatus::Converged && trial.is_finite() {
                self.spare.replace(z, trial);
            } else {
                self.spare.give(trial);
            }
            self.start_afresh()?;
        }
        Ok(steps)
    }

    /// After a solution from the trajectory `before`: where it costs more than that, programs went across a kink beyond which nothing leads
    /// back, as where an actuator saturates. The best one of it, a solution by kinks that get sharper, and where both started.
    pub(super) fn beyond_kinks(
        &mut self,
        z: &mut PlannedTrajectory,
        status: SolveStatus,
        (widths, last): (&[f64], f64),
        before: PlannedTrajectory,
        log: &mut Vec<Iteration>,
    ) -> Result<SolveStatus, MpcError> {
        let hard = self.settings.qp.hard_weight;
        let (first, found) = (self.problem.merit(&before, hard), self.problem.merit(z, hard));
        let weight = 1e2 * first.objective.abs().max(1.0);
        let far = self.moves_far(&before, z);
        let no_worse = status == SolveStatus::Converged && found.value(weight) <= (1.0 + WORSE) * first.value(weight);
        if no_worse || !far {
            self.spare.give(before);
            return Ok(status);
        }
        let (mut trial, steps) = (self.spare.copy(&before), self.interior_point_steps);
        self.start_afresh()?;
        let wide = self.sharpen_kinks(&mut trial, widths, last, log)?;
        self.problem.dynamics.set_smoothing(last);
        let again = self.solve_smooth(&mut trial, false, log)?;
        self.interior_point_steps += steps + wide;
        let other = self.problem.merit(&trial, hard).value(weight);
        let (mut best, mut status) = (found.value(weight), status);
        if again == SolveStatus::Converged && (other < best || status != SolveStatus::Converged) {
            self.spare.replace(z, trial);
            (best, status) = (other, again);
        } else {
            // The multipliers are those of the other one.
            self.qp.forget_multipliers();
            self.spare.give(trial);
        }
        if best > (1.0 + WORSE) * first.value(weight) && before.is_finite() {
            self.qp.forget_multipliers();
            self.spare.replace(z, before);
            return Ok(SolveStatus::Stalled);
        }
        self.spare.give(before);
        Ok(status)
    }

    /// Whether inputs differ by a good part of their sizes.
    fn moves_far(&self, from: &PlannedTrajectory, to: &PlannedTrajectory) -> bool {
        let trusts = &self.problem.ocp.input_trust;
        (0..from.steps()).any(|k| {
            let moved = from.u(k).iter().zip(to.u(k)).map(|(a, b)| (a - b).abs());
            moved.zip(trusts).any(|(d, trust)| d > FAR * if trust.is_finite() { *trust } else { 1.0 })
        })
    }
}
