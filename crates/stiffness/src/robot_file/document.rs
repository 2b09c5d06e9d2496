//! TOML documents whose errors name file, line, column, the offending text and the remedy.

use std::fmt;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Something wrong in a robot file, with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotFileError {
    /// The file as it was named.
    pub file: String,
    /// Line from 1; 0 where no place in the file is meant.
    pub line: usize,
    /// Column in characters from 1.
    pub column: usize,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
    /// The whole source line.
    pub source_line: String,
}

impl fmt::Display for RobotFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line == 0 {
            return write!(f, "{}: {}\n   = {}", self.file, self.message, self.remedy);
        }
        let shown: String = self.source_line.chars().take(200).collect();
        write!(f, "{}:{}:{}: {}\n   | {shown}", self.file, self.line, self.column, self.message)?;
        if self.column <= 200 {
            write!(f, "\n   | {}^", " ".repeat(self.column - 1))?;
        }
        write!(f, "\n   = {}", self.remedy)
    }
}

impl std::error::Error for RobotFileError {}

/// Files larger than this are refused.
const MOST_BYTES: u64 = 16 << 20;

/// Text of a TOML file with the name under which errors speak of it.
pub(crate) struct Document<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
}

/// A table of a document with its place.
pub(crate) type Table<'i> = DeTable<'i>;
/// A value of a document with its place.
pub(crate) type Located<'i> = Spanned<DeValue<'i>>;

/// Reads a text file.
pub(crate) fn read_text(path: &Path) -> Result<String, RobotFileError> {
    let file = path.display().to_string();
    let whole = |message: String, remedy: &str| Document { file: &file, text: "" }.whole(message, remedy);
    let meta = std::fs::metadata(path).map_err(|e| whole(format!("cannot be read: {e}"), "check the path"))?;
    if !meta.is_file() {
        return Err(whole("is not a file".into(), "name a file"));
    }
    if meta.len() > MOST_BYTES {
        return Err(whole(
            format!("is larger than {} MiB", MOST_BYTES >> 20),
            "is this really the description of a robot?",
        ));
    }
    let bytes = std::fs::read(path).map_err(|e| whole(format!("cannot be read: {e}"), "check the permissions"))?;
    String::from_utf8(bytes).map_err(|_| whole("is not UTF-8 text".into(), "save it with UTF-8 encoding"))
}

impl<'a> Document<'a> {
    pub(crate) fn table(&self) -> Result<Table<'a>, RobotFileError> {
        DeTable::parse(self.text).map(Spanned::into_inner).map_err(|e| {
            let message = e.message().trim().replace('\n', ", ");
            self.at(e.span().unwrap_or(0..0), message, "correct the TOML syntax")
        })
    }

    /// An error at a place.
    pub(crate) fn at(
        &self,
        span: Range<usize>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> RobotFileError {
        let mut start = span.start.min(self.text.len());
        while !self.text.is_char_boundary(start) {
            start -= 1;
        }
        let before = &self.text[..start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        RobotFileError {
            file: self.file.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            message: message.into(),
            remedy: remedy.into(),
            source_line: self.text[line_start..].lines().next().unwrap_or("").to_owned(),
        }
    }

    /// An error of the document as a whole.
    pub(crate) fn whole(&self, message: impl Into<String>, remedy: impl Into<String>) -> RobotFileError {
        RobotFileError {
            file: self.file.to_owned(),
            line: 0,
            column: 0,
            message: message.into(),
            remedy: remedy.into(),
            source_line: String::new(),
        }
    }

    pub(crate) fn only_keys(&self, table: &Table<'_>, known: &[&str], what: &str) -> Result<(), RobotFileError> {
        match table.keys().find(|key| !known.contains(&key.get_ref().as_ref())) {
            None => Ok(()),
            Some(key) => Err(self.at(
                key.span(),
                format!("unknown key `{}` in {what}", key.get_ref()),
                format!("{what} knows: {}", known.join(", ")),
            )),
        }
    }

    pub(crate) fn text(&self, table: &Table<'_>, key: &str) -> Result<Option<String>, RobotFileError> {
        let Some(value) = table.get(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::String(s) => Ok(Some(s.to_string())),
            _ => Err(self.at(value.span(), format!("`{key}` must be text"), "put it in quotes")),
        }
    }

    pub(crate) fn sub_table<'t, 'i>(
        &self,
        table: &'t Table<'i>,
        key: &str,
    ) -> Result<Option<&'t Table<'i>>, RobotFileError> {
        let Some(value) = table.get(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::Table(t) => Ok(Some(t)),
            _ => Err(self.at(
                value.span(),
                format!("`{key}` must be a table"),
                format!("write [{key}] on a line of its own, its entries below"),
            )),
        }
    }

    /// A number within a range, in words what it is otherwise.
    pub(crate) fn number(&self, value: &Located<'_>, key: &str, range: &Plausible) -> Result<f64, RobotFileError> {
        let text = match value.get_ref() {
            DeValue::Integer(i) if i.radix() == 10 => i.as_str().replace('_', ""),
            DeValue::Float(x) => x.as_str().replace('_', ""),
            _ => {
                return Err(self.at(
                    value.span(),
                    format!("`{key}` must be a number"),
                    "write a number without quotes",
                ));
            }
        };
        let number: f64 = text.parse().unwrap_or(f64::NAN);
        if !number.is_finite() {
            return Err(self.at(value.span(), format!("`{key}` is not a finite number"), "write a finite number"));
        }
        if !(range.low..=range.high).contains(&number) {
            let message = format!("`{key}` is {number}, not between {} and {} {}", range.low, range.high, range.unit);
            return Err(self.at(value.span(), message, range.remedy));
        }
        Ok(number)
    }

    pub(crate) fn optional(
        &self,
        table: &Table<'_>,
        key: &str,
        range: &Plausible,
    ) -> Result<Option<f64>, RobotFileError> {
        table.get(key).map(|value| self.number(value, key, range)).transpose()
    }

    /// A list of as many numbers as asked for.
    pub(crate) fn numbers<const N: usize>(
        &self,
        table: &Table<'_>,
        key: &str,
        range: &Plausible,
    ) -> Result<Option<[f64; N]>, RobotFileError> {
        let Some(value) = table.get(key) else { return Ok(None) };
        let wrong = || {
            let message = format!("`{key}` must be a list of {N} numbers ({})", range.unit);
            self.at(value.span(), message, format!("write {key} = [{}]", ["0.0"; N].join(", ")))
        };
        let DeValue::Array(entries) = value.get_ref() else { return Err(wrong()) };
        if entries.len() != N {
            return Err(wrong());
        }
        let mut numbers = [0.0; N];
        for (number, entry) in numbers.iter_mut().zip(entries) {
            *number = self.number(entry, key, range)?;
        }
        Ok(Some(numbers))
    }
}

/// Values that a number can have.
pub(crate) struct Plausible {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) unit: &'static str,
    pub(crate) remedy: &'static str,
}

impl Plausible {
    pub(crate) const fn new(low: f64, high: f64, unit: &'static str, remedy: &'static str) -> Self {
        Self { low, high, unit, remedy }
    }
}
