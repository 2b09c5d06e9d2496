//! A smooth plant that checks its own steps.

use super::plant::{Plant, RungeKuttaPlant};
use crate::dynamics::SymbolicDynamics;
use crate::error::{MpcError, PlantFailure};
use crate::integrator::Interval;
use bracketry_sim::{ExactPlant, Outcome, PlantError, SimulationSettings, Statistics, Trajectory};
use bracketry_symbolic::StopFlag;
use bracketry_system::System;

/// Error of a sample, in units of the states' sizes, with which the fixed steps go on.
const ACCURATE: f64 = 1e-3;
/// What steps of half the length leave of the error of a method of order 4.
const LEFT: f64 = 1.0 / 16.0;
/// Most steps of a sample with error control.
const MOST_STEPS: usize = 1_000_000;

/// Where a plant went over to steps with error control, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refined {
    /// The sample.
    pub sample: usize,
    /// Its time, s.
    pub time: f64,
    /// The fixed steps.
    pub substeps: usize,
    /// Their error over the sample, in units of the states' sizes; infinite where they end in no number.
    pub error: f64,
}

/// A plant with the dynamics of a smooth model: the classical Runge–Kutta method with fixed steps while that is accurate, and from the
/// first sample over which it is not the simulator with error control, which takes implicit steps where the plant is stiff.
pub struct SmoothPlant<'a> {
    system: &'a System,
    fixed: RungeKuttaPlant,
    substeps: usize,
    /// Sizes of the states.
    sizes: Vec<f64>,
    settings: SimulationSettings,
    sample: usize,
    refined: Option<(Refined, ExactPlant)>,
}

impl<'a> SmoothPlant<'a> {
    /// A plant with `substeps` fixed steps per call, whose states have these sizes.
    ///
    /// # Errors
    /// [`MpcError`] if the equations cannot be compiled.
    pub fn new(system: &'a System, substeps: usize, sizes: &[f64], stop: &StopFlag) -> Result<Self, MpcError> {
        Ok(Self {
            system,
            fixed: RungeKuttaPlant::new(Box::new(SymbolicDynamics::new(system)?), substeps),
            substeps: substeps.max(1),
            sizes: sizes.to_vec(),
            settings: SimulationSettings { max_steps: MOST_STEPS, stop: stop.clone(), ..SimulationSettings::default() },
            sample: 0,
            refined: None,
        })
    }

    /// Records the motion from the state `x` at the time `t` on.
    pub fn start_recording(&mut self, t: f64, x: &[f64]) {
        self.fixed.start_recording(t, x);
    }

    /// The motion since [`SmoothPlant::start_recording`], which ends; none without it.
    pub fn take_recording(&mut self) -> Option<Trajectory> {
        let mut motion = self.fixed.take_recording()?;
        if let Some((_, exact)) = &mut self.refined {
            motion.append(&exact.take_recording());
        }
        Some(motion)
    }

    /// Where it went over to error control; none if the fixed steps did.
    pub fn refined(&self) -> Option<Refined> {
        self.refined.as_ref().map(|(refined, _)| *refined)
    }

    /// Work done.
    pub fn statistics(&self) -> Statistics {
        match &self.refined {
            Some((refined, exact)) => {
                let of_exact = exact.statistics();
                Statistics { steps: of_exact.steps + refined.sample * self.substeps, ..of_exact }
            }
            None => Statistics { steps: self.sample * self.substeps, ..Statistics::default() },
        }
    }

    /// The error of the fixed steps over a sample.
    fn error(&mut self, t: f64, x: &[f64], u: &[f64], dt: f64) -> f64 {
        let ends = [1, 2].map(|times| {
            let mut end = x.to_vec();
            self.fixed.tries(Interval { t, dt, substeps: times * self.substeps, u }, &mut end);
            end
        });
        let of = |i: usize| (ends[0][i] - ends[1][i]).abs() / (1.0 - LEFT) / self.sizes[i].max(x[i].abs());
        let error =
            (0..x.len()).map(of).fold(0.0, |largest: f64, e| if e.is_nan() { f64::INFINITY } else { largest.max(e) });
        if ends.iter().flatten().all(|v| v.is_finite()) { error } else { f64::INFINITY }
    }

    /// One sample with error control.
    fn control_error(exact: &mut ExactPlant, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError> {
        if exact.state() != x {
            exact.set_state(x)?;
        }
        match exact.hold(u, dt)? {
            Outcome::Finished => x.copy_from_slice(exact.state()),
            // As where fixed steps end in no number: the loop says which state, and when.
            Outcome::Stopped { .. } => x.fill(f64::NAN),
        }
        Ok(())
    }
}

impl Plant for SmoothPlant<'_> {
    /// # Errors
    /// As [`RungeKuttaPlant`]; [`PlantError`] where a length is wrong.
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantFailure> {
        let sample = self.sample;
        self.sample += 1;
        if !x.iter().all(|v| v.is_finite()) {
            return Ok(());
        }
        if self.refined.is_none() {
            // Algebraic variables are for the fixed steps alone.
            let error = if self.system.algebraic.is_empty() { self.error(t, x, u, dt) } else { 0.0 };
            if error <= ACCURATE {
                return self.fixed.step(t, x, u, dt);
            }
            let mut exact = ExactPlant::starting_at(self.system, t, x, &self.settings)?;
            exact.start_recording();
            self.refined = Some((Refined { sample, time: t, substeps: self.substeps, error }, exact));
        }
        if let Some((_, exact)) = &mut self.refined {
            Self::control_error(exact, x, u, dt)?;
        }
        Ok(())
    }
}
