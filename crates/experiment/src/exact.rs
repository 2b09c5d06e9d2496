//! Exact simulations of a model under the inputs of an experiment.

use crate::options::{ExperimentError, Limit};
use crate::setup::{Setup, start};
use crate::signals::Signals;
use bracketry_sim::{Model, SimulationSettings, simulate};
use bracketry_symbolic::{Rational, StopFlag};
use bracketry_system::System;

/// Most steps of a simulation, which then counts as impossible: an experiment that takes more is none for a rig.
const MOST_STEPS: usize = 400_000;
/// Tolerances, far below those of any sensor.
const TOLERANCES: (f64, f64) = (1e-8, 1e-10);

/// Where a column of a model comes from.
#[derive(Clone, Copy, Debug)]
enum Quantity {
    Output(usize),
    State(usize),
}

/// A parameter, or the value of a state at the start, that a refit may change.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Free {
    pub(crate) name: String,
    /// The state of which it is the value at the start; none for a parameter.
    pub(crate) state: Option<usize>,
    pub(crate) value: f64,
    pub(crate) range: [f64; 2],
    /// The unit of a relative change.
    pub(crate) scale: f64,
}

/// A model whose motion is simulated exactly, with stick and slip.
pub(crate) struct Exact<'a> {
    pub(crate) system: &'a System,
    quantities: Vec<Quantity>,
    settings: SimulationSettings,
    x0: Vec<f64>,
}

/// What is measured in a run, and how far it goes.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// One row per sample, in the order of the columns.
    pub(crate) outputs: Vec<Vec<f64>>,
    /// States at the samples.
    pub(crate) states: Vec<Vec<f64>>,
    /// Least and greatest value of every state.
    pub(crate) extremes: Vec<[f64; 2]>,
}

impl<'a> Exact<'a> {
    pub(crate) fn new(system: &'a System, setup: &'a Setup, stop: &StopFlag) -> Self {
        let quantity = |name: &String| {
            let output = system.outputs.iter().position(|o| o.0 == *name).map(Quantity::Output);
            output.or_else(|| system.state_index(name).map(Quantity::State))
        };
        let settings =
            SimulationSettings { max_steps: MOST_STEPS, stop: stop.clone(), ..SimulationSettings::default() };
        Self {
            system,
            quantities: setup.columns.iter().filter_map(quantity).collect(),
            settings: settings.with_tolerance(TOLERANCES.0, TOLERANCES.1),
            x0: start(system),
        }
    }

    /// The parameters that a refit may change.
    pub(crate) fn free(&self, fixed: &[String]) -> Vec<Free> {
        let free = self.system.parameters.iter().filter(|p| !p.is_fixed());
        free.map(|p| {
            let value = p.value.to_f64().value();
            let end = |v: &Option<Rational>, none: f64| v.as_ref().map_or(none, |v| v.to_f64().value());
            let range = [end(&p.min, f64::NEG_INFINITY), end(&p.max, f64::INFINITY)];
            let width = range[1] - range[0];
            let size = if width.is_finite() { width } else { 1.0 };
            let scale = if value == 0.0 { size } else { value.abs() };
            Free { name: self.system.symbol_name(p.symbol).to_owned(), state: None, value, range, scale }
        })
        .filter(|p| !fixed.contains(&p.name))
        .collect()
    }

    /// The values of the states at the start, which a refit may change by what the states do in these runs.
    pub(crate) fn starts<'r>(&self, runs: impl Iterator<Item = &'r Run>) -> Vec<Free> {
        let mut sizes = vec![0.0; self.x0.len()];
        for run in runs {
            for ((size, e), x0) in sizes.iter_mut().zip(&run.extremes).zip(&self.x0) {
                *size = f64::max(*size, (e[0] - x0).abs().max((e[1] - x0).abs()));
            }
        }
        let of = |(k, (name, size)): (usize, (String, f64))| {
            let scale = if size > 0.0 { size } else { 1.0 };
            let value = self.x0[k];
            Free { name: format!("{name}(0)"), state: Some(k), value, range: [value - scale, value + scale], scale }
        };
        self.system.state_names().into_iter().zip(sizes).enumerate().map(of).collect()
    }

    /// A run with parameters and starts at other values; none where it stops before its end.
    pub(crate) fn run(&self, signals: &Signals, values: &[(&Free, f64)]) -> Result<Option<Run>, ExperimentError> {
        // A delay is read when a model is compiled, so that values stand in the model.
        let mut moved;
        let mut system = self.system;
        let mut start = self.x0.clone();
        if !values.is_empty() {
            moved = system.clone();
            for (free, value) in values {
                let Ok(exact) = Rational::try_from(*value) else { return Ok(None) };
                match free.state {
                    Some(k) => start[k] = *value,
                    None => _ = moved.set_parameter(&free.name, exact),
                }
            }
            system = &moved;
        }
        let mut model = match Model::new(system, &signals.inputs()?) {
            Ok(model) => model,
            // Values that the equations exclude, such as a static level below the sliding one.
            Err(_) if !values.is_empty() => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let end = *signals.times.last().unwrap_or(&0.0);
        let simulation = simulate(model.clone(), 0.0, &start, end, &self.settings)?;
        if !simulation.outcome.is_finished() {
            return Ok(None);
        }
        let trajectory = &simulation.trajectory;
        let mut extremes = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.x0.len()];
        let mut x = vec![0.0; self.x0.len()];
        let mut meet = |x: &[f64]| {
            for (e, v) in extremes.iter_mut().zip(x) {
                *e = [e[0].min(*v), e[1].max(*v)];
            }
        };
        for t in trajectory.times() {
            trajectory.sample_into(t, &mut x);
            meet(&x);
        }
        let (mut outputs, mut states) = (Vec::with_capacity(signals.times.len()), Vec::new());
        for &t in &signals.times {
            trajectory.sample_into(t, &mut x);
            meet(&x);
            let y = model.output_values(t, &x);
            let row: Vec<f64> = self
                .quantities
                .iter()
                .map(|q| match *q {
                    Quantity::Output(k) => y[k],
                    Quantity::State(i) => x[i],
                })
                .collect();
            if !row.iter().all(|v| v.is_finite()) {
                return Ok(None);
            }
            outputs.push(row);
            states.push(x.clone());
        }
        Ok(Some(Run { outputs, states, extremes }))
    }

    /// By how much a run leaves each limit of a state, as a share of the width of the limit.
    pub(crate) fn excess(&self, run: &Run, limits: &[Limit]) -> Vec<f64> {
        let of = |limit: &Limit| {
            let Some(i) = self.system.state_index(&limit.name) else { return 0.0 };
            let [low, high] = run.extremes[i];
            (limit.low - low).max(high - limit.high).max(0.0) / (limit.high - limit.low)
        };
        limits.iter().map(of).collect()
    }
}
