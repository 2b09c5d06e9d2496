//! Whether the inputs go on between samples as they were read.

use bracketry_numerics::statistics::{median, steps};
use bracketry_sim::Hold;
use bracketry_system::System;

use super::alarm::Alarm;
use super::findings::Findings;
use super::held_out::{thinned, window_length};
use super::search::Search;
use crate::report::{Flag, NamedCause, OtherHold};
use crate::settings::DiagnosisSettings;
use crate::{Cause, DiagnoseError, Record, Study, StudySettings};

/// Refits the model once with the other input hold. `None` without such an input, or where it
/// leaves most of the excess.
///
/// The difference between both holds is nearly a delay of half a sampling time, which smooth inputs of analog origin make
/// where they are read as held, and held ones where they are read as straight lines.
pub(super) fn other_hold(
    system: &System,
    search: &Search<'_>,
    findings: &Findings,
    settings: &DiagnosisSettings,
) -> Result<Option<OtherHold>, DiagnoseError> {
    let base = &findings.base.alarm;
    // Both residuals against one noise: the wrong hold leaves errors at high frequencies, which its own residual would take for noise.
    let noise = base.floor / base.freedom;
    let beyond = |alarm: &Alarm| (alarm.square / alarm.freedom / noise - 1.0).max(0.0);
    let excess = beyond(base);
    if excess == 0.0 {
        return Ok(None);
    }
    let Some((records, hold)) = with_other_hold(system, search.study.records()) else { return Ok(None) };
    let length = window_length(search.study);
    let of = StudySettings { window: length, ..settings.study.clone() };
    let study = Study::counted(system, &records, &of, search.study.counter())?;
    let start = findings.base.fit.without_windows();
    let fit = study.fit(&[], &thinned(study.windows().len(), settings.verdict.search.most_windows), Some(&start))?;
    let alarm = Alarm::of(&fit.windows, system.states.len(), fit.values.len(), &settings.verdict.alarm);
    let stays = beyond(&alarm) / excess;
    let is_noise = alarm.p_value >= settings.significance;
    Ok((stays <= settings.verdict.signals.other_hold_worth)
        .then_some(OtherHold { hold, stays: (!is_noise).then_some(stays) }))
}

/// All inputs, by index, but those whose derivatives the model uses, which are motions.
pub(super) fn free_inputs(system: &System) -> Vec<usize> {
    (0..system.inputs.len()).filter(|&i| system.input_derivatives.iter().all(|d| d.input != i)).collect()
}

/// The records with the other hold of all free inputs; `None` if there are none.
fn with_other_hold(system: &System, records: &[Record]) -> Option<(Vec<Record>, Hold)> {
    let free = free_inputs(system);
    let hold = match records.first()?.inputs.get(*free.first()?)?.hold {
        Hold::Previous => Hold::Linear,
        Hold::Linear => Hold::Previous,
    };
    let mut records = records.to_vec();
    for signal in records.iter_mut().flat_map(|r| r.inputs.iter_mut().enumerate()) {
        if free.contains(&signal.0) {
            signal.1.hold = hold;
        }
    }
    Some((records, hold))
}

/// What is odd about a cause that says inputs are late: whether it is half a sampling time, up to the share `near` of one.
pub(super) fn half_a_sample(cause: &NamedCause, records: &[Record], near: f64) -> Option<Flag> {
    if cause.name != Cause::InputDelay {
        return None;
    }
    let (_, delay) = cause.parameters.first()?;
    let record = records.first()?;
    let step = median(steps(&record.times))?;
    if (delay.value - 0.5 * step).abs() > (near * step).max(2.0 * delay.std) || delay.std > 0.25 * step {
        return None;
    }
    let lines = record.inputs.first().is_some_and(|signal| signal.hold == Hold::Linear);
    Some(Flag::HalfSample { lines })
}
