//! TOML documents whose errors name file, line, column, the offending text and the remedy.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;
use std::path::Path;

use bracketry_symbolic::{Expr, Names, ParseError, Pool, Rational, closest_name};
use toml::de::{DeTable, DeValue};

/// Something wrong in a file, with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file as it was named.
    pub file: String,
    /// Line from 1; 0 where no place in the file is meant.
    pub line: usize,
    /// Column in characters from 1.
    pub column: usize,
    /// The offending text.
    pub found: String,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
    /// The whole source line.
    pub source_line: String,
}

/// Most characters of the offending text, of its line, and of what is said of it: names may be as long as a file.
const MOST_FOUND: usize = 80;
const MOST_SHOWN: usize = 200;
const MOST_SAID: usize = 1000;

/// The first characters of a text, with an ellipsis where there are more.
fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
        None => Cow::Borrowed(text),
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line == 0 {
            return write!(f, "{}: {}\n   = {}", self.file, self.message, self.remedy);
        }
        let message = shortened(&self.message, MOST_SAID);
        write!(f, "{}:{}:{}: {message}", self.file, self.line, self.column)?;
        if !self.found.is_empty() {
            write!(f, " (near `{}`)", shortened(&self.found, MOST_FOUND))?;
        }
        let width = self.found.chars().take(MOST_SHOWN).count().max(1);
        let shown: String = self.source_line.chars().take(MOST_SHOWN).collect();
        if self.column <= MOST_SHOWN {
            let blank = " ".repeat(self.column - 1);
            let marks = "^".repeat(width);
            write!(f, "\n   | {shown}\n   | {blank}{marks}")?;
        }
        write!(f, "\n   = {}", shortened(&self.remedy, MOST_SAID))
    }
}

impl std::error::Error for FileError {}

/// Text of a TOML file with the name under which errors speak of it.
pub struct Document {
    file: String,
    text: String,
}

/// A table of a [`Document`], with its place.
pub type Table<'i> = DeTable<'i>;
/// A value of a [`Document`].
pub type Value<'i> = DeValue<'i>;

/// Files larger than this are refused.
const MAX_BYTES: u64 = 16 << 20;

impl Document {
    /// A document from text.
    pub fn new(file: impl Into<String>, text: impl Into<String>) -> Self {
        Document { file: file.into(), text: text.into() }
    }

