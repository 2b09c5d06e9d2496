//! Reading a run.

use std::collections::BTreeMap;
use std::path::Path;

use bracketry_system::{Columns, Entries, FileError, System};

use super::audit::{Audit, ColumnAudit};
use super::clock::Clock;
use super::consistency::{check_angles, check_rates};
use super::decimate::decimate;
use super::driving::Driving;
use super::heading::{Understood, heading, in_the_model};
use super::noise::estimate_noise;
use super::npz;
use super::origin::Origin;
use super::outliers::drop_outliers;
use super::repair::repair;
use super::roles::{Role, Roles, role};
use super::settings::RecordSettings;
use super::warning::Warning;
use crate::error::DiagnoseError;
use crate::record::Record;
use crate::signal::Measured;

/// Reads a run from a table: a column `t` in seconds, one per measured state or output, one per input, `der(X,2)` for its
/// derivatives; other columns are ignored, and the [`Audit`] says so. A file `….npz` is a NumPy archive of one array per
/// column, any other text (CSV).
///
/// # Errors
/// [`DiagnoseError::File`] with file, line, column and remedy for what is no such table.
pub fn read_record(path: &Path, system: &System, settings: &RecordSettings) -> Result<Record, DiagnoseError> {
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
        let (columns, ignored) = npz::read(path, |name| heading(name, system, settings).is_some())?;
        let name = path.display().to_string();
        let origin = Origin { name: &name, table: None };
        let header: Vec<String> = columns.keys().cloned().chain(ignored.iter().cloned()).collect();
        settings.check(&origin, &header, system)?;
        let mut understood = in_the_model(&origin, columns, &BTreeMap::new(), system, settings)?;
        understood.ignored.extend(ignored);
        return build(&origin, understood, system, settings);
    }
    let doc = Columns::document(path, "name a CSV file: a table with a column t, the inputs, and what was measured")?;
    let entries = |name: &str| match heading(name, system, settings).and_then(|h| role(&h.name, system)) {
        None => Entries::Ignored,
        Some(Role::Time) => Entries::Finite,
        Some(_) => Entries::MayBeLost,
    };
    let Columns { columns, header, lines, units } = Columns::parse_with_units(&doc, entries)?;
    let origin = Origin { name: doc.file(), table: Some((&doc, &header, &lines)) };
    settings.check(&origin, &header, system)?;
    let unread: Vec<String> = header.iter().filter(|name| !columns.contains_key(*name)).cloned().collect();
    let mut understood = in_the_model(&origin, columns, &units, system, settings)?;
    understood.ignored.splice(0..0, unread);
    build(&origin, understood, system, settings)
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
    ) -> Result<Record, DiagnoseError> {
        let origin = Origin { name, table: None };
        for (column, values) in &columns {
            if values.len() != times.len() {
                let message = format!("column `{column}` has {} entries for {} times", values.len(), times.len());
                return Err(origin.whole(message, "give one entry per time").into());
            }
        }
        let header: Vec<String> = columns.keys().cloned().collect();
        settings.check(&origin, &header, system)?;
        let mut understood = in_the_model(&origin, columns, &BTreeMap::new(), system, settings)?;
        understood.columns.insert("t".to_owned(), times);
        build(&origin, understood, system, settings)
    }
}

/// Sizes of columns whose squares, and those of their noise, are numbers.
const SIZES: std::ops::Range<f64> = 1e-100..1e100;

