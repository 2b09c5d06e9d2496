//! The advanced step: solutions for the predicted state before the measurement, moved to it afterwards.

use super::{HARD_TOLERANCE, Rti};
use crate::controller::StepStatus;
use crate::error::MpcError;
use crate::qp::QpStatus;
use std::time::Instant;

impl Rti {
    /// Solves programs for the predicted state and takes their trajectory over as the plan; the status of the last.
    pub(super) fn solve_ahead(&mut self, programs: usize, start: Instant) -> Result<Option<StepStatus>, MpcError> {
        // After a failure the plan is played out as it is.
        if self.failures.in_a_row() > 0 || !self.failures.x.iter().all(|v| v.is_finite()) {
            return Ok(None);
        }
        self.work.copy_from(&self.trajectory);
        self.trial.copy_from(&self.trajectory);
        self.work.x_mut(0).copy_from_slice(&self.failures.x);
        let mut last = None;
        for _ in 0..programs {
            self.problem.linearize(&self.work, 0, self.work.steps(), &mut self.lin);
            let (k0, lambda) = (self.problem.k0, self.settings.proximal);
            self.qp.assemble(&mut self.problem.ocp, k0, &self.work, &self.lin, lambda);
            let left = self.settings.time_limit - start.elapsed().as_secs_f64();
            if left <= 0.0 {
                break;
            }
            self.qp.set_limits(self.settings.qp.max_iterations, self.settings.qp.time_limit.min(left))?;
            last = match self.qp.solve()? {
                QpStatus::Solved | QpStatus::Relaxed => Some(StepStatus::Solved),
                QpStatus::Inaccurate => Some(StepStatus::Inaccurate),
                _ => None,
            };
            if last.is_none() || !self.advance() {
                break;
            }
        }
        if last.is_none() || !self.work.is_finite() {
            return Ok(None);
        }
        std::mem::swap(&mut self.trajectory, &mut self.work);
        self.failures.plan_ahead(self.trajectory.steps());
        Ok(last)
    }

    /// Moves the solution of the program solved ahead to the measurement and takes it over; `None` where there is none or it
    /// leads out of the bounds.
    pub(super) fn move_along(&mut self, x: &[f64]) -> Option<StepStatus> {
        let (tangent, status) = self.tangent.as_mut()?;
        let status = *status;
        let kept = tangent.follow(x, &self.lin, &self.problem.ocp, &mut self.work);
        if !kept || !self.work.is_finite() {
            self.work.copy_from(&self.trajectory);
            return None;
        }
        std::mem::swap(&mut self.trajectory, &mut self.work);
        let broken = self.problem.ocp.hard_violation(self.problem.k0, &self.trajectory) > HARD_TOLERANCE;
        Some(if broken { StepStatus::Infeasible } else { status })
    }
}