    /// Reads a TOML file.
    ///
    /// # Errors
    /// If it cannot be read, is too large or is not UTF-8.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::read_up_to(path, MAX_BYTES, "name a TOML file", "is this really a TOML file?")
    }

    /// Reads a text of at most `max_bytes`; `no_file` and `too_large` say what to do about a path that is no such file.
    ///
    /// # Errors
    /// If it cannot be read, is too large or is not UTF-8.
    pub fn read_up_to(path: &Path, max_bytes: u64, no_file: &str, too_large: &str) -> Result<Self, FileError> {
        let whole = |message: String, remedy: &str| Self::new(path.display().to_string(), "").missing(message, remedy);
        let meta = std::fs::metadata(path).map_err(|e| whole(format!("cannot be read: {e}"), "check the path"))?;
        if !meta.is_file() {
            return Err(whole("is not a file".into(), no_file));
        }
        if meta.len() > max_bytes {
            return Err(whole(format!("is larger than {} MiB", max_bytes >> 20), too_large));
        }
        let bytes = std::fs::read(path).map_err(|e| whole(format!("cannot be read: {e}"), "check the permissions"))?;
        let not_text = if bytes.contains(&0) { no_file } else { "save it with UTF-8 encoding" };
        let text = String::from_utf8(bytes).map_err(|_| whole("is not UTF-8 text".into(), not_text))?;
        Ok(Self::new(path.display().to_string(), text))
    }

    /// The name of the file.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The document as a located table.
    ///
    /// # Errors
    /// A syntax error of TOML, with its place.
    pub fn table(&self) -> Result<Table<'_>, FileError> {
        DeTable::parse(&self.text).map(toml::Spanned::into_inner).map_err(|e| {
            let span = e.span().unwrap_or(0..0);
            let message = e.message().trim().replace('\n', ", ");
            let remedy = syntax_remedy(&message);
            self.error(span, message, remedy)
        })
    }

    /// An error at a byte range of the text.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>, remedy: impl Into<String>) -> FileError {
        let start = self.boundary(span.start);
        let end = self.boundary(span.end).max(start);
        let before = &self.text[..start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let source_line = self.text[line_start..].lines().next().unwrap_or("").to_owned();
        let found = self.text[start..end].lines().next().unwrap_or("").to_owned();
        FileError {
            file: self.file.clone(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            found,
            message: message.into(),
            remedy: remedy.into(),
            source_line,
        }
    }

    fn boundary(&self, at: usize) -> usize {
        let mut i = at.min(self.text.len());
        while !self.text.is_char_boundary(i) {
            i -= 1;
        }
        i
    }

    /// An error that concerns the document as a whole (something is missing).
    pub fn missing(&self, message: impl Into<String>, remedy: impl Into<String>) -> FileError {
        FileError {
            file: self.file.clone(),
            line: 0,
            column: 0,
            found: String::new(),
            message: message.into(),
            remedy: remedy.into(),
            source_line: String::new(),
        }
    }

    /// Refuses keys that are not in `known`.
    ///
    /// # Errors
    /// The first unknown key, with a suggestion.
    pub fn only_keys(&self, table: &Table<'_>, known: &[&str], what: &str) -> Result<(), FileError> {
        for key in table.keys() {
            let name: &str = key.get_ref();
            if !known.contains(&name) {
                let remedy = match closest_name(name, known.iter().copied()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("{what} accepts: {}", known.join(", ")),
                };
                return Err(self.error(key.span(), format!("unknown key `{name}` in {what}"), remedy));
            }
        }
        Ok(())
    }

    /// The table under `key`, if there is one.
    ///
    /// # Errors
    /// If the value is not a table.
    pub fn sub_table<'a, 'i>(&self, table: &'a Table<'i>, key: &str) -> Result<Option<&'a Table<'i>>, FileError> {
        match table.get(key) {
            None => Ok(None),
            Some(v) => match v.get_ref() {
                DeValue::Table(t) => Ok(Some(t)),
                other => Err(self.error(
                    v.span(),
                    format!("`{key}` must be a table, not {}", article(other)),
                    format!("write [{key}] on its own line, with its entries below"),
                )),
            },
        }
    }

    /// The string under `key`, if there is one.
    ///
    /// # Errors
    /// If the value is not a string.
    pub fn string(&self, table: &Table<'_>, key: &str) -> Result<Option<String>, FileError> {
        match table.get(key) {
            None => Ok(None),
            Some(v) => match v.get_ref() {
                DeValue::String(s) => Ok(Some(s.to_string())),
                other => Err(self.error(
                    v.span(),
                    format!("`{key}` must be text, not {}", article(other)),
                    "put it in quotes",
                )),
            },
        }
    }

    /// The number under `key` as a float, if there is one.
    ///
    /// # Errors
    /// If the value is not a finite number.
    pub fn number(&self, table: &Table<'_>, key: &str) -> Result<Option<f64>, FileError> {
        match table.get(key) {
            None => Ok(None),
            Some(v) => self.exact_number(v, key).map(|r| Some(r.to_f64().value())),
        }
    }

    /// A located value as an exact rational.
    ///
    /// # Errors
    /// If it is not a finite number.
    pub fn exact_number(&self, v: &toml::Spanned<Value<'_>>, key: &str) -> Result<Rational, FileError> {
        let text = match v.get_ref() {
            DeValue::Integer(i) if i.radix() == 10 => i.as_str().replace('_', ""),
            DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix())
                .map(|n| n.to_string())
                .map_err(|_| self.error(v.span(), "the integer is too large", "write it as a decimal number"))?,
            DeValue::Float(x) => x.as_str().replace('_', ""),
            other => {
                return Err(self.error(
                    v.span(),
                    format!("`{key}` must be a number, not {}", article(other)),
                    "write a number without quotes",
                ));
            }
        };
        if text.contains("nan") || text.contains("inf") {
            return Err(self.error(v.span(), format!("`{key}` is not a finite number"), "write a finite number"));
        }
        let mut pool = Pool::new();
        let e = pool.parse(&text).map_err(|e| self.error(v.span(), e.message, e.remedy))?;
        pool.number(e)
            .cloned()
            .ok_or_else(|| self.error(v.span(), format!("`{key}` must be a number"), "write a number without quotes"))
    }

    /// The expression in a located value: text in quotes, or a plain number.
    ///
    /// # Errors
    /// If it is neither, or the text is not an expression over `names`.
    pub fn expression<N: Names>(
        &self,
        v: &toml::Spanned<Value<'_>>,
        key: &str,
        pool: &mut Pool,
        names: &mut N,
    ) -> Result<Expr, FileError> {
        match v.get_ref() {
            DeValue::String(s) => pool.parse_with(s, names).map_err(|e| self.parse_error(v, e)),
            DeValue::Integer(_) | DeValue::Float(_) => {
                let r = self.exact_number(v, key)?;
                Ok(pool.rational(r))
            }
            other => Err(self.error(
                v.span(),
                format!("`{key}` must be an expression, not {}", article(other)),
                "put the expression in quotes",
            )),
        }
    }

    /// An error within the text of a located value.
    pub fn parse_error(&self, v: &toml::Spanned<Value<'_>>, e: ParseError) -> FileError {
        let span = match v.get_ref() {
            DeValue::String(s) => self.inside(&v.span(), s, e.offset, &e.found),
            _ => v.span(),
        };
        self.error(span, e.message, e.remedy)
    }

    /// Byte range of a part of a string value, exact where the string was written without escapes.
    fn inside(&self, span: &Range<usize>, value: &str, offset: usize, found: &str) -> Range<usize> {
        let raw = &self.text[span.clone()];
        let quotes = if raw.starts_with("\"\"\"") || raw.starts_with("'''") { 3 } else { 1 };
        let skip = match raw.get(quotes..) {
            Some(r) if r.starts_with(value) => quotes,
            Some(r) if r.starts_with('\n') && r[1..].starts_with(value) => quotes + 1,
            _ => return span.clone(),
        };
        let byte = |chars: usize| value.char_indices().nth(chars).map_or(value.len(), |(i, _)| i);
        let start = span.start + skip + byte(offset);
        let length = if value[byte(offset)..].starts_with(found) { found.len() } else { 0 };
        start..start + length
    }
}

