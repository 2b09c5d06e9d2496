//! Problem, dynamics and integrator together: what both solution methods share.

use super::merit::Merit;
use super::shooting::{Grid, Shooter, ShootingLinearization};
use crate::dynamics::Dynamics;
use crate::error::{MpcError, check_length};
use crate::ocp::{FINEST_ROUNDING, Ocp, Substeps};
use crate::trajectory::PlannedTrajectory;

/// Largest product of step and relaxation rate; the method of order 4 is stable up to 2.78 on the negative real axis.
pub(crate) const STABLE_STEP: f64 = 2.0;

pub(crate) struct Transcription {
    pub(crate) dynamics: Box<dyn Dynamics>,
    pub(crate) ocp: Ocp,
    pub(crate) shooter: Shooter,
    pub(crate) substeps: usize,
    /// Grid point of the run at which the horizon starts.
    pub(crate) k0: usize,
    /// Ends of the intervals of the trajectory whose merit was computed last.
    pub(crate) ends: Vec<f64>,
    end: Vec<f64>,
}

fn grid(ocp: &Ocp, k0: usize, substeps: usize) -> Grid<'_> {
    Grid { k0, substeps, ocp }
}

impl Transcription {
    pub(crate) fn new(dynamics: Box<dyn Dynamics>, mut ocp: Ocp) -> Result<Self, MpcError> {
        ocp.check(dynamics.states(), dynamics.inputs())?;
        ocp.round_norms(FINEST_ROUNDING);
        for row in &ocp.parameters {
            check_length("a row of parameters", row.len() + ocp.branch_parameters(0).len(), dynamics.parameters())?;
        }
        let shooter = Shooter::of_problem(dynamics.as_ref(), &ocp);
        Ok(Self { dynamics, ocp, shooter, substeps: 1, k0: 0, ends: Vec::new(), end: Vec::new() })
    }

