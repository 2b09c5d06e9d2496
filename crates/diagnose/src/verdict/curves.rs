//! Inputs that go on along smooth curves between their samples.

use bracketry_sim::Hold;
use bracketry_system::System;

use super::alarm::Alarm;
use super::explanation::Explanation;
use super::held_out::window_length;
use super::hold::free_inputs;
use crate::report::Note;
use crate::settings::{DiagnosisSettings, SignalSettings};
use crate::{DiagnoseError, Record, Study, StudySettings};

/// The records with curves in place of straight lines through the samples of the inputs, where `explanation` leaves more than
/// noise and much less with them. Beside little noise (data of another simulation have none at all) what the lines cut off at the
/// bends would be taken for a force.
pub(super) fn curved_where_better(
    system: &System,
    study: &Study,
    explanation: &Explanation,
    settings: &DiagnosisSettings,
) -> Result<Option<(Vec<Record>, Note)>, DiagnoseError> {
    if explanation.alarm.p_value >= settings.significance {
        return Ok(None);
    }
    let records = curved(system, study.records(), &settings.verdict.signals);
    if records == study.records() {
        return Ok(None);
    }
    let length = window_length(study);
    let of = StudySettings { window: length, ..settings.study.clone() };
    let study = Study::counted(system, &records, &of, study.counter())?;
    let windows: Vec<usize> = explanation.fit.windows.iter().map(|w| w.window).collect();
    let start = explanation.fit.without_windows();
    let Ok(fit) = study.fit(&explanation.fit.effects, &windows, Some(&start)) else { return Ok(None) };
    let alarm = Alarm::of(&fit.windows, system.states.len(), fit.values.len(), &settings.verdict.alarm);
    let stays = alarm.excess() / explanation.alarm.excess();
    Ok((stays <= settings.verdict.signals.curves_worth).then_some((records, Note::Curves(stays))))
}

/// The records with every straight line between samples of an input shifted by the mean of what a parabola would add to it.
///
/// Over a step h, linear interpolation of u cuts off `u'' h³/12` of the integral (trapezoidal rule), which is all that slower
/// dynamics see of it: lines through `u − u'' h²/12` have the integral of the curve.
pub(super) fn curved(system: &System, records: &[Record], settings: &SignalSettings) -> Vec<Record> {
    let free = free_inputs(system);
    let mut records = records.to_vec();
    for record in &mut records {
        let Record { times, gaps, inputs, .. } = record;
        for &i in &free {
            if inputs[i].hold == Hold::Linear {
                inputs[i].values = shifted(times, gaps, &inputs[i].values, settings.even_steps);
            }
        }
    }
    records
}

/// `u − u'' h²/12` at the samples that lie in the middle of three evenly spaced ones, `u` at the others.
fn shifted(times: &[f64], gaps: &[usize], values: &[f64], even_steps: f64) -> Vec<f64> {
    let mut shifted = values.to_vec();
    for k in 1..values.len().saturating_sub(1) {
        let (before, after) = (times[k] - times[k - 1], times[k + 1] - times[k]);
        let starts = |k: usize| gaps.binary_search(&k).is_ok();
        let even = (after - before).abs() <= even_steps * before && !starts(k) && !starts(k + 1);
        if even {
            shifted[k] -= (values[k - 1] - 2.0 * values[k] + values[k + 1]) / 12.0;
        }
    }
    shifted
}

#[cfg(test)]
mod tests {
    use super::shifted;

    #[test]
    fn lines_have_the_integral_of_the_curve() {
        let (h, n) = (0.1, 40);
        let times: Vec<f64> = (0..n).map(|k| f64::from(k) * h).collect();
        let values: Vec<f64> = times.iter().map(|t| (2.0 * t).sin()).collect();
        let lines = shifted(&times, &[20], &values, 0.01);
        for k in 1..times.len() - 2 {
            let exact = 0.5 * ((2.0 * times[k]).cos() - (2.0 * times[k + 1]).cos());
            let [plain, better] = [&values, &lines].map(|u| (0.5 * h * (u[k] + u[k + 1]) - exact).abs());
            // At the gap nothing is known of the bend.
            if !(18..=20).contains(&k) {
                assert!(better <= 0.05 * plain.max(1e-6), "{k}: {plain} {better}");
            }
        }
        assert_eq!([lines[0], lines[19], lines[20], lines[39]], [values[0], values[19], values[20], values[39]]);
    }
}
