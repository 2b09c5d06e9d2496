//! Whether the model moves on the time scale of the samples.

use bracketry_numerics::eigen::eigenvalues;
use std::f64::consts::PI;

use bracketry_system::System;
use nalgebra::DMatrix;

use super::multiple_shooting::Study;
use super::window::Window;
use crate::error::DiagnoseError;
use crate::record::Record;

/// Eigenvalues below this share of the largest are zero: motions that never end.
const ZERO_EIGENVALUE: f64 = 1e-6;

impl Study {
    /// Refuses data between whose samples the model, with the parameters that it has, does all that it ever does, and data over
    /// which it cannot be simulated in reasonable time: then its time is not that of the data.
    ///
    /// The first by the eigenvalues of the Jacobian at the beginning of windows: if even the slowest motion that is not for
    /// ever turns by more than half a turn between two samples, and some motion oscillates, the data are aliased.
    pub(crate) fn check_time_scale(&self) -> Result<(), DiagnoseError> {
        let mut fast: Vec<Option<f64>> = Vec::new();
        let every = self.windows.len().div_ceil(self.settings.time_scale.examined_windows).max(1);
        let mut jacobian = Jacobian::new(&self.system)?;
        for window in self.windows.iter().step_by(every) {
            let record = &self.sources.records[window.record];
            let x = self.guesses[window.record].at(record, *window);
            fast.push(jacobian.slowest_oscillation(record, window.from, &x).filter(|w| w * self.step(window) > PI));
        }
        let all: Option<Vec<f64>> = fast.into_iter().collect();
        if let Some(rate) = all.and_then(|rates| rates.into_iter().reduce(f64::min))
            && let Some(window) = self.windows.first()
        {
            let step = self.step(window);
            return Err(DiagnoseError::TimeScale {
                record: self.sources.records[window.record].name.clone(),
                step,
                turns: rate * step / (2.0 * PI),
            });
        }
        self.check_effort()
    }

    /// Mean time between the samples of a window, s.
    fn step(&self, window: &Window) -> f64 {
        let times = &self.sources.records[window.record].times[window.from..window.to];
        (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64
    }

    /// Counts the steps of a simulation over one window.
    fn check_effort(&self) -> Result<(), DiagnoseError> {
        let compiled = self.compiled(&[])?;
        let theta: Vec<f64> = compiled.unknowns.iter().map(|u| u.nominal).collect();
        let mut slots = self.slots(&compiled, &[0], None)?;
        let Some(slot) = slots.first_mut() else { return Ok(()) };
        let mut out = vec![0.0; slot.runner.target.len()];
        // A simulation that ends early is told of where windows are fitted.
        let Some(steps) = slot.runner.steps(&theta, &slot.start, &mut out) else { return Ok(()) };
        let per_sample = steps as f64 / slot.runner.samples() as f64;
        let samples: f64 = self.sources.records.iter().map(|r| r.times.len() as f64).sum();
        let most = &self.settings.time_scale;
        if per_sample > most.most_steps_per_sample && per_sample * samples > most.most_steps_in_all {
            let window = self.windows[0];
            return Err(DiagnoseError::Effort {
                record: self.sources.records[window.record].name.clone(),
                per_sample: per_sample.round() as usize,
                step: self.step(&window),
            });
        }
        Ok(())
    }
}

/// `∂f/∂x` of a model with the parameters that it has.
struct Jacobian {
    tape: bracketry_symbolic::Tape,
    states: usize,
    work: Vec<f64>,
}

impl Jacobian {
    fn new(system: &System) -> Result<Self, DiagnoseError> {
        let mut system = system.clone();
        let states = system.states.clone();
        let mut entries = Vec::with_capacity(states.len() * states.len());
        for f in system.dynamics.clone() {
            for &x in &states {
                entries.push(system.pool.diff(f, x));
            }
        }
        let arguments = system.arguments();
        let tape = system
            .compile(&arguments, &entries)
            .map_err(|e| DiagnoseError::Term { text: system.name.clone(), message: e.to_string() })?;
        Ok(Self { tape, states: states.len(), work: Vec::new() })
    }

    /// Size of the smallest eigenvalue that is not zero, rad/s, if some motion oscillates.
    fn slowest_oscillation(&mut self, record: &Record, sample: usize, x: &[f64]) -> Option<f64> {
        let driving = record.inputs.iter().chain(&record.input_derivatives).map(|signal| signal.values[sample]);
        let arguments: Vec<f64> = x.iter().copied().chain(driving).collect();
        let mut entries = vec![0.0; self.states * self.states];
        self.tape.eval(&arguments, &mut self.work, &mut entries);
        if entries.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let values = eigenvalues(&DMatrix::from_row_slice(self.states, self.states, &entries))?;
        let sizes = || values.iter().map(|(re, im)| re.hypot(*im));
        let largest = sizes().fold(0.0, f64::max);
        let moving = |(_, size): &(&(f64, f64), f64)| *size > ZERO_EIGENVALUE * largest;
        let oscillates = values.iter().zip(sizes()).filter(moving).any(|((re, im), _)| im.abs() > re.abs());
        oscillates
            .then(|| values.iter().zip(sizes()).filter(moving).map(|(_, size)| size).fold(f64::INFINITY, f64::min))
    }
}
