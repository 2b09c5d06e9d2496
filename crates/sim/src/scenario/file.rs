//! Scenario files.

use super::discrete::{for_signals, is_multiple};
use super::setup::{Scenario, initial_state};
use super::table::input_table;
use crate::model::{Hold, InputError, Inputs, Model};
use bracketry_symbolic::{ParseError, Rational};
use bracketry_system::{Columns, Constants, Document, FileError, System, Table, Value};
use std::path::Path;

/// Most rows of a result.
const MAX_ROWS: f64 = 5e6;

/// What inputs of a scenario may be.
const IN_TIME: &str = "inputs are expressions in t and the model's parameters";

impl Scenario {
    /// Reads a scenario file: `duration` and optionally `sample` in seconds, tables `[x0]` (numbers, or expressions of numbers
    /// such as `"pi/2"`, by state; what is absent is taken from the model's `[point]`, else 0), `[inputs]` (expressions in `t`
    /// by input), `[samples]` (a CSV table of inputs beside the scenario, with its hold) and `[parameters]`.
    ///
    /// # Errors
    /// [`FileError`] with place and remedy.
    pub fn read(path: &Path, system: &System) -> Result<Scenario, FileError> {
        Self::from_document(&Document::read(path)?, system, path.parent().unwrap_or(Path::new("")))
    }

    /// [`Scenario::read`] from text; `file` is how errors call it.
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn parse(file: &str, text: &str, system: &System) -> Result<Scenario, FileError> {
        Self::from_document(&Document::new(file, text), system, Path::new(file).parent().unwrap_or(Path::new("")))
    }

    /// `folder` is where tables of samples are looked for.
    fn from_document(doc: &Document, system: &System, folder: &Path) -> Result<Scenario, FileError> {
        system.leaves_time_free(doc)?;
        let table = doc.table()?;
        doc.only_keys(&table, &["duration", "sample", "x0", "inputs", "samples", "parameters"], "a scenario file")?;
        let positive = |key: &str| -> Result<Option<f64>, FileError> {
            match (doc.number(&table, key)?, table.get(key)) {
                (Some(v), Some(at)) if v <= 0.0 => Err(doc.error(
                    at.span(),
                    format!("`{key}` must be positive"),
                    "write a time, in seconds unless the model states another time_unit",
                )),
                (v, _) => Ok(v),
            }
        };
        let Some(end) = positive("duration")? else {
            return Err(doc.missing("the scenario has no duration", "add `duration = 5.0` (seconds)"));
        };
        let sample = positive("sample")?;
        for (key, value) in [("duration", Some(end)), ("sample", sample)] {
            let (Some(period), Some(value), Some(at)) = (system.period, value, table.get(key)) else { continue };
            if !is_multiple(value, period) {
                let message = format!("`{key}` is not a multiple of the model's period {period} (discrete time)");
                let steps = (value / period).round().max(1.0);
                return Err(doc.error(at.span(), message, format!("write {key} = {}, for example", steps * period)));
            }
        }
        let sample = sample.unwrap_or(system.period.unwrap_or(end / 1000.0));
        if end / sample > MAX_ROWS {
            return Err(doc.missing(format!("more than {MAX_ROWS:.0} rows would be written"), "enlarge `sample`"));
        }
        let x0 = read_start(doc, &table, system)?;
        let sampled = read_samples(doc, &table, system, folder)?;
        let inputs = read_inputs(doc, &table, system, sampled)?;
        let parameters = read_parameters(doc, &table, system)?;
        Ok(Scenario { x0, inputs, end, start: 0.0, sample, parameters })
    }
}

/// Refuses keys of the table `what` that are no `names`.
fn only(doc: &Document, table: &Table<'_>, names: &[String], what: &str) -> Result<(), FileError> {
    doc.only_keys(table, &names.iter().map(String::as_str).collect::<Vec<_>>(), &format!("[{what}] of this model"))
}

