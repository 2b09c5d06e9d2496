//! Numbers within plausible limits: what lies beyond was most likely written in another unit.

use toml::Spanned;

use crate::document::{Document, FileError, Table, Value};

/// Values that a number can have.
pub struct Plausible {
    low: f64,
    high: f64,
    unit: &'static str,
    remedy: &'static str,
}

impl Plausible {
    /// From `low` to `high` in `unit`; `remedy` says what to do about others.
    pub const fn new(low: f64, high: f64, unit: &'static str, remedy: &'static str) -> Self {
        Self { low, high, unit, remedy }
    }

    /// What to do about a number beyond.
    pub fn remedy(&self) -> &'static str {
        self.remedy
    }
}

impl Document {
    /// A located number within limits.
    ///
    /// # Errors
    /// If it is no finite number, or lies beyond.
    pub fn plausible(&self, value: &Spanned<Value<'_>>, key: &str, range: &Plausible) -> Result<f64, FileError> {
        let number = self.exact_number(value, key)?.to_f64().value();
        if !(range.low..=range.high).contains(&number) {
            let message = format!("`{key}` is {number}, not between {} and {} {}", range.low, range.high, range.unit);
            return Err(self.error(value.span(), message, range.remedy));
        }
        Ok(number)
    }

    /// The number under `key` within limits, if there is one.
    ///
    /// # Errors
    /// As [`Self::plausible`].
    pub fn plausible_number(&self, table: &Table<'_>, key: &str, range: &Plausible) -> Result<Option<f64>, FileError> {
        table.get(key).map(|value| self.plausible(value, key, range)).transpose()
    }

    /// The list of `N` numbers under `key`, each within limits, if there is one.
    ///
    /// # Errors
    /// If it is no such list, and as [`Self::plausible`].
    pub fn plausible_numbers<const N: usize>(
        &self,
        table: &Table<'_>,
        key: &str,
        range: &Plausible,
    ) -> Result<Option<[f64; N]>, FileError> {
        let Some(value) = table.get(key) else { return Ok(None) };
        let wrong = || {
            let message = format!("`{key}` must be a list of {N} numbers ({})", range.unit);
            self.error(value.span(), message, format!("write {key} = [{}]", ["0.0"; N].join(", ")))
        };
        let Value::Array(entries) = value.get_ref() else { return Err(wrong()) };
        if entries.len() != N {
            return Err(wrong());
        }
        let mut numbers = [0.0; N];
        for (number, entry) in numbers.iter_mut().zip(entries) {
            *number = self.plausible(entry, key, range)?;
        }
        Ok(Some(numbers))
    }
}
