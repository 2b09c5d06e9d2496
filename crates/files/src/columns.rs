//! Tables of samples as text (CSV): a header, then rows of numbers.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use crate::document::{Document, FileError};
use crate::unit::Unit;

/// Tables larger than this are refused.
const MAX_BYTES: u64 = 512 << 20;

/// What stands for a lost value, in lower case.
const LOST: [&str; 7] = ["", "nan", "na", "n/a", "null", "inf", "-inf"];

/// What the entries of a column may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {
    /// Every entry is a finite number.
    Finite,
    /// A finite number, or lost: empty, `nan`, `na`, `n/a`, `null` or infinite, which is read as NaN.
    MayBeLost,
    /// The column is not read.
    Ignored,
}

/// The columns of a table by name, and the line of each row.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// The columns that were read, all of the same length, at least 1.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// Names of all columns, in the order of the file.
    pub header: Vec<String>,
    /// The line of each row, from 1.
    pub lines: Vec<u64>,
    /// Units by column, where a row of units stands below the header.
    pub units: BTreeMap<String, String>,
}

impl Columns {
    /// Reads the text of a table; `what` says what to name where the path is no file.
    ///
    /// # Errors
    /// [`FileError`] if the file cannot be read, is larger than 512 MiB or is not UTF-8.
    pub fn document(path: &Path, what: &str) -> Result<Document, FileError> {
        Document::read_up_to(path, MAX_BYTES, what, "give fewer samples, or split the table")
    }

    /// Reads a table with a header. Lines that begin with `#` are comments; a comma between parentheses, as in `der(X,2)`,
    /// is part of the name. `entries` says of each column what may stand in it.
    ///
    /// # Errors
    /// [`FileError`] with line and column for what is no table, for entries that `entries` does not admit, for two columns of
    /// one name, and if there is no row.
    pub fn parse(doc: &Document, entries: impl Fn(&str) -> Entries) -> Result<Self, FileError> {
        Self::read(doc, entries, false)
    }

    /// As [`Columns::parse`]; a row of units, such as `s,N,mm` or `[s],[N],[mm]`, may stand below the header.
    ///
    /// # Errors
    /// As [`Columns::parse`].
    pub fn parse_with_units(doc: &Document, entries: impl Fn(&str) -> Entries) -> Result<Self, FileError> {
        Self::read(doc, entries, true)
    }

    fn read(doc: &Document, entries: impl Fn(&str) -> Entries, may_state_units: bool) -> Result<Self, FileError> {
        let (before, header, after) = split_header(doc.text());
        let header = quote_parentheses(header);
        let text = [before, &header, after].concat();
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
        let header = reader
            .headers()
            .map_err(|e| doc.missing(format!("the header cannot be read: {e}"), "start the table with column names"))?;
        let header: Vec<String> = header.iter().map(str::to_owned).collect();
        check_header(doc, &header, after)?;
        let entries: Vec<Entries> = header.iter().map(|name| entries(name)).collect();
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); header.len()];
        let mut lines = Vec::new();
        let mut units = BTreeMap::new();
        for record in reader.records() {
            let line = |p: &csv::Position| p.line() + skipped_lines(&text, p.byte());
            let record = record.map_err(|e| unreadable(doc, &e, line))?;
            let line = record.position().map_or(0, line);
            if let Some(row) = Some(&record).filter(|_| may_state_units && lines.is_empty()).and_then(units_of) {
                let stated = header.iter().cloned().zip(row).filter(|(_, unit)| !unit.is_empty());
                units.extend(stated);
                continue;
            }
            lines.push(line);
            for (k, field) in record.iter().enumerate() {
                match (entries[k], field.parse::<f64>()) {
                    (Entries::Ignored, _) => {}
                    (_, Ok(v)) if v.is_finite() => columns[k].push(v),
                    (Entries::MayBeLost, _) if LOST.contains(&field.to_ascii_lowercase().as_str()) => {
                        columns[k].push(f64::NAN);
                    }
                    (kind, _) => return Err(not_a_number(doc, &header, line, k, field, kind)),
                }
            }
        }
        if lines.is_empty() && header.iter().any(|name| name.contains(['\n', '\r'])) {
            let message = "a quotation mark in the header is not closed";
            return Err(doc.missing(message, "close it, or remove it: t,u,x"));
        }
        if lines.is_empty() {
            return Err(doc.missing("the table has no rows", "give at least two samples"));
        }
        let read = header.iter().cloned().zip(columns).zip(&entries);
        let columns = read.filter(|(_, kind)| **kind != Entries::Ignored).map(|(column, _)| column).collect();
        Ok(Self { columns, header, lines, units })
    }

    /// Byte range of an entry in the text of the table, for [`Document::error`]: that of the line where the column is not in the
    /// header or quotes keep entries from being counted.
    pub fn place(doc: &Document, header: &[String], line: u64, column: &str) -> Range<usize> {
        let whole = line_span(doc.text(), line);
        let row = &doc.text()[whole.clone()];
        let position = header.iter().position(|name| name == column).filter(|_| !row.contains('"'));
        let Some(entry) = position.and_then(|k| row.split(',').nth(k)) else { return whole };
        // Both are parts of one text.
        let start = whole.start + (entry.as_ptr() as usize - row.as_ptr() as usize);
        let blank = entry.len() - entry.trim_start().len();
        start + blank..start + blank + entry.trim().len()
    }

    /// `der(X,2)` → (`X`, 2), `der(X)` → (`X`, 1): the input and the order that a column is called after.
    pub fn derivative_name(name: &str) -> Option<(&str, u32)> {
        let inner = name.strip_prefix("der(")?.strip_suffix(')')?;
        match inner.split_once(',') {
            None => Some((inner.trim(), 1)),
            Some((input, order)) => Some((input.trim(), order.trim().parse().ok()?)),
        }
    }
}