fn read_start(doc: &Document, table: &Table<'_>, system: &System) -> Result<Vec<f64>, FileError> {
    let mut x0 = initial_state(system);
    let Some(t) = doc.sub_table(table, "x0")? else { return Ok(x0) };
    only(doc, t, &system.state_names(), "x0")?;
    let mut system = system.clone();
    for (key, v) in t {
        let key: &str = key.get_ref();
        let Some(i) = system.state_index(key) else { continue };
        // A number, or an expression of numbers such as "pi/2".
        let e = doc.expression(v, key, &mut system.pool, &mut Constants)?;
        x0[i] = system.value(e).filter(|v| v.is_finite()).ok_or_else(|| {
            doc.error(v.span(), format!("`{key}` is not a finite number"), "write a number such as 0.3 or \"pi/2\"")
        })?;
    }
    Ok(x0)
}

/// Inputs from the table that `[samples]` names.
fn read_samples(doc: &Document, table: &Table<'_>, system: &System, folder: &Path) -> Result<Inputs, FileError> {
    let Some(t) = doc.sub_table(table, "samples")? else { return Ok(Inputs::new()) };
    doc.only_keys(t, &["file", "hold"], "[samples]")?;
    let Some(name) = doc.string(t, "file")? else {
        return Err(doc.missing("[samples] names no table", "add file = \"inputs.csv\": columns t and inputs"));
    };
    let hold = Hold::read(doc, t)?;
    let samples = Columns::document(&folder.join(name), "name a CSV file: a table with a column t and one per input")?;
    Ok(input_table(&samples, system, hold)?.inputs)
}

fn read_inputs(doc: &Document, table: &Table<'_>, system: &System, sampled: Inputs) -> Result<Inputs, FileError> {
    let mut inputs = sampled;
    let Some(t) = doc.sub_table(table, "inputs")? else { return Ok(inputs) };
    only(doc, t, &system.input_names(), "inputs")?;
    for (key, value) in t {
        let name: &str = key.get_ref();
        if inputs.mentions(name) {
            let remedy = "remove it here, or its column from the table of [samples]";
            return Err(doc.error(key.span(), format!("`{name}` is given twice, here and by [samples]"), remedy));
        }
        let text = match value.get_ref() {
            Value::String(s) => s.to_string(),
            _ => doc.exact_number(value, name)?.to_f64().value().to_string(),
        };
        inputs = inputs.expression(name, &text);
        // Asked one by one so that the error can name the line.
        Model::new(&for_signals(system), &Inputs::new().expression(name, &text)).map_err(|e| match e {
            InputError::Expression { source, .. } => doc.parse_error(value, in_time(system, source)),
            other => doc.error(value.span(), other.to_string(), IN_TIME),
        })?;
    }
    Ok(inputs)
}

fn read_parameters(doc: &Document, table: &Table<'_>, system: &System) -> Result<Vec<(String, Rational)>, FileError> {
    let mut parameters = Vec::new();
    let Some(t) = doc.sub_table(table, "parameters")? else { return Ok(parameters) };
    let known: Vec<String> = system.parameters.iter().map(|p| system.symbol_name(p.symbol).to_owned()).collect();
    only(doc, t, &known, "parameters")?;
    for (key, value) in t {
        let (name, number) = (key.get_ref(), doc.exact_number(value, key.get_ref())?);
        let outside = system.parameters.iter().find(|p| {
            system.symbol_name(p.symbol) == *name
                && (p.min.as_ref().is_some_and(|m| number < *m) || p.max.as_ref().is_some_and(|m| number > *m))
        });
        if let Some(p) = outside {
            let bound = |b: &Option<Rational>| b.as_ref().map_or("…".to_owned(), |b| b.to_f64().value().to_string());
            return Err(doc.error(
                value.span(),
                format!("parameter `{name}` lies outside its min…max of the model"),
                format!("correct the value, or the bounds {} to {} in the model file", bound(&p.min), bound(&p.max)),
            ));
        }
        parameters.push((name.to_string(), number));
    }
    Ok(parameters)
}

/// An error in an expression of time, with the names that it may use.
fn in_time(system: &System, mut e: ParseError) -> ParseError {
    if e.message.starts_with("unknown name") && !e.remedy.starts_with("did you mean") {
        let names: Vec<&str> = system.parameters.iter().map(|p| system.symbol_name(p.symbol)).collect();
        e.remedy = if names.is_empty() { IN_TIME.to_owned() } else { format!("{IN_TIME}: {}", names.join(", ")) };
    }
    e
}
