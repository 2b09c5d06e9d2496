//! What a simulation is given: initial state and inputs, from a scenario file or from a table of samples.

use std::collections::BTreeMap;
use std::path::Path;

use bracketry_sim::{Hold, InputError, Inputs, Model, Outcome, Samples, Settings, SimError, Simulation, simulate};
use bracketry_symbolic::Rational;
use bracketry_system::{Document, FileError, System, Value};

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
}

/// Most rows of a result.
const MAX_ROWS: f64 = 5e6;

impl Scenario {
    /// Reads a scenario file: `duration` and optionally `sample` in seconds, tables `[x0]` (numbers by state; what
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
            for key in t.keys() {
                if let (Some(i), Some(v)) = (system.state_index(key.get_ref()), doc.number(t, key.get_ref())?) {
                    x0[i] = v;
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
                Model::new(system, &Inputs::new().expression(name, &text)).map_err(|e| {
                    doc.error(value.span(), e.to_string(), "inputs are expressions in t and the model's parameters")
                })?;
            }
        }
        let mut parameters = Vec::new();
        if let Some(t) = doc.sub_table(&table, "parameters")? {
            let known: Vec<&str> = system.parameters.iter().map(|p| system.symbol_name(p.symbol)).collect();
            doc.only_keys(t, &known, "[parameters] of this model")?;
            for (key, value) in t {
                parameters.push((key.get_ref().to_string(), doc.exact_number(value, key.get_ref())?));
            }
        }
        Ok(Scenario { x0, inputs, end, start: 0.0, sample, parameters })
    }

    /// Inputs from a CSV table: a header, `t` in seconds increasing, one column per input by name; columns
    /// `der(X,2)` give derivatives. Columns that are no input are returned as ignored.
    ///
    /// # Errors
    /// [`FileError`] with line and column of what is wrong.
    pub fn from_csv(path: &Path, system: &System, hold: Hold) -> Result<(Scenario, Vec<String>), FileError> {
        let doc = Document::read(path)?;
        let columns = read_columns(&doc)?;
        let Some(times) = columns.get("t").cloned() else {
            return Err(doc.missing("there is no column `t`", "add a column t with the time in seconds"));
        };
        let mut inputs = Inputs::new();
        let mut ignored = Vec::new();
        let names = system.input_names();
        let mut found = 0;
        for (name, values) in &columns {
            if name == "t" {
                continue;
            }
            let samples = Samples::new(times.clone(), values.clone(), hold).map_err(|e| match e {
                InputError::BadSamples { row, problem } => {
                    doc.missing(format!("line {}: column `{name}`: {problem}", row + 2), "correct the table")
                }
                other => doc.missing(other.to_string(), "correct the table"),
            })?;
            match derivative_column(name) {
                Some((input, order)) if names.iter().any(|n| n == input) => {
                    inputs = inputs.derivative(input, order, samples);
                    found += 1;
                }
                None if names.contains(name) => {
                    inputs = inputs.samples(name, samples);
                    found += 1;
                }
                _ => ignored.push(name.clone()),
            }
        }
        if found == 0 && !names.is_empty() {
            let remedy = format!("name the columns after the inputs: {}", names.join(", "));
            return Err(doc.missing("no column is called like an input of the model", remedy));
        }
        let (start, end) = (times[0], times[times.len() - 1]);
        if end <= start {
            return Err(doc.missing("the table has fewer than two rows", "give at least two samples"));
        }
        let sample = (end - start) / (times.len() - 1) as f64;
        let x0 = initial_state(system);
        Ok((Scenario { x0, inputs, end, start, sample, parameters: Vec::new() }, ignored))
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
        let states = times.iter().map(|&t| trajectory.sample(t)).collect();
        let inputs = times.iter().map(|&t| model.input_values(t)).collect();
        Ok(Run { times, states, inputs, switches, trajectory, outcome, statistics })
    }
}

/// A simulation with samples at regular times.
#[derive(Clone, Debug)]
pub struct Run {
    /// Sample times in seconds.
    pub times: Vec<f64>,
    /// States at these times.
    pub states: Vec<Vec<f64>>,
    /// Inputs at these times.
    pub inputs: Vec<Vec<f64>>,
    /// Printed switching functions.
    pub switches: Vec<String>,
    /// Dense output and transitions.
    pub trajectory: bracketry_sim::Trajectory,
    /// How it ended.
    pub outcome: Outcome,
    /// Work done.
    pub statistics: bracketry_sim::Statistics,
}

/// The model's point, or zeros.
fn initial_state(system: &System) -> Vec<f64> {
    system.point_values().map_or_else(|| vec![0.0; system.states.len()], |(x, _)| x)
}

/// `der(X,2)` → (`X`, 2)
fn derivative_column(name: &str) -> Option<(&str, u32)> {
    let inner = name.strip_prefix("der(")?.strip_suffix(')')?;
    match inner.split_once(',') {
        None => Some((inner.trim(), 1)),
        Some((input, order)) => Some((input.trim(), order.trim().parse().ok()?)),
    }
}

/// The columns of a CSV table by name, every entry a finite number.
fn read_columns(doc: &Document) -> Result<BTreeMap<String, Vec<f64>>, FileError> {
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(doc.text().as_bytes());
    let header = reader
        .headers()
        .map_err(|e| doc.missing(format!("the header cannot be read: {e}"), "start the table with column names"))?
        .clone();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); header.len()];
    for record in reader.records() {
        let record = record.map_err(|e| doc.missing(e.to_string(), "give every row as many entries as the header"))?;
        let line = record.position().map_or(0, csv::Position::line);
        for (k, field) in record.iter().enumerate() {
            match field.parse::<f64>() {
                Ok(v) if v.is_finite() => columns[k].push(v),
                _ => {
                    let message = format!("line {line}, column `{}`: `{field}` is not a finite number", &header[k]);
                    return Err(doc.missing(message, "correct or remove the row"));
                }
            }
        }
    }
    if columns.iter().any(Vec::is_empty) {
        return Err(doc.missing("the table has no rows", "give at least two samples"));
    }
    let mut out = BTreeMap::new();
    for (name, values) in header.iter().zip(columns) {
        if out.insert(name.to_owned(), values).is_some() {
            return Err(doc.missing(format!("two columns are called `{name}`"), "rename one of them"));
        }
    }
    Ok(out)
}
