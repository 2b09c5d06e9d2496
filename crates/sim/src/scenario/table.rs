//! Inputs from a table of samples (CSV).

use super::setup::{SampledScenario, Scenario, initial_state};
use crate::model::{Hold, InputError, Inputs, Samples};
use bracketry_system::{Columns, Document, Entries, FileError, System};
use std::collections::BTreeSet;
use std::path::Path;

/// Inputs read from a table.
pub(super) struct InputTable {
    pub(super) inputs: Inputs,
    pub(super) ignored: Vec<String>,
    pub(super) times: Vec<f64>,
}

impl Scenario {
    /// Inputs from a CSV table: a header, `t` in seconds increasing, one column per input by name; columns `der(X,2)`
    /// give derivatives. The initial state is the model's `[point]`, else zero.
    ///
    /// # Errors
    /// [`FileError`] with line and column of what is wrong.
    pub fn from_csv(path: &Path, system: &System, hold: Hold) -> Result<SampledScenario, FileError> {
        let doc = Columns::document(path, "name a CSV file: a table with a column t and one per input")?;
        system.leaves_time_free(&doc)?;
        let InputTable { inputs, ignored, times } = input_table(&doc, system, hold)?;
        let (start, end) = (times[0], times[times.len() - 1]);
        if end <= start {
            return Err(doc.missing("the table has fewer than two rows", "give at least two samples"));
        }
        let sample = system.period.unwrap_or((end - start) / (times.len() - 1) as f64);
        let x0 = initial_state(system);
        let scenario = Scenario { x0, inputs, end, start, sample, parameters: Vec::new() };
        let held_at_zero = scenario.inputs_at_zero(system);
        Ok(SampledScenario { scenario, ignored, held_at_zero })
    }
}

/// The inputs of a table.
pub(super) fn input_table(doc: &Document, system: &System, hold: Hold) -> Result<InputTable, FileError> {
    let Columns { columns, lines, header, .. } = Columns::parse(doc, |_| Entries::Finite)?;
    let Some(times) = columns.get("t") else {
        let message = format!("there is no column `t`; the columns are {}", header.join(", "));
        return Err(doc.missing(message, "add a column t with the time, or rename the time column to t"));
    };
    let mut inputs = Inputs::new();
    let mut ignored = Vec::new();
    let names = system.input_names();
    let used =
        |input: &str, order: u32| system.input_derivatives.iter().any(|d| names[d.input] == input && d.order == order);
    let mut given = BTreeSet::new();
    for (name, values) in &columns {
        if name == "t" {
            continue;
        }
        let samples = Samples::new(times.clone(), values.clone(), hold).map_err(|e| match e {
            InputError::BadSamples { row, problem } => {
                let line = lines.get(row).copied().unwrap_or(0);
                let place = Columns::place(doc, &header, line, "t");
                let remedy = "sort the rows by time and remove repeated ones";
                doc.error(place, format!("line {line}: {problem}"), remedy)
            }
            other => doc.missing(other.to_string(), "correct the table"),
        })?;
        match Columns::derivative_name(name) {
            Some((input, order)) if used(input, order) => {
                if !given.insert((input, order)) {
                    let message = format!("two columns define der({input},{order})");
                    return Err(doc.missing(message, "remove one of them"));
                }
                inputs = inputs.derivative(input, order, samples);
            }
            None if names.contains(name) => {
                given.insert((name, 0));
                inputs = inputs.samples(name, samples);
            }
            _ => ignored.push(name.clone()),
        }
    }
    if given.is_empty() && !names.is_empty() {
        let derivatives = system.input_derivatives.iter().map(|d| format!("der({},{})", names[d.input], d.order));
        let known: Vec<String> = names.iter().cloned().chain(derivatives).collect();
        let remedy = format!("name the columns after the inputs: {}", known.join(", "));
        let message = format!("no column has the name of an input of the model; the columns are {}", header.join(", "));
        return Err(doc.missing(message, remedy));
    }
    Ok(InputTable { inputs, ignored, times: times.clone() })
}
