//! The thing that is controlled.

use crate::dynamics::Dynamics;
use crate::error::{PlantFailure, check_length, check_value};
use crate::integrator::{Integrator, Interval};
use crate::transcription::Shooter;
use bracketry_sim::{DiscreteModel, ExactPlant, Model, NoRoot, Outcome, StopReason, Trajectory};

/// The thing that is controlled.
pub trait Plant {
    /// Advances the state `x` from time `t` by `dt` under constant inputs `u`.
    ///
    /// # Errors
    /// Whatever stops the plant.
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantFailure>;
}

/// A plant with the dynamics of a model, integrated by the classical Runge–Kutta method.
pub struct RungeKuttaPlant {
    dynamics: Box<dyn Dynamics>,
    shooter: Shooter,
    substeps: usize,
    recording: Option<Recording>,
}

/// A motion by steps, and memory for the ends of a step.
struct Recording {
    motion: Trajectory,
    before: Vec<f64>,
    slopes: [Vec<f64>; 2],
}

impl RungeKuttaPlant {
    /// A plant with `substeps` integration steps per call.
    pub fn new(dynamics: Box<dyn Dynamics>, substeps: usize) -> Self {
        let shooter = Shooter::new(dynamics.as_ref(), Integrator::Rk4);
        Self { shooter, dynamics, substeps: substeps.max(1), recording: None }
    }

    /// Records the motion from the state `x` at the time `t` on: the steps of the method, and Hermite's cubic between their ends.
    pub fn start_recording(&mut self, t: f64, x: &[f64]) {
        let motion = Trajectory::starting_at(t, x);
        let slopes = [vec![0.0; x.len()], vec![0.0; x.len()]];
        self.recording = Some(Recording { motion, before: x.to_vec(), slopes });
    }

    /// The motion since [`RungeKuttaPlant::start_recording`], which ends; none without it.
    pub fn take_recording(&mut self) -> Option<Trajectory> {
        self.recording.take().map(|recording| recording.motion)
    }

    /// One interval without a record.
    pub(super) fn tries(&mut self, interval: Interval<'_>, x: &mut [f64]) {
        self.shooter.advance(self.dynamics.as_mut(), interval, x);
    }

    /// One interval, and its record.
    fn advance(&mut self, interval: Interval<'_>, x: &mut [f64]) {
        let Self { dynamics, shooter, recording, .. } = self;
        let Some(Recording { motion, before, slopes: [first, last] }) = recording else {
            return shooter.advance(dynamics.as_mut(), interval, x);
        };
        let Interval { t, dt, substeps, u } = interval;
        let h = dt / substeps as f64;
        for k in 0..substeps {
            let from = t + h * k as f64;
            before.copy_from_slice(x);
            dynamics.field(from, before, u, first);
            shooter.advance(dynamics.as_mut(), Interval { t: from, dt: h, substeps: 1, u }, x);
            dynamics.field(from + h, x, u, last);
            motion.push_cubic(from, h, [before, x], [first, last]);
        }
    }
}

impl Plant for RungeKuttaPlant {
    /// # Errors
    /// [`PlantEquations`] where algebraic equations have no solution.
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantFailure> {
        self.advance(Interval { t, dt, substeps: self.substeps, u }, x);
        match self.dynamics.take_failure() {
            Some((t, failure)) if x.iter().any(|v| !v.is_finite()) => Err(Box::new(PlantEquations { t, failure })),
            _ => Ok(()),
        }
    }
}

/// A model that is discrete in time is a plant; a sample lasts a whole number of its periods.
impl Plant for DiscreteModel {
    /// # Errors
    /// [`MpcError::Value`](crate::MpcError::Value) for a time that is shorter than the period,
    /// [`MpcError::Length`](crate::MpcError::Length) for a vector of the wrong length.
    fn step(&mut self, _t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantFailure> {
        check_length("the state of the plant", x.len(), self.states())?;
        check_length("the inputs of the plant", u.len(), self.inputs())?;
        let steps = (dt / self.period()).round();
        check_value(steps >= 1.0, "a sample of a plant that is discrete in time", dt, "give a multiple of its period")?;
        (0..steps as usize).for_each(|_| DiscreteModel::step(self, x, u));
        Ok(())
    }
}

/// A simulation with exact stick and slip is a plant; its inputs are held from sample to sample.
impl Plant for ExactPlant {
    /// # Errors
    /// [`PlantStopped`] where the simulation ends, [`bracketry_sim::PlantError`] where a length is wrong.
    fn step(&mut self, _t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantFailure> {
        if self.state() != x {
            self.set_state(x)?;
        }
        match self.hold(u, dt)? {
            Outcome::Finished => {
                x.copy_from_slice(self.state());
                Ok(())
            }
            Outcome::Stopped { reason, t, state } => {
                Err(Box::new(PlantStopped { reason, t, state, model: self.model().clone() }))
            }
        }
    }
}

/// A plant whose algebraic equations have no solution.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("the algebraic equations of the plant could not be solved (equation {}, residual {}) at t = {t}", failure.equation + 1, failure.residual)]
pub struct PlantEquations {
    /// When, s.
    pub t: f64,
    /// Which, and why.
    pub failure: NoRoot,
}

/// A simulated plant that cannot go on.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{reason} (t = {t})")]
pub struct PlantStopped {
    /// Why.
    pub reason: StopReason,
    /// When, s.
    pub t: f64,
    /// In which state.
    pub state: Vec<f64>,
    /// The plant's equations with the inputs of that time.
    pub model: Model,
}
