//! A problem on the exact flow: roll-outs, their cost, and their linearization.

use super::flow::StickSlipFlow;
use crate::integrator::Interval;
use crate::ocp::Ocp;
use crate::trajectory::PlannedTrajectory;
use crate::transcription::{ShootingLinearization, spread_flow};
use bracketry_sim::{FrictionMode, ModeChange};

/// What the flow does in one interval of a roll-out.
#[derive(Clone, Default)]
pub(crate) struct IntervalModes {
    pub(crate) modes: Vec<FrictionMode>,
    signs: Vec<f64>,
    rows: Vec<f64>,
    pub(crate) changes: Vec<ModeChange>,
}

impl IntervalModes {
    /// Whether the switch sticks from start to end.
    pub(crate) fn sticks(&self, switch: usize) -> bool {
        self.modes.get(switch) == Some(&FrictionMode::Sticking) && self.changes.iter().all(|c| c.switch != switch)
    }
}

/// The problem with its exact flow.
pub(crate) struct ExactProblem {
    pub(crate) ocp: Ocp,
    pub(crate) flow: StickSlipFlow,
    /// Weight on violations of hard bounds.
    pub(crate) hard_weight: f64,
    /// Grid point of the run at which the horizon starts.
    pub(crate) k0: usize,
    pub(crate) lin: ShootingLinearization,
    /// The intervals of the roll-out that was linearized last.
    pub(crate) intervals: Vec<IntervalModes>,
    holds: Vec<Option<FrictionMode>>,
    end: Vec<f64>,
    /// Derivative of the flow of the dynamics' states.
    jacobian: Vec<f64>,
    /// Inputs that are the last states at the end of an interval.
    previous: Vec<usize>,
}

impl ExactProblem {
    pub(crate) fn new(ocp: Ocp, flow: StickSlipFlow, hard_weight: f64) -> Self {
        let (n, m) = (ocp.states(), ocp.inputs());
        let lin = ShootingLinearization {
            end: vec![0.0; ocp.steps * n],
            jacobian: vec![0.0; ocp.steps * n * (n + m)],
            ..ShootingLinearization::default()
        };
        let intervals = vec![IntervalModes::default(); ocp.steps];
        let jacobian = vec![0.0; ocp.model_states() * (ocp.model_states() + m)];
        let previous = ocp.previous_inputs.iter().map(|p| p.input).collect();
        Self { ocp, flow, hard_weight, k0: 0, lin, intervals, holds: Vec::new(), end: Vec::new(), jacobian, previous }
    }

