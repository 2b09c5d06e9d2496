//! Quantities that are known over time: expressions, or columns of tables.

use super::reader::{Located, Parsed, Reader};
use crate::problem::Scheduled;
use bracketry_sim::{Hold, Samples};
use bracketry_system::{Columns, Entries, Table, Value};

impl Reader<'_> {
    /// An expression of time, or `{ file, column, hold }`, as a quantity that is finite at the grid points 0 … `points`.
    pub(super) fn over_run(&self, v: Located<'_, '_>, name: &str, points: usize, dt: f64) -> Parsed<Scheduled> {
        if let Value::Table(t) = v.get_ref() {
            return self.column(t, v, name);
        }
        let value = self.over_time(v, name, true)?;
        if let Some(k) = (0..=points).find(|k| !value(*k as f64 * dt).is_finite()) {
            let message = format!("`{name}` is not finite at t = {}", k as f64 * dt);
            return Err(self.doc.error(v.span(), message, "write an expression that is finite").into());
        }
        let constant = self.constant(v, name).is_ok();
        Ok(if constant { Scheduled::constant(name, value(0.0)) } else { Scheduled::new(name, value) })
    }

    /// The value at the start of a quantity that is known over time.
    pub(super) fn at_start(&self, v: Located<'_, '_>, name: &str) -> Parsed<f64> {
        match v.get_ref() {
            Value::Table(t) => Ok(self.column(t, v, name)?.at(0.0)),
            _ => Ok(self.over_time(v, name, true)?(0.0)),
        }
    }

    /// A column of a CSV table. Before the first row and after the last one it keeps the value there.
    fn column(&self, t: &Table<'_>, v: Located<'_, '_>, name: &str) -> Parsed<Scheduled> {
        let remedy = format!("write {name} = {{ file = \"table.csv\", column = \"{name}\", hold = \"linear\" }}");
        self.doc.only_keys(t, &["file", "column", "hold"], &format!("`{name}`"))?;
        let Some(file) = self.doc.string(t, "file")? else {
            return Err(self.doc.error(v.span(), format!("`{name}` names no table"), remedy).into());
        };
        let column = self.doc.string(t, "column")?.unwrap_or_else(|| name.to_owned());
        let hold = Hold::read(self.doc, t)?;
        let doc = Columns::document(&self.folder.join(file), "name a CSV file: a table with a column t")?;
        let Columns { columns, .. } = Columns::parse(&doc, |_| Entries::Finite)?;
        let Some(times) = columns.get("t") else {
            return Err(doc.missing("there is no column `t`", "add a column t with the time in seconds").into());
        };
        let Some(values) = columns.get(column.as_str()) else {
            let known: Vec<&str> = columns.keys().map(String::as_str).collect();
            let remedy = format!("its columns are {}; name one with `column`", known.join(", "));
            return Err(doc.missing(format!("there is no column `{column}`"), remedy).into());
        };
        let samples = Samples::new(times.clone(), values.clone(), hold)
            .map_err(|e| doc.missing(e.to_string(), "sort the rows by time and remove repeated ones"))?;
        let last = times.last().copied();
        Ok(Scheduled::new(name, move |t| samples.at(t)).until(last))
    }
}
