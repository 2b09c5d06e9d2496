//! From a table of samples to a [`Record`]: which column is what, what is wrong with it, how noisy it is.

mod audit;
mod clock;
mod consistency;
mod driving;
mod noise;
mod npz;
mod roles;
mod spline;

pub use audit::{Audit, ColumnAudit, Warning};
pub use noise::{Noise, estimate_noise};
pub use spline::{Bandwidth, SmoothingSpline, smooth};

use std::collections::BTreeMap;
use std::path::Path;

use bracketry_sim::Hold;
use bracketry_system::{Columns, Document, Entries, FileError, System};

use crate::{DiagnoseError, Measured, Record};
use clock::Clock;
use driving::Driving;
use roles::{Role, Roles};

/// Largest share of lost entries of a measured column.
const MOST_LOST: f64 = 0.5;

/// Sizes of columns whose squares, and those of their noise, are numbers.
const SIZES: std::ops::Range<f64> = 1e-100..1e100;

/// How the columns of a table are meant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordSettings {
    /// How inputs go on between samples. `None`: each value is held until the next sample; an input whose derivatives the
    /// model uses, and these, follow straight lines, since that is a motion and not a command.
    pub hold: Option<Hold>,
    /// Pairs: the name of a column, the name in the model that it gets.
    pub rename: Vec<(String, String)>,
}

impl RecordSettings {
    /// The name in the model of a column.
    fn renamed<'a>(&'a self, column: &'a str) -> &'a str {
        self.rename.iter().find(|(from, _)| from == column).map_or(column, |(_, to)| to)
    }

    /// Refuses to rename columns that are not there, and to give names that mean nothing to the model; only a column whose own
    /// name another one gets may be called anything.
    fn check(&self, origin: &Origin<'_>, header: &[String], system: &System) -> Result<(), FileError> {
        if let Some((from, _)) = self.rename.iter().find(|(from, _)| !header.contains(from)) {
            return Err(origin.whole(
                format!("there is no column `{from}` to rename; there are {}", header.join(", ")),
                "name a column of the table before the equals sign: --rename q=x",
            ));
        }
        let meaningless = |(from, to): &&(String, String)| {
            roles::role(to, system).is_none() && !self.rename.iter().any(|(_, other)| other == from)
        };
        match self.rename.iter().find(meaningless) {
            None => Ok(()),
            Some((from, to)) => Err(origin.whole(
                format!("--rename {from}={to}: the model has no `{to}`"),
                format!("give a name of the model after the equals sign: {}", roles::known(system).join(", ")),
            )),
        }
    }

    /// Gives columns their names in the model.
    fn apply(
        &self,
        origin: &Origin<'_>,
        columns: BTreeMap<String, Vec<f64>>,
    ) -> Result<BTreeMap<String, Vec<f64>>, FileError> {
        let mut out = BTreeMap::new();
        let mut before = BTreeMap::new();
        for (name, values) in columns {
            let to = self.renamed(&name).to_owned();
            if let Some(other) = before.insert(to.clone(), name.clone()) {
                let message = format!("`{other}` and `{name}` are both called `{to}`: two columns of one name");
                return Err(origin.whole(message, format!("give one of them another name: --rename {to}=other")));
            }
            out.insert(to, values);
        }
        Ok(out)
    }
}

/// Where columns come from, for messages.
struct Origin<'a> {
    name: &'a str,
    /// The text, its header and the line of each row, in a text file.
    table: Option<(&'a Document, &'a [String], &'a [u64])>,
}

impl Origin<'_> {
    fn row(&self, row: usize) -> String {
        match self.table.and_then(|(_, _, lines)| lines.get(row)) {
            Some(line) => format!("line {line}"),
            None => format!("sample {row}"),
        }
    }

    fn whole(&self, message: impl Into<String>, remedy: impl Into<String>) -> FileError {
        Document::new(self.name, "").missing(message, remedy)
    }

    fn at(&self, row: usize, column: &str, problem: &str, remedy: &str) -> FileError {
        let message = format!("{}, column `{column}`: {problem}", self.row(row));
        match self.table.and_then(|(doc, header, lines)| Some((doc, header, *lines.get(row)?))) {
            Some((doc, header, line)) => doc.error(Columns::place(doc, header, line, column), message, remedy),
            None => self.whole(message, remedy),
        }
    }
}

