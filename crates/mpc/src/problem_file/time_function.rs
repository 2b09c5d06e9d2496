//! Quantities that are known over time: expressions, or columns of tables.

use super::reader::{Located, Parsed, Reader};
use crate::ocp::derivative_name;
use crate::problem::Scheduled;
use bracketry_numerics::spline::NaturalSpline;
use bracketry_sim::{Hold, InputError, Samples};
use bracketry_system::{Columns, Document, Entries, Table, Value};

/// A column of a table, and how it goes on between its rows.
enum Curve {
    Sampled(Samples),
    Cubic(NaturalSpline),
}

/// The curve of a table.
struct CurveOfTable {
    curve: Curve,
    /// Number of derivatives that it has between and at its rows.
    smooth: u32,
    /// Time of its last row, s, and number of rows.
    last: Option<f64>,
    rows: usize,
}

impl Curve {
    fn derivative(&self, t: f64, order: u32) -> f64 {
        match (self, order) {
            (Self::Cubic(spline), _) => spline.derivative(t, order),
            (Self::Sampled(samples), 0) => samples.at(t),
            (Self::Sampled(samples), 1) => samples.slope_at(t),
            (Self::Sampled(_), _) => 0.0,
        }
    }
}

impl Reader<'_> {
    /// An expression of time, or `{ file, column, hold }`, as a quantity that is finite at the grid points 0 … `points`.
    pub(super) fn over_run(&self, v: Located<'_, '_>, name: &str, points: usize, dt: f64) -> Parsed<Scheduled> {
        self.derivative_over_run(v, name, 0, points, dt)
    }

    /// The derivative of such a quantity, 0 for itself; with its own derivatives where the scale of time is free.
    pub(super) fn derivative_over_run(
        &self,
        v: Located<'_, '_>,
        name: &str,
        order: u32,
        points: usize,
        dt: f64,
    ) -> Parsed<Scheduled> {
        let at = |order| self.one_over_run(v, name, order, points, dt);
        if self.free.is_none_or(|free| free.end_time.is_none()) {
            return at(order);
        }
        Ok(at(order)?.with_rates(self.rate(v, name, order + 1)?, self.rate(v, name, order + 2)?))
    }

    /// The derivative of a quantity wherever it exists; a table has none beyond those of the curve through its rows.
    fn rate(&self, v: Located<'_, '_>, name: &str, order: u32) -> Parsed<Scheduled> {
        if let Value::Table(t) = v.get_ref() {
            let CurveOfTable { curve, smooth, .. } = self.curve(t, v, name)?;
            if smooth == 0 {
                // Between two jumps there is a minimum, and rarely the best one.
                let message = format!("the table of `{name}` jumps at its rows, and the end time is free");
                let remedy = "write hold = \"linear\" or, better, hold = \"cubic\"; or fix the end time";
                return Err(self.doc.error(v.span(), message, remedy).into());
            }
            return Ok(Scheduled::new(name, move |t| curve.derivative(t, order)));
        }
        Ok(Scheduled::new(name, self.derivative_of_time(v, name, true, order)?))
    }

    fn one_over_run(&self, v: Located<'_, '_>, name: &str, order: u32, points: usize, dt: f64) -> Parsed<Scheduled> {
        if let Value::Table(t) = v.get_ref() {
            return self.column(t, v, name, order);
        }
        let value = self.derivative_over_time(v, name, true, order)?;
        let of = derivative_name(name, order);
        if let Some(k) = (0..=points).find(|k| !value(*k as f64 * dt).is_finite()) {
            let message = format!("`{of}` is not finite at t = {}", k as f64 * dt);
            return Err(self.doc.error(v.span(), message, "write an expression that is finite").into());
        }
        let constant = self.constant(v, name).is_ok();
        let scheduled = if constant { Scheduled::constant(of, value(0.0)) } else { Scheduled::new(of, value) };
        Ok(scheduled.derivative_of(name, order))
    }

    /// The value at the start of a quantity that is known over time.
    pub(super) fn at_start(&self, v: Located<'_, '_>, name: &str) -> Parsed<f64> {
        match v.get_ref() {
            Value::Table(t) => Ok(self.column(t, v, name, 0)?.at(0.0)),
            _ => Ok(self.over_time(v, name, true)?(0.0)),
        }
    }

    /// A column of a CSV table, or its derivative. Before the first row and after the last one it keeps the value there.
    fn column(&self, t: &Table<'_>, v: Located<'_, '_>, name: &str, order: u32) -> Parsed<Scheduled> {
        let CurveOfTable { curve, smooth, last, rows } = self.curve(t, v, name)?;
        if order > smooth {
            let of = derivative_name(name, order);
            let message = format!("the table of `{name}`, as it is held between its rows, has no `{of}`");
            let remedy = match order {
                1 => "write hold = \"linear\", or hold = \"cubic\" for one without jumps",
                2 => "write hold = \"cubic\"",
                _ => "no table has more than two derivatives: write an expression of t",
            };
            return Err(self.doc.error(v.span(), message, remedy).into());
        }
        let scheduled = Scheduled::new(derivative_name(name, order), move |t| curve.derivative(t, order));
        // What is to be said of the table is said of the quantity itself.
        Ok(if order == 0 { scheduled.of_table(last, rows) } else { scheduled.derivative_of(name, order) })
    }

    /// The curve through a column of a CSV table.
    fn curve(&self, t: &Table<'_>, v: Located<'_, '_>, name: &str) -> Parsed<CurveOfTable> {
        let remedy = format!("write {name} = {{ file = \"table.csv\", column = \"{name}\", hold = \"linear\" }}");
        self.doc.only_keys(t, &["file", "column", "hold"], &format!("`{name}`"))?;
        let Some(file) = self.doc.string(t, "file")? else {
            return Err(self.doc.error(v.span(), format!("`{name}` names no table"), remedy).into());
        };
        let column = self.doc.string(t, "column")?.unwrap_or_else(|| name.to_owned());
        let holds = [("previous", Some(Hold::Previous)), ("linear", Some(Hold::Linear)), ("cubic", None)];
        let hold = self.choice(t, "hold", "way to hold samples", &holds)?;
        let smooth = match hold {
            Some(Hold::Previous) => 0,
            Some(Hold::Linear) => 1,
            None => 2,
        };
        let doc = Columns::document(&self.folder.join(file), "name a CSV file: a table with a column t")?;
        let Columns { columns, header, lines, .. } = Columns::parse(&doc, |_| Entries::Finite)?;
        let Some(times) = columns.get("t") else {
            return Err(doc.missing("there is no column `t`", "add a column t with the time").into());
        };
        let Some(values) = columns.get(column.as_str()) else {
            let known: Vec<&str> = columns.keys().map(String::as_str).collect();
            let remedy = format!("its columns are {}; name one with `column`", known.join(", "));
            return Err(doc.missing(format!("there is no column `{column}`"), remedy).into());
        };
        let samples = Samples::new(times.clone(), values.clone(), hold.unwrap_or_default())
            .map_err(|e| out_of_order(&doc, &header, &lines, times, &e))?;
        let (last, rows) = (times.last().copied(), times.len());
        let curve = match hold {
            Some(_) => Curve::Sampled(samples),
            None => Curve::Cubic(NaturalSpline::new(times.clone(), values.clone())),
        };
        Ok(CurveOfTable { curve, smooth, last, rows })
    }
}

/// The error for a table whose rows are not in the order of time, at the first row that is not.
fn out_of_order(
    doc: &Document,
    header: &[String],
    lines: &[u64],
    times: &[f64],
    error: &InputError,
) -> bracketry_system::FileError {
    let remedy = "sort the rows by time and remove repeated ones";
    let row = (1..times.len()).find(|&k| times[k] <= times[k - 1]);
    let Some((row, line)) = row.and_then(|k| Some((k, *lines.get(k)?))) else {
        return doc.missing(error.to_string(), remedy);
    };
    let message = format!("the time does not increase: {} after {}", times[row], times[row - 1]);
    doc.error(Columns::place(doc, header, line, "t"), message, remedy)
}
