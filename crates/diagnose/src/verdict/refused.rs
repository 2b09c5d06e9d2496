//! Causes that are not named, however much they gain: those that may as well have no effect, and friction that drives.

use super::explanation::Explanation;
use super::noise::Scatter;
use super::search::Search;
use crate::report::intervals;
use crate::settings::DiagnosisSettings;
use crate::{Cause, DiagnoseError, Effect, Fit, Role};

/// Takes out, one after the other, causes whose intervals contain no effect and those that feed energy where only dissipation
/// is physical, first the one that gains least; says whether there were any.
pub(super) fn drop_refused(
    search: &mut Search<'_>,
    chosen: &mut Explanation,
    scatter: &Scatter,
    settings: &DiagnosisSettings,
) -> Result<bool, DiagnoseError> {
    let mut dropped = false;
    while let Some(rest) = without_refused(search, chosen, scatter, settings)? {
        *chosen = rest;
        dropped = true;
    }
    Ok(dropped)
}

fn without_refused(
    search: &mut Search<'_>,
    chosen: &Explanation,
    scatter: &Scatter,
    settings: &DiagnosisSettings,
) -> Result<Option<Explanation>, DiagnoseError> {
    if chosen.members.is_empty() {
        return Ok(None);
    }
    let fit = over_all_windows(search, chosen)?;
    let every: Vec<usize> = (0..search.study.windows().len()).collect();
    let linearization = search.study.linearize(&fit, &[], &every)?;
    let of_values = intervals(&fit, &linearization, scatter.width(), settings).of_values;
    let interval = |name: &str| fit.values.iter().position(|e| e.name == name).and_then(|j| of_values[j]);
    let mut least: Option<Explanation> = None;
    for &member in &chosen.members {
        let effect = &search.candidates[member];
        if !drives(effect, &fit) && !may_be_nothing(effect, interval) {
            continue;
        }
        let rest = search.without(chosen, member);
        least = least.into_iter().chain(rest).min_by(|a, b| a.square().total_cmp(&b.square()));
    }
    Ok(least)
}

/// The fit of which the numbers are stated.
pub(super) fn over_all_windows(search: &Search<'_>, explanation: &Explanation) -> Result<Fit, DiagnoseError> {
    let windows = search.study.windows().len();
    if search.windows.len() == windows {
        return Ok(explanation.fit.clone());
    }
    let every: Vec<usize> = (0..windows).collect();
    search.study.fit(&explanation.fit.effects, &every, Some(&explanation.fit))
}

/// Whether every amplitude has an interval, and each contains the value at which the effect vanishes.
pub(super) fn may_be_nothing(effect: &Effect, interval: impl Fn(&str) -> Option<[f64; 2]>) -> bool {
    let mut amplitudes = effect.coefficients.iter().filter(|c| c.role == Role::Amplitude).peekable();
    amplitudes.peek().is_some()
        && amplitudes.all(|c| interval(&c.name).is_some_and(|[low, high]| low <= c.nominal && c.nominal <= high))
}

/// Whether an amplitude has the sign that physics does not want: a drag or a friction that drives. Friction that rises from
/// rest instead of falling is found in real machines, so that Stribeck's effect may have either sign.
pub(super) fn drives(effect: &Effect, fit: &Fit) -> bool {
    effect.cause != Cause::StribeckFriction
        && effect.coefficients.iter().filter(|c| c.role == Role::Amplitude).any(|c| {
            let moved = fit.estimate(&c.name).map_or(0.0, |e| e.value - c.nominal);
            f64::from(c.physical_sign) * moved < 0.0
        })
}
