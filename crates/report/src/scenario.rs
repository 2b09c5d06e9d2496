//! What a simulation is given, from a scenario file, and what it gives.

use std::path::Path;

use bracketry_sim::{InputError, Inputs, Model, Outcome, Settings, SimError, Simulation, simulate};
use bracketry_symbolic::{ParseError, Rational};
use bracketry_system::{Document, FileError, System, Value, ZeroDenominator};

use crate::Breakdown;
use crate::point::Constants;

/// A simulation to run: where it starts, what drives it, how long.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Initial state, in the order of the model.
    pub x0: Vec<f64>,
    /// What drives the inputs; inputs that are not mentioned are zero.
    pub inputs: Inputs,
    /// End time in seconds; the simulation starts at `start`.
    pub end: f64,
    /// Start time in seconds.
    pub start: f64,
    /// Distance in seconds between the rows of the result.
    pub sample: f64,
    /// Parameter values that replace those of the model.
    pub parameters: Vec<(String, Rational)>,
}

/// A simulation that cannot be set up.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// The inputs do not fit the model.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The integrator was misused.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The equations divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] ZeroDenominator),
}

/// Most rows of a result.
const MAX_ROWS: f64 = 5e6;

impl Scenario {
    /// Reads a scenario file: `duration` and optionally `sample` in seconds, tables `[x0]` (numbers, or expressions of numbers such as `"pi/2"`, by state; what
    /// is absent is taken from the model's `[point]`, else 0), `[inputs]` (expressions in `t` by input) and
    /// `[parameters]`.
    ///
    /// # Errors
    /// [`FileError`] with place and remedy.
    pub fn read(path: &Path, system: &System) -> Result<Scenario, FileError> {
        Self::from_document(&Document::read(path)?, system)
    }

    /// [`Scenario::read`] from text; `file` is how errors call it.
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn parse(file: &str, text: &str, system: &System) -> Result<Scenario, FileError> {
        Self::from_document(&Document::new(file, text), system)
    }

    fn from_document(doc: &Document, system: &System) -> Result<Scenario, FileError> {
        system.leaves_time_free(doc)?;
        let table = doc.table()?;
        doc.only_keys(&table, &["duration", "sample", "x0", "inputs", "parameters"], "a scenario file")?;
        let positive = |key: &str| -> Result<Option<f64>, FileError> {
            match (doc.number(&table, key)?, table.get(key)) {
                (Some(v), Some(at)) if v <= 0.0 => {
                    Err(doc.error(at.span(), format!("`{key}` must be positive"), "write a time in seconds"))
                }
                (v, _) => Ok(v),
            }
        };
        let Some(end) = positive("duration")? else {
            return Err(doc.missing("the scenario has no duration", "add `duration = 5.0` (seconds)"));
        };
        let sample = positive("sample")?.unwrap_or(end / 1000.0);
        if end / sample > MAX_ROWS {
            return Err(doc.missing(format!("more than {MAX_ROWS:.0} rows would be written"), "enlarge `sample`"));
        }
        let mut x0 = initial_state(system);
        if let Some(t) = doc.sub_table(&table, "x0")? {
            let known: Vec<String> = system.state_names();
            doc.only_keys(t, &known.iter().map(String::as_str).collect::<Vec<_>>(), "[x0] of this model")?;
            for (key, v) in t {
                if let Some(i) = system.state_index(key.get_ref()) {
                    x0[i] = constant(doc, system, v, key.get_ref())?;
                }
            }
        }
        let mut inputs = Inputs::new();
        if let Some(t) = doc.sub_table(&table, "inputs")? {
            let known = system.input_names();
            doc.only_keys(t, &known.iter().map(String::as_str).collect::<Vec<_>>(), "[inputs] of this model")?;
            for (key, value) in t {
                let name: &str = key.get_ref();
                let text = match value.get_ref() {
                    Value::String(s) => s.to_string(),
                    _ => doc.exact_number(value, name)?.to_f64().value().to_string(),
                };
                inputs = inputs.expression(name, &text);
                // Asked one by one so that the error can name the line.
                Model::new(system, &Inputs::new().expression(name, &text)).map_err(|e| match e {
                    InputError::Expression { source, .. } => doc.parse_error(value, in_time(system, source)),
                    other => doc.error(value.span(), other.to_string(), IN_TIME),
                })?;
            }
        }
        let mut parameters = Vec::new();
        if let Some(t) = doc.sub_table(&table, "parameters")? {
            let known: Vec<&str> = system.parameters.iter().map(|p| system.symbol_name(p.symbol)).collect();
            doc.only_keys(t, &known, "[parameters] of this model")?;
            for (key, value) in t {
                let (name, number) = (key.get_ref(), doc.exact_number(value, key.get_ref())?);
                if let Some(p) = system.parameters.iter().find(|p| system.symbol_name(p.symbol) == *name)
                    && (p.min.as_ref().is_some_and(|m| number < *m) || p.max.as_ref().is_some_and(|m| number > *m))
                {
                    let bound =
                        |b: &Option<Rational>| b.as_ref().map_or("…".to_owned(), |b| b.to_f64().value().to_string());
                    return Err(doc.error(
                        value.span(),
                        format!("parameter `{name}` lies outside its min…max of the model"),
                        format!(
                            "correct the value, or the bounds {} to {} in the model file",
                            bound(&p.min),
                            bound(&p.max)
                        ),
                    ));
                }
                parameters.push((name.to_string(), number));
            }
        }
        Ok(Scenario { x0, inputs, end, start: 0.0, sample, parameters })
    }

