//! Columns of text below each other.

use std::fmt;

/// Rows of cells; the first row is the header.
#[derive(Default)]
pub(super) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    pub(super) fn new<S: Into<String>>(header: impl IntoIterator<Item = S>) -> Self {
        Self { rows: vec![header.into_iter().map(Into::into).collect()] }
    }

    pub(super) fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

impl fmt::Display for Table {
    /// Every column as wide as its widest cell, indented by two; one line per row.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |c: usize| self.rows.iter().filter_map(|r| r.get(c)).map(|t| t.chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for row in &self.rows {
            let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
            writeln!(f, "  {}", cells.collect::<Vec<_>>().join("  ").trim_end())?;
        }
        Ok(())
    }
}

/// `value` with three significant digits.
pub(super) fn short(value: f64) -> String {
    significant(value, 3)
}

/// `value` with so many significant digits.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let exponent = value.abs().log10().floor() as i32;
    if (-4..6).contains(&exponent) {
        let decimals = (digits - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        let decimals = (digits - 1).max(0) as usize;
        format!("{value:.decimals$e}")
    }
}

/// `value` with as many digits as its standard deviation `std` makes worthwhile: two of `std`.
pub fn measured(value: f64, std: f64) -> String {
    if !(std > 0.0 && std.is_finite()) || value == 0.0 {
        return significant(value, 4);
    }
    let digits = (value.abs().log10().floor() - std.log10().floor()) as i32 + 2;
    significant(value, digits.clamp(2, 9))
}

/// A share as per cent.
pub(super) fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

/// `= p`, or a bound where the number means nothing any more.
pub fn probability(p: f64) -> String {
    if p < 1e-12 { "< 1e-12".to_owned() } else { format!("= {}", significant(p, 2)) }
}
