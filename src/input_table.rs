//! Inputs from a table of samples (CSV).

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::Path;

use bracketry_sim::{Hold, InputError, Inputs, Samples};
use bracketry_system::{Document, FileError, System};

use crate::Scenario;
use crate::scenario::initial_state;

/// Tables larger than this are refused.
const MAX_BYTES: u64 = 512 << 20;

/// A [`Scenario`] from a table, and what the table did not say.
#[derive(Clone, Debug)]
pub struct SampledScenario {
    /// The scenario.
    pub scenario: Scenario,
    /// Columns that are no input, nor a derivative of one that the model uses.
    pub ignored: Vec<String>,
    /// Inputs without any column: they and their derivatives are zero.
    pub held_at_zero: Vec<String>,
}

impl Scenario {
    /// Inputs from a CSV table: a header, `t` in seconds increasing, one column per input by name; columns `der(X,2)`
    /// give derivatives. The initial state is the model's `[point]`, else zero.
    ///
    /// # Errors
    /// [`FileError`] with line and column of what is wrong.
    pub fn from_csv(path: &Path, system: &System, hold: Hold) -> Result<SampledScenario, FileError> {
        let doc = read(path, "name a CSV file: a table with a column t and one per input")?;
        doc.time_is_free(system)?;
        let Table { columns, lines } = read_table(&doc)?;
        let Some(times) = columns.get("t") else {
            return Err(doc.missing("there is no column `t`", "add a column t with the time in seconds"));
        };
        let mut inputs = Inputs::new();
        let mut ignored = Vec::new();
        let names = system.input_names();
        let used = |input: &str, order: u32| {
            system.input_derivatives.iter().any(|d| names[d.input] == input && d.order == order)
        };
        let mut given = BTreeSet::new();
        for (name, values) in &columns {
            if name == "t" {
                continue;
            }
            let samples = Samples::new(times.clone(), values.clone(), hold).map_err(|e| match e {
                InputError::BadSamples { row, problem } => {
                    let line = lines.get(row).copied().unwrap_or(0);
                    doc.missing(format!("line {line}: column `{name}`: {problem}"), "correct the table")
                }
                other => doc.missing(other.to_string(), "correct the table"),
            })?;
            match derivative_column(name) {
                Some((input, order)) if used(input, order) => {
                    if !given.insert((input, order)) {
                        let message = format!("two columns give der({input},{order})");
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
            return Err(doc.missing("no column is called like an input of the model", remedy));
        }
        let (start, end) = (times[0], times[times.len() - 1]);
        if end <= start {
            return Err(doc.missing("the table has fewer than two rows", "give at least two samples"));
        }
        let sample = (end - start) / (times.len() - 1) as f64;
        let x0 = initial_state(system);
        let scenario = Scenario { x0, inputs, end, start, sample, parameters: Vec::new() };
        let held_at_zero = scenario.inputs_at_zero(system);
        Ok(SampledScenario { scenario, ignored, held_at_zero })
    }
}

/// Reads the text of a table; `what` says what to name where the path is no file.
pub(crate) fn read(path: &Path, what: &str) -> Result<Document, FileError> {
    let name = path.display().to_string();
    let whole = |message: String, remedy: &str| Document::new(name.clone(), "").missing(message, remedy);
    let meta = std::fs::metadata(path).map_err(|e| whole(format!("cannot be read: {e}"), "check the path"))?;
    if !meta.is_file() {
        return Err(whole("is not a file".into(), what));
    }
    if meta.len() > MAX_BYTES {
        let message = format!("is larger than {} MiB", MAX_BYTES >> 20);
        return Err(whole(message, "give fewer samples, or simulate the table in parts"));
    }
    let bytes = std::fs::read(path).map_err(|e| whole(format!("cannot be read: {e}"), "check the permissions"))?;
    let text =
        String::from_utf8(bytes).map_err(|_| whole("is not UTF-8 text".into(), "save it with UTF-8 encoding"))?;
    Ok(Document::new(name, text))
}

/// `der(X,2)` → (`X`, 2)
fn derivative_column(name: &str) -> Option<(&str, u32)> {
    let inner = name.strip_prefix("der(")?.strip_suffix(')')?;
    match inner.split_once(',') {
        None => Some((inner.trim(), 1)),
        Some((input, order)) => Some((input.trim(), order.trim().parse().ok()?)),
    }
}

/// The columns of a table by name, every entry a finite number, and the line of each row.
pub(crate) struct Table {
    pub(crate) columns: BTreeMap<String, Vec<f64>>,
    pub(crate) lines: Vec<u64>,
}

/// Reads a table with a header.
pub(crate) fn read_table(doc: &Document) -> Result<Table, FileError> {
    let (before, header, after) = split_header(doc.text());
    let header = quote_parentheses(header);
    let text = before.as_bytes().chain(header.as_bytes()).chain(after.as_bytes());
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text);
    let header = reader
        .headers()
        .map_err(|e| doc.missing(format!("the header cannot be read: {e}"), "start the table with column names"))?
        .clone();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); header.len()];
    let mut lines = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| doc.missing(e.to_string(), "give every row as many entries as the header"))?;
        let line = record.position().map_or(0, csv::Position::line);
        lines.push(line);
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
    Ok(Table { columns: out, lines })
}

/// The text before the line of the header, that line, and the rest.
fn split_header(text: &str) -> (&str, &str, &str) {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let end = start + line.trim_end_matches(['\n', '\r']).len();
        if end > start && !line.starts_with('#') {
            return (&text[..start], &text[start..end], &text[end..]);
        }
        start += line.len();
    }
    (text, "", "")
}

/// The header with names trimmed, and quotes around those in which a comma stands between parentheses, as in `der(X,2)`.
fn quote_parentheses(header: &str) -> String {
    let mut fields = vec![String::new()];
    let (mut quoted, mut depth) = (false, 0usize);
    for c in header.chars() {
        match c {
            '"' => quoted = !quoted,
            '(' if !quoted => depth += 1,
            ')' if !quoted => depth = depth.saturating_sub(1),
            ',' if !quoted && depth == 0 => {
                fields.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(field) = fields.last_mut() {
            field.push(c);
        }
    }
    if quoted || depth > 0 {
        return header.to_owned();
    }
    let quote = |field: &String| {
        let name = field.trim();
        if name.contains(',') && !name.contains('"') { format!("\"{name}\"") } else { name.to_owned() }
    };
    fields.iter().map(quote).collect::<Vec<_>>().join(",")
}