/// Refuses a column that is too large or too small to be squared.
fn check_size(origin: &Origin<'_>, column: &str, values: &[f64], rows: &[usize]) -> Result<(), FileError> {
    let size = values.iter().map(|v| v.abs()).fold(0.0, f64::max);
    if size == 0.0 || SIZES.contains(&size) {
        return Ok(());
    }
    let row = values.iter().position(|v| v.abs() == size).map_or(0, |k| rows[k]);
    let problem = format!("the largest value of the column, {size:e}, is too large to compute with");
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
    Understood { columns, ignored, said }: Understood,
    system: &System,
    settings: &RecordSettings,
) -> Result<Record, DiagnoseError> {
    let mut roles = Roles::of(origin, columns, &ignored, system)?;
    Clock::check(origin, &roles.times)?;
    for (column, values) in roles.driving() {
        if values.iter().all(|v| !v.is_finite()) {
            let message = format!("column `{column}`: all values were lost");
            return Err(origin.whole(message, "inputs must be given at all times").into());
        }
    }
    let (mut repaired, cuts) = repair(&mut roles, &settings.limits.repair);
    if roles.times.len() < 2 {
        let message = "fewer than two rows have all inputs";
        return Err(origin.whole(message, "record the inputs and the measurements in the same rows").into());
    }
    let clock = Clock::of(&roles.times, settings.limits.gap, &cuts);
    for (column, values) in roles.driving() {
        check_size(origin, &column, values, &roles.rows)?;
    }
    let mut measured = Vec::new();
    let mut audits = Vec::new();
    let columns = std::mem::take(&mut roles.measured);
    let driving: Vec<&[f64]> = roles.driving().map(|(_, values)| values.as_slice()).collect();
    for (name, quantity, mut values) in columns {
        for v in &mut values {
            if !v.is_finite() {
                *v = f64::NAN;
            }
        }
        let lost = values.iter().filter(|v| v.is_nan()).count();
        let known = values.len() - lost;
        let few = 2 * lost > values.len() && known < settings.limits.fewest_known;
        if few || lost as f64 > settings.limits.most_lost * values.len() as f64 {
            let message = format!("column `{name}`: {lost} of {} values were lost", values.len());
            return Err(origin.whole(message, "remove the column, or the part of the run where it is missing").into());
        }
        check_size(origin, &name, &values, &roles.rows)?;
        let mut noise = estimate_noise(&roles.times, &values, &settings.limits.noise);
        if let Some(found) =
            drop_outliers(&name, &roles.times, &mut values, &driving, noise.std, &settings.limits.outliers)
        {
            noise = estimate_noise(&roles.times, &values, &settings.limits.noise);
            repaired.push(found);
        }
        let outliers = repaired.iter().find_map(|w| w.outliers(&name));
        audits.push(ColumnAudit { outliers, ..ColumnAudit::measured(&name, &values, noise, &settings.limits) });
        measured.push(Measured { name, quantity, values, noise: noise.std });
    }
    let driving = Driving::of(origin, roles.inputs, roles.derivatives, &roles.times, &clock.gaps, system, settings)?;
    audits.extend(driving.audits);
    let mut audit =
        Audit::new(origin.name, &roles.times, &clock, audits, ignored, system.quantities.time_unit, &settings.limits);
    let mut record = Record {
        name: origin.name.to_owned(),
        times: roles.times,
        gaps: clock.gaps,
        inputs: driving.inputs,
        input_derivatives: driving.derivatives,
        measured,
        audit: None,
    };
    // Entries of which a repair speaks are not lost once more.
    let spoken_of = |name: &String| repaired.iter().any(|w| w.marks_as_lost(name));
    let inserted: usize = repaired.iter().map(Warning::inserted_rows).sum();
    audit.warnings.retain_mut(|w| match w {
        Warning::Lost { name, count, .. } => {
            *count = count.saturating_sub(inserted);
            *count > 0 && !spoken_of(name)
        }
        _ => true,
    });
    audit.warnings.splice(0..0, said.into_iter().chain(repaired));
    let limits = &settings.limits.consistency;
    audit.warnings.extend(check_rates(origin, &record, system, limits)?);
    audit.warnings.extend(check_angles(&record, system, limits));
    audit.warnings.extend(decimate(&mut record, &settings.limits.decimation));
    record.audit = Some(audit);
    Ok(record)
}