    /// Gives the live parameters of the dynamics these values at every grid point.
    pub(crate) fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        check_length("the parameters", parameters.len(), self.dynamics.parameters())?;
        self.ocp.parameters.resize(1, Vec::new());
        self.ocp.parameters[0].clear();
        self.ocp.parameters[0].extend_from_slice(parameters);
        Ok(())
    }

    /// Changes the problem; says whether its programs need another layout. A change that contradicts the problem or the dynamics
    /// is undone.
    pub(crate) fn change(&mut self, change: impl FnOnce(&mut Ocp)) -> Result<bool, MpcError> {
        let mut ocp = self.ocp.clone();
        change(&mut ocp);
        ocp.check(self.dynamics.states(), self.dynamics.inputs())?;
        for row in &ocp.parameters {
            let found = row.len() + ocp.branch_parameters(0).len();
            check_length("a row of parameters", found, self.dynamics.parameters())?;
        }
        let relaid = ocp.layout_of_bounds() != self.ocp.layout_of_bounds();
        self.ocp = ocp;
        Ok(relaid)
    }

    pub(crate) fn check_trajectory(&self, trajectory: &PlannedTrajectory) -> Result<(), MpcError> {
        check_length("the states of the guess", trajectory.states(), self.ocp.states())?;
        check_length("the inputs of the guess", trajectory.inputs(), self.ocp.inputs())?;
        check_length("the guess", trajectory.steps(), self.ocp.steps)
    }

    /// Chooses the number of integration steps for the current smoothing.
    pub(crate) fn choose_substeps(&mut self, trajectory: &PlannedTrajectory) {
        self.ocp.follow_time(trajectory);
        self.substeps = match self.ocp.substeps {
            Substeps::Fixed(s) => s,
            // An implicit method is stable for any step.
            Substeps::AtLeast(s) if self.ocp.integrator.is_implicit() => s,
            Substeps::AtLeast(s) => {
                let mut rate = 0.0_f64;
                let n = self.ocp.model_states();
                let grid = grid(&self.ocp, self.k0, self.substeps);
                for k in 0..trajectory.steps() {
                    let t = grid.enter(self.dynamics.as_mut(), k, trajectory.u(k)).t;
                    rate = rate.max(self.dynamics.relaxation_rate(t, &trajectory.x(k)[..n], trajectory.u(k)));
                }
                s.max((self.ocp.longest() * rate / STABLE_STEP).ceil().min(1e4) as usize)
            }
        };
    }

    pub(crate) fn linearize(
        &mut self,
        trajectory: &PlannedTrajectory,
        from: usize,
        to: usize,
        lin: &mut ShootingLinearization,
    ) {
        self.ocp.follow_time(trajectory);
        let grid = grid(&self.ocp, self.k0, self.substeps);
        self.shooter.linearize(self.dynamics.as_mut(), grid, trajectory, from..to, lin);
    }

    /// As [`Transcription::linearize`] for all intervals, with the second derivatives of [`Transcription::curvatures`].
    pub(crate) fn linearize_with_curvatures(
        &mut self,
        trajectory: &PlannedTrajectory,
        multipliers: &[f64],
        field: &[(usize, usize)],
        lin: &mut ShootingLinearization,
    ) {
        self.ocp.follow_time(trajectory);
        let grid = grid(&self.ocp, self.k0, self.substeps);
        let dynamics = self.dynamics.as_mut();
        self.shooter.linearize_with_curvatures(dynamics, grid, trajectory, (multipliers, field), lin);
    }

    /// Adds the second derivatives of the dynamics in the Lagrangian with these multipliers; `field` holds the places of those of
    /// the field.
    pub(crate) fn curvatures(
        &mut self,
        trajectory: &PlannedTrajectory,
        multipliers: &[f64],
        field: &[(usize, usize)],
        lin: &mut ShootingLinearization,
    ) {
        self.ocp.follow_time(trajectory);
        let grid = grid(&self.ocp, self.k0, self.substeps);
        let dynamics = self.dynamics.as_mut();
        self.shooter.curvatures(dynamics, grid, trajectory, multipliers, field, &mut lin.curvature);
    }

    pub(crate) fn roll_out(&mut self, trajectory: &mut PlannedTrajectory) {
        self.ocp.follow_time(trajectory);
        let grid = grid(&self.ocp, self.k0, self.substeps);
        self.shooter.roll_out(self.dynamics.as_mut(), grid, trajectory);
    }

    /// Fills in the last state from the one before it, unless the dynamics fail there.
    pub(crate) fn extend_last(&mut self, trajectory: &mut PlannedTrajectory) {
        self.ocp.follow_time(trajectory);
        let last = trajectory.steps() - 1;
        if self.advance(last, trajectory.x(last), trajectory.u(last)) {
            trajectory.x_mut(last + 1).copy_from_slice(&self.end);
        }
    }

    /// Advances a state by one interval from the start of the horizon; it is kept where the dynamics fail.
    pub(crate) fn predict(&mut self, x: &mut [f64], u: &[f64]) {
        if self.advance(0, x, u) {
            x.copy_from_slice(&self.end);
        }
    }

    /// Advances a state over interval k into `end`; false where that is not finite.
    fn advance(&mut self, k: usize, x: &[f64], u: &[f64]) -> bool {
        self.end.clear();
        self.end.extend_from_slice(x);
        let interval = grid(&self.ocp, self.k0, self.substeps).enter(self.dynamics.as_mut(), k, u);
        self.shooter.advance(self.dynamics.as_mut(), interval, &mut self.end);
        self.end.iter().all(|v| v.is_finite())
    }

    /// Merit of a trajectory whose interval ends have been computed.
    pub(crate) fn merit_with(&mut self, trajectory: &PlannedTrajectory, ends: &[f64], hard: f64) -> Merit {
        let n = self.ocp.states();
        let (mut sum, mut worst) = (0.0, 0.0_f64);
        for k in 0..trajectory.steps() {
            for i in 0..n {
                let d = (ends[k * n + i] - trajectory.x(k + 1)[i]).abs() / self.ocp.state_scale[i];
                sum += d;
                worst = worst.max(d);
            }
        }
        let objective = self.ocp.cost(self.k0, trajectory) + self.ocp.penalty(self.k0, trajectory, hard);
        Merit { objective, defects: sum, worst_defect: worst }
    }

    /// Ends of all intervals of a trajectory.
    pub(crate) fn end_states(&mut self, trajectory: &PlannedTrajectory, ends: &mut Vec<f64>) {
        self.ocp.follow_time(trajectory);
        let grid = grid(&self.ocp, self.k0, self.substeps);
        self.shooter.end_states(self.dynamics.as_mut(), grid, trajectory, ends);
    }

    /// Merit of any trajectory.
    pub(crate) fn merit(&mut self, trajectory: &PlannedTrajectory, hard: f64) -> Merit {
        let mut ends = std::mem::take(&mut self.ends);
        self.end_states(trajectory, &mut ends);
        let merit = self.merit_with(trajectory, &ends, hard);
        self.ends = ends;
        merit
    }

    /// Weight that makes the sum of scaled defects an exact penalty for these multipliers.
    pub(crate) fn penalty_weight(&self, multipliers: &[f64]) -> f64 {
        let n = self.ocp.states();
        multipliers.iter().enumerate().fold(0.0, |w: f64, (i, y)| w.max(y.abs() * self.ocp.state_scale[i % n])) * 1.2
    }
}