/// Reads a run from a table: a column `t` in seconds, one per measured state or output, one per input, `der(X,2)` for its
/// derivatives; other columns are ignored, and the [`Audit`] says so. A file `….npz` is a NumPy archive of one array per
/// column, any other text (CSV).
///
/// # Errors
/// [`DiagnoseError::File`] with file, line, column and remedy for what is no such table.
pub fn read_record(path: &Path, system: &System, settings: &RecordSettings) -> Result<(Record, Audit), DiagnoseError> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("npy")) {
        let name = path.display().to_string();
        return Err(Origin { name: &name, table: None }
            .whole(
                "is a single NumPy array, whose columns have no names",
                "write an archive of one array per column: numpy.savez('run.npz', t=…, x=…)",
            )
            .into());
    }
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("npz")) {
        let (columns, ignored) = npz::read(path, |name| roles::role(settings.renamed(name), system).is_some())?;
        let name = path.display().to_string();
        let origin = Origin { name: &name, table: None };
        let header: Vec<String> = columns.keys().cloned().chain(ignored.iter().cloned()).collect();
        settings.check(&origin, &header, system)?;
        return build(&origin, settings.apply(&origin, columns)?, ignored, system, settings);
    }
    let doc = Columns::document(path, "name a CSV file: a table with a column t, the inputs and what was measured")?;
    let entries = |name: &str| match roles::role(settings.renamed(name), system) {
        None => Entries::Ignored,
        Some(Role::Measured(_)) => Entries::MayBeLost,
        Some(_) => Entries::Finite,
    };
    let Columns { columns, header, lines } = Columns::parse(&doc, entries)?;
    let origin = Origin { name: doc.file(), table: Some((&doc, &header, &lines)) };
    settings.check(&origin, &header, system)?;
    let ignored = header.iter().filter(|name| !columns.contains_key(*name)).cloned().collect();
    build(&origin, settings.apply(&origin, columns)?, ignored, system, settings)
}

impl Record {
    /// A run from columns by name, `times` in seconds; otherwise as [`read_record`]. NaN in a measured column is a lost
    /// value.
    ///
    /// # Errors
    /// [`DiagnoseError::File`] as [`read_record`], with the index of the sample in place of the line.
    pub fn from_columns(
        name: &str,
        times: Vec<f64>,
        columns: BTreeMap<String, Vec<f64>>,
        system: &System,
        settings: &RecordSettings,
    ) -> Result<(Record, Audit), DiagnoseError> {
        let origin = Origin { name, table: None };
        for (column, values) in &columns {
            if values.len() != times.len() {
                let message = format!("column `{column}` has {} entries for {} times", values.len(), times.len());
                return Err(origin.whole(message, "give one entry per time").into());
            }
        }
        let header: Vec<String> = columns.keys().cloned().collect();
        settings.check(&origin, &header, system)?;
        let known = |column: &String| roles::role(settings.renamed(column), system).is_some();
        let (columns, others): (BTreeMap<_, _>, BTreeMap<_, _>) =
            columns.into_iter().partition(|(column, _)| known(column));
        let ignored = others.into_keys().collect();
        let mut columns = settings.apply(&origin, columns)?;
        columns.insert("t".to_owned(), times);
        build(&origin, columns, ignored, system, settings)
    }
}

/// Refuses a column that is too large or too small to be squared.
fn check_size(origin: &Origin<'_>, column: &str, values: &[f64]) -> Result<(), FileError> {
    let size = values.iter().map(|v| v.abs()).fold(0.0, f64::max);
    if size == 0.0 || SIZES.contains(&size) {
        return Ok(());
    }
    let row = values.iter().position(|v| v.abs() == size).unwrap_or(0);
    let problem = format!("the largest value of the column, {size:e}, is beyond what can be reckoned with");
    Err(origin.at(
        row,
        column,
        &problem,
        "correct the row, or give the column in a unit in which its values are near 1",
    ))
}

/// The record of columns that all mean something, `t` among them.
fn build(
    origin: &Origin<'_>,
    columns: BTreeMap<String, Vec<f64>>,
    ignored: Vec<String>,
    system: &System,
    settings: &RecordSettings,
) -> Result<(Record, Audit), DiagnoseError> {
    let mut roles = Roles::of(origin, columns, &ignored, system)?;
    let clock = Clock::of(origin, &roles.times)?;
    for (column, values) in roles.driving() {
        if let Some(row) = values.iter().position(|v| !v.is_finite()) {
            let remedy = "an input must be known at all times: correct or remove the row";
            return Err(origin.at(row, &column, "not a finite number", remedy).into());
        }
        check_size(origin, &column, values)?;
    }
    let mut measured = Vec::new();
    let mut audits = Vec::new();
    for (name, quantity, mut values) in std::mem::take(&mut roles.measured) {
        for v in &mut values {
            if !v.is_finite() {
                *v = f64::NAN;
            }
        }
        let lost = values.iter().filter(|v| v.is_nan()).count();
        if lost as f64 > MOST_LOST * values.len() as f64 {
            let message = format!("column `{name}`: {lost} of {} values were lost", values.len());
            return Err(origin.whole(message, "remove the column, or the part of the run without it").into());
        }
        check_size(origin, &name, &values)?;
        let noise = estimate_noise(&roles.times, &values);
        audits.push(ColumnAudit::measured(&name, &values, noise));
        measured.push(Measured { name, quantity, values, noise: noise.std });
    }
    let driving = Driving::of(origin, roles.inputs, roles.derivatives, &roles.times, &clock.gaps, system, settings)?;
    audits.extend(driving.audits);
    let mut audit = Audit::new(origin.name, &roles.times, &clock, audits, ignored);
    let record = Record {
        name: origin.name.to_owned(),
        times: roles.times,
        gaps: clock.gaps,
        inputs: driving.inputs,
        input_derivatives: driving.derivatives,
        measured,
    };
    audit.warnings.extend(consistency::check_rates(origin, &record, system)?);
    audit.warnings.extend(consistency::check_angles(&record, system));
    Ok((record, audit))
}
