//! Exact simulations of a model under the inputs of an experiment.

use crate::options::{ExperimentError, Limit};
use crate::setup::{Setup, start};
use crate::signals::Signals;
use bracketry_sim::{Model, SimulationSettings, simulate};
use bracketry_symbolic::StopFlag;
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

/// A parameter that a refit may change.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Free {
    pub(crate) name: String,
    pub(crate) value: f64,
    pub(crate) range: [f64; 2],
    /// The unit of a relative change.
    pub(crate) scale: f64,
}

/// A model whose motion is simulated exactly, with stick and slip.
pub(crate) struct Exact<'a> {
    pub(crate) system: &'a System,
    setup: &'a Setup,
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
            setup,
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
            let end =
                |v: &Option<bracketry_symbolic::Rational>, none: f64| v.as_ref().map_or(none, |v| v.to_f64().value());
            let range = [end(&p.min, f64::NEG_INFINITY), end(&p.max, f64::INFINITY)];
            let width = range[1] - range[0];
            let size = if width.is_finite() { width } else { 1.0 };
            let scale = if value == 0.0 { size } else { value.abs() };
            Free { name: self.system.symbol_name(p.symbol).to_owned(), value, range, scale }
        })
        .filter(|p| !fixed.contains(&p.name))
        .collect()
    }

    /// A run with parameters at other values; none where it stops before its end.
    pub(crate) fn run(&self, signals: &Signals, values: &[(&str, f64)]) -> Result<Option<Run>, ExperimentError> {
        let mut inputs = signals.inputs(&self.setup.rest())?;
        for (name, value) in values {
            inputs = inputs.live(name, *value);
        }
        let mut model = Model::new(self.system, &inputs)?;
        let end = *signals.times.last().unwrap_or(&0.0);
        let simulation = simulate(model.clone(), 0.0, &self.x0, end, &self.settings)?;
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
