//! The noise of the columns, estimated again from the residual of a fit.

use super::alarm::Alarm;
use crate::report::Note;
use crate::settings::DiagnosisSettings;
use crate::{Measured, Record};

/// By what the estimates of noise of the columns are to be multiplied, if the residual of a fit is noise and says that the columns weigh
/// wrongly against each other. Where it is not noise, high frequencies may be the model's. `None` for records with other columns.
pub(super) fn factors<'a>(
    alarm: &Alarm,
    mut records: impl Iterator<Item = &'a Record>,
    settings: &DiagnosisSettings,
) -> Option<Vec<f64>> {
    let names = |r: &'a Record| r.measured.iter().map(|m| m.name.as_str());
    let first = records.next()?;
    if !records.all(|r| names(r).eq(names(first))) {
        return None;
    }
    let factors: Vec<f64> = alarm.noise.iter().map(|variance| variance.sqrt()).collect();
    let least = factors.iter().copied().fold(f64::INFINITY, f64::min);
    let most = factors.iter().copied().fold(0.0, f64::max);
    let off = least > 0.0 && most.is_finite() && most > settings.verdict.alarm.noise_off * least;
    (alarm.p_value >= settings.significance && off).then_some(factors)
}

/// The records with the noise of their columns times the factors.
pub(super) fn rescaled(records: &[Record], factors: &[f64]) -> Vec<Record> {
    let mut records = records.to_vec();
    for record in &mut records {
        for (m, factor) in record.measured.iter_mut().zip(factors) {
            m.noise *= factor;
        }
    }
    records
}

/// Columns whose noise is another than they show by themselves.
pub(super) fn notes(records: &[Record], factors: &[f64], noise_off: f64) -> Vec<Note> {
    let Some(record) = records.first() else { return Vec::new() };
    let off = record.measured.iter().zip(factors).filter(|(_, f)| !(1.0 / noise_off..=noise_off).contains(*f));
    let note =
        |(m, &factor): (&Measured, &f64)| Note::NoiseOfColumn { column: m.name.clone(), std: m.noise * factor, factor };
    off.map(note).collect()
}