    /// Interval k of the horizon under the input `u`; the flow gets its parameters.
    fn enter<'u>(&mut self, k: usize, u: &'u [f64]) -> Interval<'u> {
        if let Some(parameters) = self.ocp.parameter_row(self.ocp.sample(self.k0, k)) {
            self.flow.field.set_parameters(parameters);
        }
        let (dt, substeps) = (self.ocp.length(k), self.ocp.substeps.least());
        Interval { t: self.ocp.time(self.k0, k), dt, substeps, u }
    }

    /// Fills in the state at the end of interval k; false where the flow fails.
    pub(crate) fn advance(&mut self, z: &mut PlannedTrajectory, k: usize) -> bool {
        let done = self.flow_over(z, k);
        if done {
            let n = self.end.len();
            z.x_mut(k + 1)[..n].copy_from_slice(&self.end);
            for (i, &j) in self.previous.iter().enumerate() {
                z.x_mut(k + 1)[n + i] = z.u(k)[j];
            }
        }
        done
    }

    /// Advances the dynamics' state at grid point k to the end of its interval, into `end`; false where the flow fails.
    fn flow_over(&mut self, z: &PlannedTrajectory, k: usize) -> bool {
        let interval = self.enter(k, z.u(k));
        self.end.clear();
        self.end.extend_from_slice(&z.x(k)[..self.ocp.model_states()]);
        self.flow.advance(interval, &mut self.end, None, &[])
    }

    /// Cost and penalties; infinite where they are no number.
    fn value(&mut self, z: &PlannedTrajectory) -> f64 {
        let value = self.ocp.cost(self.k0, z) + self.ocp.penalty(self.k0, z, self.hard_weight);
        if value.is_finite() { value } else { f64::INFINITY }
    }

    /// Fills in the states that follow from the first one and the inputs; gives cost and penalties, infinite where the flow
    /// fails.
    pub(crate) fn roll_out(&mut self, z: &mut PlannedTrajectory) -> f64 {
        for k in 0..z.steps() {
            if !self.advance(z, k) {
                return f64::INFINITY;
            }
        }
        self.value(z)
    }

    /// As [`ExactProblem::roll_out`] for inputs that were moved from those of `plan`, the roll-out that was linearized last.
    /// Where the plan sticks, the derivative promises nothing beyond the friction that holds: there the move is shortened
    /// to what holds. The flag says whether any was.
    pub(crate) fn roll_out_held(&mut self, plan: &PlannedTrajectory, z: &mut PlannedTrajectory) -> (f64, bool) {
        let (n, m) = (self.ocp.model_states(), self.ocp.inputs());
        let w = n + m;
        let mut held = false;
        for k in 0..z.steps() {
            let interval = &self.intervals[k];
            let mut share = 1.0_f64;
            for i in 0..interval.modes.len() {
                if !interval.sticks(i) {
                    continue;
                }
                let row = &interval.rows[i * w..(i + 1) * w];
                let by_state: f64 = (0..n).map(|j| row[j] * (z.x(k)[j] - plan.x(k)[j])).sum();
                let by_input: f64 = (0..m).map(|j| row[n + j] * (z.u(k)[j] - plan.u(k)[j])).sum();
                let room = by_input.signum() - interval.signs[i] - by_state;
                if by_input != 0.0 && by_input.abs() > room * by_input.signum() {
                    share = share.min((room / by_input).clamp(0.0, 1.0));
                }
            }
            if share < 1.0 {
                held = true;
                for j in 0..m {
                    let from = plan.u(k)[j];
                    let by = z.u(k)[j] - from;
                    z.u_mut(k)[j] = from + share * by;
                }
            }
            if !self.advance(z, k) {
                return (f64::INFINITY, held);
            }
        }
        (self.value(z), held)
    }

    /// Linearizes along a roll-out and notes its modes; false where the flow fails.
    pub(crate) fn linearize(&mut self, z: &PlannedTrajectory) -> bool {
        self.linearize_with(z, None)
    }

    /// Linearizes along the roll-out that was linearized last with some of its sticking switches let slip in the modes given
    /// (one entry per switch): the end states are then not those of the roll-out.
    pub(crate) fn linearize_released(&mut self, z: &PlannedTrajectory, release: &[Option<FrictionMode>]) -> bool {
        self.linearize_with(z, Some(release))
    }

    fn linearize_with(&mut self, z: &PlannedTrajectory, release: Option<&[Option<FrictionMode>]>) -> bool {
        let n = self.ocp.states();
        let block = n * (n + self.ocp.inputs());
        for k in 0..z.steps() {
            let interval = self.enter(k, z.u(k));
            let modes = &self.intervals[k];
            self.holds.clear();
            if let Some(release) = release {
                self.holds.extend(release.iter().enumerate().map(|(i, mode)| mode.filter(|_| modes.sticks(i))));
            }
            let (end, previous) = self.lin.end[k * n..(k + 1) * n].split_at_mut(n - self.previous.len());
            end.copy_from_slice(&z.x(k)[..end.len()]);
            previous.iter_mut().zip(&self.previous).for_each(|(v, &j)| *v = interval.u[j]);
            let jacobian = &mut self.lin.jacobian[k * block..(k + 1) * block];
            let of_flow = if previous.is_empty() { &mut *jacobian } else { &mut self.jacobian };
            if !self.flow.advance(interval, end, Some(of_flow), &self.holds) {
                return false;
            }
            if !previous.is_empty() {
                spread_flow(&self.jacobian, (end.len(), interval.u.len()), &self.previous, jacobian);
            }
            if release.is_none() {
                let interval = &mut self.intervals[k];
                interval.modes.clone_from(&self.flow.start_modes);
                interval.signs.clone_from(&self.flow.start_signs);
                interval.rows.clone_from(&self.flow.start_rows);
                interval.changes.clone_from(&self.flow.changes);
            }
        }
        true
    }

    /// Whether any switch sticks over the first interval of a roll-out.
    pub(crate) fn sticks_at_start(&mut self, z: &PlannedTrajectory) -> bool {
        let done = self.flow_over(z, 0);
        let flow = &self.flow;
        done && (0..flow.start_modes.len())
            .any(|i| flow.start_modes[i] == FrictionMode::Sticking && flow.changes.iter().all(|c| c.switch != i))
    }

    /// Directions in which the switches that stick over the first interval are moved by the change `dx` of the states over
    /// the horizon: the sign of Σ_k ∇σ·dx_k.
    pub(crate) fn directions(&mut self, z: &PlannedTrajectory, dx: &[f64]) -> Vec<Option<FrictionMode>> {
        let n = self.ocp.states();
        let signs = self.intervals[0].signs.clone();
        let t = self.enter(0, z.u(0)).t;
        let of_model = self.ocp.model_states();
        self.flow.field.differentiate(t, &z.x(0)[..of_model], z.u(0), &signs);
        (0..signs.len())
            .map(|i| {
                let along: f64 = dx
                    .chunks_exact(n)
                    .map(|d| {
                        d[..of_model].iter().enumerate().map(|(j, d)| self.flow.field.gradient(i, j) * d).sum::<f64>()
                    })
                    .sum();
                (self.intervals[0].sticks(i) && along.abs() > 1e-9).then(|| FrictionMode::of_sign(along))
            })
            .collect()
    }
}
