//! Causes that are not named, however much they gain: those that may as well have no effect, friction that drives, and limits that hardly any
//! sample reaches.

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
        let beyond = settings.verdict.naming.least_beyond_limit;
        let refused = drives(effect, &fit)
            || may_be_nothing(effect, interval)
            || share_beyond(search, effect, &fit).is_some_and(|share| share < beyond);
        if !refused {
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

/// Share of the samples of an input that lie beyond the limit of a saturation; `None` for other effects. A few extreme samples take on what
/// other causes leave.
fn share_beyond(search: &Search<'_>, effect: &Effect, fit: &Fit) -> Option<f64> {
    let limit = effect.coefficients.first().filter(|_| effect.cause == Cause::Saturation)?;
    let value = fit.estimate(&limit.name)?.value;
    let system = search.study.system();
    let index = system.inputs.iter().position(|&u| system.symbol_name(u) == effect.equation)?;
    let signals = search.study.records().iter().filter_map(|record| record.inputs.get(index));
    let samples: Vec<f64> = signals.flat_map(|signal| signal.values.iter().copied()).collect();
    let is_beyond = |u: f64| if limit.physical_sign < 0 { u > value || -u > value } else { u < value };
    Some(samples.iter().filter(|&&u| is_beyond(u)).count() as f64 / samples.len().max(1) as f64)
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