    /// The inputs that nothing drives: they and their derivatives are zero.
    pub fn inputs_at_zero(&self, system: &System) -> Vec<String> {
        system.input_names().into_iter().filter(|name| !self.inputs.mentions(name)).collect()
    }

    /// Integrates `system` with exact stick–slip friction.
    ///
    /// # Errors
    /// If inputs and system do not fit. Blow-up and chattering are outcomes, not errors.
    pub fn run(&self, system: &System, settings: &Settings) -> Result<Run, ScenarioError> {
        let mut system = system.clone();
        for (name, value) in &self.parameters {
            system.set_parameter(name, value.clone());
        }
        system.check_denominators()?;
        let mut model = Model::new(&system, &self.inputs)?;
        let switches: Vec<String> = model.switch_names().map(str::to_owned).collect();
        let Simulation { trajectory, outcome, statistics } =
            simulate(model.clone(), self.start, &self.x0, self.end, settings)?;
        let end = match &outcome {
            Outcome::Finished => self.end,
            Outcome::Stopped { t, .. } => *t,
        };
        let count = ((end - self.start) / self.sample + 1e-9).floor() as usize;
        let mut times: Vec<f64> = (0..=count).map(|i| self.start + i as f64 * self.sample).collect();
        if end - times[count] > 1e-9 * self.sample {
            times.push(end);
        }
        let states: Vec<Vec<f64>> = times.iter().map(|&t| trajectory.sample(t)).collect();
        let outputs = times.iter().zip(&states).map(|(&t, x)| model.output_values(t, x)).collect();
        let unknown: Vec<bool> = system.input_names().iter().map(|n| self.inputs.only_derivatives(n)).collect();
        // As they are commanded: the record of a run, given back as inputs, has to give the same run.
        let mut commands = system.clone();
        commands.input_delays.clear();
        let mut commands = Model::new(&commands, &self.inputs)?;
        let inputs = times
            .iter()
            .map(|&t| {
                let values = commands.input_values(t);
                values.into_iter().zip(&unknown).map(|(v, &unknown)| if unknown { f64::NAN } else { v }).collect()
            })
            .collect();
        let impulses_left_out = model.impulses_left_out().to_vec();
        let breakdown = match &outcome {
            Outcome::Stopped { reason, t, state } => Breakdown::find(&system, &model, reason, *t, state),
            Outcome::Finished => None,
        };
        Ok(Run {
            times,
            states,
            inputs,
            outputs,
            switches,
            trajectory,
            outcome,
            statistics,
            impulses_left_out,
            breakdown,
        })
    }
}

/// A simulation with samples at regular times.
#[derive(Clone, Debug)]
pub struct Run {
    /// Sample times in seconds.
    pub times: Vec<f64>,
    /// States at these times.
    pub states: Vec<Vec<f64>>,
    /// Inputs at these times, as they are commanded, before the delays of the model; not a number where only derivatives of an input are given.
    pub inputs: Vec<Vec<f64>>,
    /// Outputs of the model at these times, with `sign(0) = 0`.
    pub outputs: Vec<Vec<f64>>,
    /// Printed switching functions.
    pub switches: Vec<String>,
    /// Dense output and transitions.
    pub trajectory: bracketry_sim::Trajectory,
    /// How it ended.
    pub outcome: Outcome,
    /// Work done.
    pub statistics: bracketry_sim::Statistics,
    /// Input derivatives, by input and order, whose impulses are left out because the input's expression jumps or has
    /// kinks: what the model would do there is not simulated.
    pub impulses_left_out: Vec<(String, u32)>,
    /// What the equations do where the simulation stopped before its end, as far as that was found.
    pub breakdown: Option<Breakdown>,
}

/// What inputs of a scenario may be.
const IN_TIME: &str = "inputs are expressions in t and the model's parameters";

/// An error in an expression of time, with the names that it may use.
fn in_time(system: &System, mut e: ParseError) -> ParseError {
    if e.message.starts_with("unknown name") && !e.remedy.starts_with("did you mean") {
        let names: Vec<&str> = system.parameters.iter().map(|p| system.symbol_name(p.symbol)).collect();
        e.remedy = if names.is_empty() { IN_TIME.to_owned() } else { format!("{IN_TIME}: {}", names.join(", ")) };
    }
    e
}

/// A number, or an expression of numbers such as "pi/2".
fn constant(doc: &Document, system: &System, v: &toml::Spanned<Value<'_>>, key: &str) -> Result<f64, FileError> {
    let mut system = system.clone();
    let e = doc.expression(v, key, &mut system.pool, &mut Constants)?;
    system.value(e).filter(|v| v.is_finite()).ok_or_else(|| {
        doc.error(v.span(), format!("`{key}` is not a finite number"), "write a number such as 0.3 or \"pi/2\"")
    })
}

/// The model's point, or zeros.
pub(crate) fn initial_state(system: &System) -> Vec<f64> {
    system.point_values().map_or_else(|| vec![0.0; system.states.len()], |(x, _)| x)
}
