//! What inputs really cost: roll-outs of the controller's model without a controller.

use super::control_problem::ControlProblem;
use crate::error::MpcError;
use crate::exact_friction::{ExactProblem, StickSlipFlow, SwitchedField};
use crate::integrator::Integrator;
use crate::trajectory::PlannedTrajectory;
use crate::transcription::Transcription;

/// Width by which unit vectors are rounded on the exact flow.
const ROUNDING: f64 = 1e-3;
/// Shares of the largest input that are held.
const LEVELS: [f64; 6] = [1.0, 0.5, 0.25, -0.25, -0.5, -1.0];
/// Shares of the horizon for which they are held; the inputs are at rest afterwards. Moved blocks are held to the end.
const DURATIONS: [f64; 3] = [1.0, 0.5, 0.25];
/// Change of an input, as a share of what it may change, below which it stays.
const STAYS: f64 = 1e-2;
/// Height of waves around the guess, as a share of what an input may change.
const WAVE: f64 = 0.1;

/// Samples of a run from which on another plan hardly adds to its time.
pub(super) const OTHER_START: usize = 20;

/// The controller's model, to be rolled out.
pub(super) enum Rehearsal {
    /// Smooth, or with smoothed friction.
    Smoothed { model: Box<Transcription>, hard_weight: f64 },
    /// With exact friction.
    Exact(Box<ExactProblem>),
}

/// A simple input and what it costs.
#[derive(Clone, Debug)]
pub(super) struct Held {
    /// Index of the input.
    pub(super) input: usize,
    pub(super) value: f64,
    /// Intervals.
    pub(super) intervals: usize,
    /// Cost and penalties over the horizon.
    pub(super) cost: f64,
    /// The motion.
    pub(super) trajectory: PlannedTrajectory,
}

impl Rehearsal {
    /// The model as the smoothing methods have it.
    pub(super) fn smoothed(problem: &ControlProblem) -> Result<Self, MpcError> {
        let mut model = Transcription::new(problem.dynamics()?, problem.ocp.clone())?;
        if let Some(w) = problem.widths().last() {
            model.dynamics.set_smoothing(*w);
        }
        Ok(Self::Smoothed { model: Box::new(model), hard_weight: problem.qp.hard_weight })
    }

    /// The model with exact friction where it has any, and can be integrated explicitly.
    pub(super) fn exact(problem: &ControlProblem) -> Result<Self, MpcError> {
        if problem.system.is_smooth() || problem.ocp.integrator != Integrator::Rk4 {
            return Self::smoothed(problem);
        }
        let live: Vec<&str> = problem.live.iter().map(String::as_str).collect();
        let flow = StickSlipFlow::new(SwitchedField::new(&problem.system, &live, ROUNDING)?);
        Ok(Self::Exact(Box::new(ExactProblem::new(problem.ocp.clone(), flow, problem.qp.hard_weight))))
    }

    /// Fills in the states that follow from the first one and the inputs; gives cost and penalties, infinite where they are
    /// no number.
    pub(super) fn cost(&mut self, plan: &mut PlannedTrajectory) -> f64 {
        let cost = match self {
            Self::Exact(problem) => problem.roll_out(plan),
            Self::Smoothed { model, hard_weight } => {
                model.choose_substeps(plan);
                model.roll_out(plan);
                let (k0, hard) = (model.k0, *hard_weight);
                model.ocp.cost(k0, plan) + model.ocp.penalty(k0, plan, hard)
            }
        };
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// The motions from the initial state with one input at one of its bounds, the others at rest.
    pub(super) fn at_bounds(&mut self, problem: &ControlProblem) -> Vec<PlannedTrajectory> {
        let rest = problem.first_input();
        let mut motions = Vec::new();
        for (j, &(min, max)) in problem.ocp.input_bounds.iter().enumerate() {
            for value in [min, max] {
                let mut plan = PlannedTrajectory::constant(problem.ocp.steps, &problem.initial_state(), &rest);
                (0..plan.steps()).for_each(|k| plan.u_mut(k)[j] = value);
                self.cost(&mut plan);
                motions.push(plan);
            }
        }
        motions
    }

    /// The cheapest of simple inputs from the initial state: one input held for a while, the others at rest.
    pub(super) fn best_held(&mut self, problem: &ControlProblem) -> Option<Held> {
        let (rest, steps) = (problem.first_input(), problem.ocp.steps);
        let mut best: Option<Held> = None;
        let (own, all) = (problem.ocp.inputs_of_branch(), problem.ocp.inputs());
        for (j, &(min, max)) in problem.ocp.input_bounds.iter().enumerate().take(own) {
            let size = problem.ocp.input_trust[j];
            let end = |sign: f64| {
                let bound = if sign > 0.0 { max } else { min };
                if bound.is_finite() { bound } else { rest[j] + sign * size }
            };
            for level in LEVELS {
                let value = rest[j] + level.abs() * (end(level) - rest[j]);
                let whole = !problem.ocp.move_blocks.is_empty() || problem.ocp.constant_inputs.contains(&j);
                let durations = if whole { &DURATIONS[..1] } else { &DURATIONS[..] };
                for duration in durations {
                    let intervals = ((duration * steps as f64).ceil() as usize).max(1);
                    let mut plan = PlannedTrajectory::constant(steps, &problem.initial_state(), &rest);
                    // The same in every branch.
                    (0..intervals).for_each(|k| (j..all).step_by(own).for_each(|j| plan.u_mut(k)[j] = value));
                    let cost = self.cost(&mut plan);
                    if best.as_ref().is_none_or(|b| cost < b.cost) {
                        best = Some(Held { input: j, value, intervals, cost, trajectory: plan });
                    }
                }
            }
        }
        best.filter(|b| b.cost.is_finite())
    }
}

impl ControlProblem {
    /// Whether the inputs are those of the guess.
    pub(super) fn stays<'u>(&self, inputs: impl IntoIterator<Item = &'u [f64]>) -> bool {
        let last = self.guess.last();
        inputs.into_iter().enumerate().all(|(k, u)| {
            let near =
                |g: &Vec<f64>| u.iter().zip(g).zip(&self.ocp.input_trust).all(|((u, g), t)| (u - g).abs() <= STAYS * t);
            self.guess.get(k).or(last).is_some_and(near)
        })
    }

    /// The guess with a wave on every input: from there, a plan finds out of a point at which the guess is stationary and no
    /// minimum.
    pub(super) fn waves(&self) -> PlannedTrajectory {
        let mut start = self.start();
        let (steps, own) = (start.steps(), self.ocp.inputs_of_branch().max(1));
        for k in 0..steps {
            let turn = std::f64::consts::TAU * (k as f64 + 0.5) / steps as f64;
            for (j, (u, trust)) in start.u_mut(k).iter_mut().zip(&self.ocp.input_trust).enumerate() {
                *u += WAVE * trust * ((j % own + 1) as f64 * turn).cos();
            }
        }
        start.clamp_inputs(&self.ocp.input_bounds);
        start
    }

    /// A start away from the guess: inputs at rest, which is said, or waves where those are the guess.
    pub(super) fn elsewhere(&self) -> (bool, PlannedTrajectory) {
        let steps = self.ocp.steps;
        let rest = PlannedTrajectory::constant(steps, &self.initial_state(), &self.first_input());
        let at_rest = !self.stays((0..steps).map(|k| rest.u(k)));
        (at_rest, if at_rest { rest } else { self.waves() })
    }
}
