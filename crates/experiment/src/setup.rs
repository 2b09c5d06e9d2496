//! What is common to both kinds of experiments: inputs with their limits, measured columns, times.

use crate::options::{ExperimentError, ExperimentOptions, Limit};
use bracketry_symbolic::closest_name;
use bracketry_system::{Quantities, System};

/// Samples of an experiment unless their distance is given.
const SAMPLES: f64 = 200.0;
/// Most samples.
const MOST_SAMPLES: f64 = 20000.0;
/// Most pieces on which an input is chosen: enough for several switches per direction, few enough for a second per solution.
const PIECES: usize = 40;

/// An input that is chosen.
#[derive(Clone, Debug)]
pub(crate) struct InputLimits {
    pub(crate) name: String,
    pub(crate) range: [f64; 2],
    /// Limits of its rate, per second.
    pub(crate) rate: Option<[f64; 2]>,
    /// Its value before the start.
    pub(crate) rest: f64,
}

/// Inputs, columns, and times of an experiment.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    /// Units and labels of the first model.
    pub(crate) quantities: Quantities,
    pub(crate) inputs: Vec<InputLimits>,
    /// Limits of states, which hold for every model that has the state.
    pub(crate) states: Vec<Limit>,
    pub(crate) columns: Vec<String>,
    /// Times of the samples, from 0.
    pub(crate) times: Vec<f64>,
    pub(crate) sample: f64,
    /// Samples at which the pieces of the inputs start, and the last sample.
    pub(crate) pieces: Vec<usize>,
    /// Whether an input of a model acts late. The first sample is at rest then, because tables of inputs keep their first value before their
    /// start.
    pub(crate) is_late: bool,
}

impl Setup {
    pub(crate) fn new(models: &[&System], options: &ExperimentOptions) -> Result<Self, ExperimentError> {
        models.iter().try_for_each(|m| plannable(m))?;
        let columns = chosen(models, &options.measured)?;
        let inputs = inputs(models, &options.limits)?;
        let states = states(models, &inputs, &options.limits)?;
        let positive = |what: &str, value: f64| {
            let what = what.to_owned();
            let wrong = ExperimentError::Value { what, value, remedy: "give a positive time" };
            if value > 0.0 && value.is_finite() { Ok(value) } else { Err(wrong) }
        };
        let duration = positive("the duration", options.duration)?;
        let sample = positive("the sampling period", options.sample.unwrap_or(duration / SAMPLES))?;
        let count = (duration / sample).round();
        if !(2.0..=MOST_SAMPLES).contains(&count) {
            let what = "the number of samples, duration over sampling period,".to_owned();
            return Err(ExperimentError::Value { what, value: count, remedy: "give between 2 and 20000" });
        }
        let count = count as usize;
        let sample = duration / count as f64;
        let number = count.min(PIECES);
        let quantities = models.first().map(|m| m.quantities.clone()).unwrap_or_default();
        Ok(Self {
            quantities,
            inputs,
            states,
            columns,
            times: (0..=count).map(|k| k as f64 * sample).collect(),
            sample,
            pieces: (0..=number).map(|k| k * count / number).collect(),
            is_late: models.iter().any(|m| !m.input_delays.is_empty()),
        })
    }

    /// Whether inputs move along straight lines, because their rates are limited.
    pub(crate) fn is_linear(&self) -> bool {
        self.inputs.iter().any(|u| u.rate.is_some())
    }

    /// Values of the inputs before the start.
    pub(crate) fn rest(&self) -> Vec<f64> {
        self.inputs.iter().map(|u| u.rest).collect()
    }

    /// The limits of the rate of an input; from one end to the other within a sample where none are given.
    pub(crate) fn rate(&self, input: usize) -> [f64; 2] {
        let [low, high] = self.inputs[input].range;
        let fastest = (high - low) / self.sample;
        self.inputs[input].rate.unwrap_or([-fastest, fastest])
    }
}

/// The state at the start: the point of the model, else zeros.
pub(crate) fn start(system: &System) -> Vec<f64> {
    system.point_values().map_or_else(|| vec![0.0; system.states.len()], |(x, _)| x)
}

/// Whether an experiment can tell two models apart at all: models of one system that can be planned with.
///
/// # Errors
/// [`ExperimentError`] for what they do not have in common, or what cannot be planned with.
pub fn comparable(models: [&System; 2]) -> Result<(), ExperimentError> {
    models.iter().try_for_each(|m| plannable(m))?;
    same_inputs(&models)?;
    columns(&models).map(|_| ())
}

fn plannable(system: &System) -> Result<(), ExperimentError> {
    let model = system.name.clone();
    if let Some(d) = system.input_derivatives.first() {
        return Err(ExperimentError::Derivatives { model, input: system.input_names()[d.input].clone() });
    }
    if let Some(kind) = system.declares_time() {
        return Err(ExperimentError::Time { model, kind });
    }
    if system.period.is_some() {
        return Err(ExperimentError::Kind { model, what: "discrete time" });
    }
    if !system.algebraic.is_empty() {
        return Err(ExperimentError::Kind { model, what: "an algebraic variable" });
    }
    Ok(())
}

/// What is measured of a model: its outputs, else its states.
fn measured(system: &System) -> Vec<String> {
    if system.outputs.is_empty() {
        return system.state_names();
    }
    system.outputs.iter().map(|o| o.0.clone()).collect()
}