/// The units of a row that has nothing but units, in brackets or not, some of which may be missing.
fn units_of(record: &csv::StringRecord) -> Option<Vec<String>> {
    let bare = |entry: &str| entry.trim_matches(['[', ']', '(', ')']).trim().to_owned();
    let row: Vec<String> = record.iter().map(bare).collect();
    let is_number = |entry: &String| entry.parse::<f64>().is_ok() && entry != "1";
    let are_units = row.iter().all(|entry| !is_number(entry) && (entry.is_empty() || Unit::parse(entry).is_some()));
    (are_units && row.iter().any(|entry| entry.chars().any(char::is_alphabetic))).then_some(row)
}

/// What separates the columns of a table whose header, seen as one column, is `only`, if it is no comma.
fn other_separator(only: &str, rows: &str) -> Option<&'static str> {
    let first = rows.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or("");
    let number = |entry: &str| entry.replace(',', ".").parse::<f64>().is_ok();
    let blanks = || {
        let names = only.split_whitespace().count();
        names > 1 && first.split_whitespace().count() == names && first.split_whitespace().all(number)
    };
    match only {
        _ if only.contains(';') => Some("semicolons"),
        _ if only.contains('\t') => Some("tabs"),
        _ if blanks() => Some("blanks"),
        _ if only.contains('|') => Some("bars"),
        _ => None,
    }
}

/// Byte range of a line, from 1, without its end.
fn line_span(text: &str, line: u64) -> Range<usize> {
    let mut start = 0;
    for (k, part) in text.split_inclusive('\n').enumerate() {
        let end = start + part.trim_end_matches(['\n', '\r']).len();
        if k as u64 + 1 == line {
            return start..end;
        }
        start += part.len();
    }
    text.len()..text.len()
}

/// Number of empty lines and comments between the end of the row before, at a byte of the text, and the row that follows.
fn skipped_lines(text: &str, byte: u64) -> u64 {
    let rest = text.get(byte as usize..).unwrap_or("");
    rest.split('\n').take_while(|line| line.starts_with('#') || line.trim_end_matches('\r').is_empty()).count() as u64
}

/// Whether these can be names of columns; the rows are the text `after` them.
fn check_header(doc: &Document, header: &[String], after: &str) -> Result<(), FileError> {
    if header.iter().all(String::is_empty) {
        let message = "the table is empty: there is no header and no row";
        return Err(doc.missing(message, "start with a header such as t,u,x, and give a row of numbers per sample"));
    }
    if let [only] = header
        && let Some(what) = other_separator(only, after)
    {
        let message = format!("the columns are separated by {what}");
        return Err(doc.missing(message, "separate them by commas, and write decimal points: 0.5, not 0,5"));
    }
    if header.iter().all(|name| name.parse::<f64>().is_ok()) {
        let end = doc.text().len() - after.len();
        let start = doc.text()[..end].rfind('\n').map_or(0, |i| i + 1);
        let message = "the first line contains numbers instead of column names";
        return Err(doc.error(start..end, message, "start with a header such as t,u,x"));
    }
    for (k, name) in header.iter().enumerate() {
        if header[..k].contains(name) {
            return Err(doc.missing(format!("two columns are called `{name}`"), "rename one of them"));
        }
    }
    Ok(())
}

/// The error for a row that the reader of tables refuses; `line` gives the line of a position.
fn unreadable(doc: &Document, e: &csv::Error, line: impl Fn(&csv::Position) -> u64) -> FileError {
    let remedy = "give every row as many entries as the header";
    let csv::ErrorKind::UnequalLengths { pos: Some(pos), expected_len, len } = e.kind() else {
        return doc.missing(e.to_string(), remedy);
    };
    let line = line(pos);
    let entries = |n: u64| if n == 1 { "1 entry".to_owned() } else { format!("{n} entries") };
    let message = format!("line {line} has {}, the header {}", entries(*len), entries(*expected_len));
    let remedy = if *len == 2 * *expected_len {
        "give every row as many entries as the header; decimals are written with a point: 0.5, not 0,5"
    } else {
        remedy
    };
    doc.error(line_span(doc.text(), line), message, remedy)
}

/// The error for an entry of column `k` that is not a finite number.
fn not_a_number(doc: &Document, header: &[String], line: u64, k: usize, field: &str, kind: Entries) -> FileError {
    let column = match header[k].as_str() {
        "" => format!("column {} (without a name)", k + 1),
        name => format!("column `{name}`"),
    };
    let message = match field {
        "" => format!("line {line}, {column}: the entry is empty"),
        field => format!("line {line}, {column}: `{field}` is not a finite number"),
    };
    let remedy = match kind {
        _ if header[k].is_empty() => "name the column, or remove the comma at the end of the lines",
        Entries::MayBeLost => "correct the entry; leave a missing value empty or write nan",
        _ => "correct or remove the row",
    };
    doc.error(Columns::place(doc, header, line, &header[k]), message, remedy)
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