/// What to do about a syntax error of TOML.
fn syntax_remedy(message: &str) -> &'static str {
    let says = |part: &str| message.contains(part);
    if says("duplicate key") {
        "a name may occur only once in its table: remove or rename one of them"
    } else if says("array") {
        "write a list as [\"x\", \"v\"]: commas between its entries, `]` at its end"
    } else if says("invalid basic string") || says("invalid literal string") {
        "close the quotes on the same line"
    } else if says("invalid mantissa") {
        "write digits before and after the point: 0.01"
    } else if says("unclosed table") || says("invalid unquoted key") {
        "names of keys and tables consist of letters, digits, _, and -: [dynamics]"
    } else if says("inline table") {
        "write a table on one line as { min = 0, max = 1 }, or as [name] with its entries on lines below"
    } else {
        "correct the TOML syntax; expressions must be in quotes: x = \"u*cos(th)\""
    }
}

fn article(v: &Value<'_>) -> String {
    match v {
        DeValue::String(_) => "text".into(),
        DeValue::Integer(_) | DeValue::Float(_) => "a number".into(),
        DeValue::Boolean(_) => "true or false".into(),
        DeValue::Datetime(_) => "a date".into(),
        DeValue::Array(_) => "a list".into(),
        DeValue::Table(_) => "a table".into(),
    }
}