/// Whether a model has an output or state of a name.
fn has(system: &System, name: &str) -> bool {
    system.outputs.iter().any(|o| o.0 == name) || system.state_index(name).is_some()
}

/// The columns that all models have. A state that one of them lacks is one that no column shows; an output is not.
fn columns(models: &[&System]) -> Result<Vec<String>, ExperimentError> {
    for model in models {
        if let Some((column, _)) = model.outputs.iter().find(|o| !models.iter().all(|m| has(m, &o.0))) {
            return Err(ExperimentError::DifferentColumns { column: column.clone() });
        }
    }
    // Where one model has outputs, its states are not measured.
    let with_outputs = models.iter().find(|m| !m.outputs.is_empty());
    let listed = with_outputs.or(models.first()).map(|m| measured(m)).unwrap_or_default();
    let common: Vec<String> = listed.into_iter().filter(|c| models.iter().all(|m| has(m, c))).collect();
    if common.is_empty() { Err(ExperimentError::NoColumns) } else { Ok(common) }
}

/// The columns that were asked for, else those that all models have.
fn chosen(models: &[&System], measured: &[String]) -> Result<Vec<String>, ExperimentError> {
    if measured.is_empty() {
        return columns(models);
    }
    let outputs = models[0].outputs.iter().map(|o| o.0.clone());
    let known: Vec<String> = outputs.chain(models[0].state_names()).collect();
    match measured.iter().find(|c| !models.iter().all(|m| has(m, c))) {
        Some(name) => Err(unknown("--measure", name, "an output or state of every model", &known)),
        None => Ok(measured.to_vec()),
    }
}

/// The error of a name that is not known.
pub(crate) fn unknown(option: &'static str, name: &str, what: &'static str, known: &[String]) -> ExperimentError {
    let remedy = match closest_name(name, known.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}`?"),
        None if known.is_empty() => "there are none".to_owned(),
        None => format!("there are {}", known.join(", ")),
    };
    ExperimentError::UnknownName { option, name: name.to_owned(), what, remedy }
}

fn interval(limit: &Limit) -> Result<[f64; 2], ExperimentError> {
    if limit.low < limit.high && limit.low.is_finite() && limit.high.is_finite() {
        return Ok([limit.low, limit.high]);
    }
    let what = format!("the width of the limits of `{}`", limit.name);
    Err(ExperimentError::Value { what, value: limit.high - limit.low, remedy: "give LOW..HIGH with LOW below HIGH" })
}

fn same_inputs(models: &[&System]) -> Result<(), ExperimentError> {
    let names = models[0].input_names();
    for model in &models[1..] {
        let (mut a, mut b) = (names.clone(), model.input_names());
        a.sort();
        b.sort();
        if a != b {
            return Err(ExperimentError::DifferentInputs { a: names, b: model.input_names() });
        }
    }
    Ok(())
}

fn inputs(models: &[&System], limits: &[Limit]) -> Result<Vec<InputLimits>, ExperimentError> {
    let names = models[0].input_names();
    if names.is_empty() {
        return Err(ExperimentError::NoInputs);
    }
    same_inputs(models)?;
    let of = |name: &str| limits.iter().find(|l| l.name == name).map(interval).transpose();
    let at_rest = models[0].point_values().map_or_else(|| vec![0.0; names.len()], |(_, u)| u);
    let limited = names.iter().zip(at_rest).enumerate().map(|(j, (name, rest))| {
        let own = models[0].range_of_input(j);
        let range = match of(name)? {
            Some(range) => range,
            None => own.map_or([f64::NEG_INFINITY, f64::INFINITY], |(low, high)| [low, high]),
        };
        if !range.iter().all(|v| v.is_finite()) {
            return Err(ExperimentError::NoLimits { input: name.clone() });
        }
        let [low, high] = range;
        if !(low..=high).contains(&rest) {
            return Err(ExperimentError::StartOutside { name: name.clone(), value: rest, low, high });
        }
        Ok(InputLimits { name: name.clone(), range, rate: of(&format!("der({name})"))?, rest })
    });
    limited.collect()
}

fn states(models: &[&System], inputs: &[InputLimits], limits: &[Limit]) -> Result<Vec<Limit>, ExperimentError> {
    let rates: Vec<String> = inputs.iter().map(|u| format!("der({})", u.name)).collect();
    let is_input = |name: &String| inputs.iter().any(|u| u.name == *name) || rates.contains(name);
    let mut states = Vec::new();
    for limit in limits.iter().filter(|l| !is_input(&l.name)) {
        let [low, high] = interval(limit)?;
        let mut found = false;
        for model in models {
            let Some(i) = model.state_index(&limit.name) else { continue };
            found = true;
            let value = start(model)[i];
            if !(low..=high).contains(&value) {
                return Err(ExperimentError::StartOutside { name: limit.name.clone(), value, low, high });
            }
        }
        if !found {
            let known: Vec<String> =
                models[0].input_names().into_iter().chain(rates).chain(models[0].state_names()).collect();
            return Err(unknown("--limits", &limit.name, "an input, a rate of an input, or a state", &known));
        }
        states.push(limit.clone());
    }
    Ok(states)
}
