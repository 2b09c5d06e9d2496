//! Whether a column has another unit or sign.

use bracketry_system::System;

use super::alarm::Alarm;
use super::findings::{Ending, Findings};
use super::held_out::window_length;
use super::search::Search;
use crate::report::{Note, Rescaling, ScaledColumn};
use crate::settings::{DiagnosisSettings, UnitSettings};
use crate::{Cause, DiagnoseError, Estimate, Record, Study, StudySettings};

/// What columns are scaled together.
#[derive(Clone, Debug, PartialEq)]
enum Scaled {
    Measured(usize),
    AllMeasured,
    Input(usize),
}

/// Puts every measured column, all of them together and every input times the factors of other units and signs before the model
/// as it stands, and refits it with the best. A note if that explains the data as well without any cause and with parameters near
/// their values, where what was found looks like a wrong unit.
///
/// # Errors
/// [`DiagnoseError`] as [`Study::new`].
pub(super) fn other_units(
    system: &System,
    search: &Search<'_>,
    findings: &Findings,
    settings: &DiagnosisSettings,
) -> Result<Option<Note>, DiagnoseError> {
    let base = &findings.base;
    let limits = &settings.verdict.units;
    if !suspicious(search, findings, limits) {
        return Ok(None);
    }
    let of = StudySettings { window: window_length(search.study), ..settings.study.clone() };
    let records = search.study.records();
    let study = |records: &[Record]| Study::counted(system, records, &of, search.study.counter());
    let plain = study(records)?;
    let count = plain.windows().len();
    let windows: Vec<usize> = (0..count).step_by(count.div_ceil(limits.windows).max(1)).collect();
    let states = system.states.len();
    let refitted = Alarm::of(&plain.evaluate(&base.fit, &windows)?, states, 0, &settings.verdict.alarm);
    let mut tried: Vec<(f64, Scaled, Rescaling)> = Vec::new();
    for scaled in scalable(&records[0]) {
        for rescaling in Rescaling::ALL {
            let study = study(&scale(system, records, &scaled, rescaling.factor()))?;
            let fits = study.evaluate(&study.nominal(), &windows)?;
            if fits.iter().all(|w| w.count > 0) {
                tried.push((fits.iter().map(|w| w.square).sum(), scaled.clone(), rescaling));
            }
        }
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((square, scaled, rescaling)) = tried.first() else { return Ok(None) };
    let study = study(&scale(system, records, scaled, rescaling.factor()))?;
    let Ok(fit) = study.fit(&[], &windows, None) else { return Ok(None) };
    let alarm = Alarm::of(&fit.windows, states, fit.values.len(), &settings.verdict.alarm);
    let excess = |alarm: &Alarm| (alarm.square - alarm.floor).max(0.0);
    let explains =
        excess(&alarm) <= limits.explains * excess(&refitted) || alarm.square <= limits.alike * refitted.square;
    let near = fit.values.iter().enumerate().all(|(j, e)| !far(e, limits) || fit.unidentified.contains(&j));
    // What was named explains the data far better.
    let outdone = !findings.chosen.members.is_empty() && alarm.size > limits.outdone * findings.chosen.alarm.size;
    if !near || !explains || outdone {
        return Ok(None);
    }
    // In a linear model it is the same which column it is.
    let alike = tried.iter().filter(|t| t.0 <= limits.alike * square).map(|(_, scaled, rescaling)| {
        let column = match scaled {
            Scaled::Measured(c) => ScaledColumn::Column(records[0].measured[*c].name.clone()),
            Scaled::AllMeasured => ScaledColumn::AllMeasured,
            Scaled::Input(i) => ScaledColumn::Column(system.symbol_name(system.inputs[*i]).to_owned()),
        };
        (column, *rescaling)
    });
    Ok(Some(Note::OtherUnits { columns: alike.collect(), size: alarm.size }))
}

/// Whether what was found looks as if columns had another unit: structure remains, parameters have moved far or stopped at a
/// limit, or the cause is a gain or has no name.
fn suspicious(search: &Search<'_>, findings: &Findings, limits: &UnitSettings) -> bool {
    let moved = findings.base.fit.values.iter().any(|e| far(e, limits));
    let gain = findings
        .chosen
        .members
        .iter()
        .any(|&m| matches!(search.candidates[m].cause, Cause::InputGain | Cause::UnknownTerm));
    match findings.ending {
        Ending::Quiet | Ending::Correlated => moved,
        Ending::Explained => moved || gain,
        Ending::Partly(_) | Ending::Unexplained(_) | Ending::Refuted(_) => true,
    }
}

/// Whether a parameter has changed by more than the factor of another unit.
fn far(e: &Estimate, limits: &UnitSettings) -> bool {
    e.nominal != 0.0 && !(1.0 / limits.change..=limits.change).contains(&(e.value / e.nominal))
}

fn scalable(record: &Record) -> Vec<Scaled> {
    let measured = record.measured.len();
    let mut all: Vec<Scaled> = (0..measured).map(Scaled::Measured).collect();
    if measured > 1 {
        all.push(Scaled::AllMeasured);
    }
    all.extend((0..record.inputs.len()).map(Scaled::Input));
    all
}

fn scale(system: &System, records: &[Record], scaled: &Scaled, factor: f64) -> Vec<Record> {
    let mut records = records.to_vec();
    for record in &mut records {
        for (c, m) in record.measured.iter_mut().enumerate() {
            if *scaled == Scaled::Measured(c) || *scaled == Scaled::AllMeasured {
                m.values.iter_mut().for_each(|v| *v *= factor);
                m.noise *= factor.abs();
            }
        }
        let Scaled::Input(i) = scaled else { continue };
        let derivatives = system.input_derivatives.iter().zip(&mut record.input_derivatives);
        let derivatives = derivatives.filter(|(d, _)| d.input == *i).map(|(_, signal)| signal);
        for signal in record.inputs.get_mut(*i).into_iter().chain(derivatives) {
            signal.values.iter_mut().for_each(|v| *v *= factor);
        }
    }
    records
}
