//! Combinations of parameters that the data determine although they do not determine each parameter: base parameters (Gautier and Khalil 1990).

use bracketry_symbolic::Named;
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};

use super::alarm::{Alarm, upper_tail};
use super::findings::Findings;
use super::moved_parameters::{acts_on, moved_to, parameter_error};
use super::search::Search;
use crate::report::{Combination, RefittedParameter, Value};
use crate::settings::{DiagnosisSettings, StudySettings};
use crate::{Estimate, Fit, Formula, NamedCause, Study};

/// Sweeps over the parameters in the search for the nearest ones within their tolerances.
const SWEEPS: usize = 2000;
/// Weights below this share are not listed.
const LEAST_WEIGHT: f64 = 0.01;

/// The parameters as a cause if none is known to have left its tolerance and yet no values within all tolerances explain the data.
///
/// With the estimates `d` relative to the given values and their covariance `C`, the point of the box of tolerances that is nearest in
/// `(d − δ)ᵀ C⁻¹ (d − δ)` gives the weights `w = C⁻¹ (d − δ)` of a combination that no point of the box reaches:
/// `wᵀd − Σ |w| h`, with half widths `h`, over `√(wᵀ C w)` is the distance from the box. It holds for all weights at once as a
/// simultaneous interval does (Scheffé 1953).
pub(super) fn combination_error(
    system: &System,
    search: &Search<'_>,
    findings: &Findings,
    parameters: &[RefittedParameter],
    settings: &DiagnosisSettings,
) -> Option<NamedCause> {
    let fit = &findings.chosen.fit;
    let count = parameters.len();
    let covariance = fit.covariance.view_range(0..count, 0..count) * findings.scatter.inflation;
    let moved = DVector::from_iterator(count, parameters.iter().map(|p| p.after - p.before));
    let half = DVector::from_iterator(count, parameters.iter().map(|p| settings.tolerance * p.before.abs()));
    let Separated { mut weights, nearest, distance } = separated(&covariance, &moved, &half)?;
    let freedom = findings.scatter.freedom;
    let p_value = upper_tail(distance * distance / count as f64, count as f64, freedom);
    if p_value > settings.significance {
        return None;
    }
    let near = |change: &DVector<f64>| {
        let values = parameters.iter().zip(change.iter());
        let value = |(p, c): (&RefittedParameter, &f64)| Estimate { value: p.before + c, ..estimate(p) };
        left(search, findings, &Fit { values: values.map(value).collect(), ..search.study.nominal() }, settings)
    };
    // The linearization may not reach as far as the tolerances.
    if near(&nearest).is_some_and(|(_, noise)| noise) {
        return None;
    }
    // In relative changes, with absolute weights that add up to one: values within their tolerances change the combination by no more.
    weights.component_mul_assign(&DVector::from_iterator(count, parameters.iter().map(|p| p.before.abs())));
    let total: f64 = weights.iter().map(|w| w.abs()).sum();
    let relative = |j: usize| 1.0 / parameters[j].before.abs().max(f64::MIN_POSITIVE);
    let largest = weights.iamax();
    weights *= weights[largest].signum() / total;
    let natural = DVector::from_fn(count, |j, _| weights[j] * relative(j));
    let change = natural.dot(&moved);
    let std = natural.dot(&(&covariance * &natural)).max(0.0).sqrt();
    let mut parts: Vec<usize> = (0..count).filter(|&j| weights[j].abs() >= LEAST_WEIGHT).collect();
    parts.sort_by(|a, b| weights[*b].abs().total_cmp(&weights[*a].abs()));
    let alone = alone(system, search, findings, parts.iter().map(|&j| &parameters[j]), settings);
    let shown: Vec<(String, Value)> = if let [one] = alone.as_slice() {
        vec![one.clone()]
    } else {
        let of = |&j: &usize| {
            let p = &parameters[j];
            (p.name.clone(), Value { value: p.after, std: p.std, interval: None, unit: p.unit.clone() })
        };
        parts.iter().map(of).collect()
    };
    let names: Vec<&str> = shown.iter().map(|(name, _)| name.as_str()).collect();
    let first = system.parameters.iter().find(|p| Some(&system.symbol_name(p.symbol)) == names.first())?;
    let term = match shown.as_slice() {
        [(name, value)] => moved_to(name, value.value),
        _ => Formula::from(names.join(", ").as_str()),
    };
    Some(NamedCause {
        combination: Some(Combination {
            weights: Named(parts.iter().map(|&j| (parameters[j].name.clone(), weights[j])).collect()),
            change,
            std,
            tolerance: settings.tolerance,
            as_given: near(&DVector::zeros(count)).map(|(size, _)| size),
            alone: Named(alone),
        }),
        ..parameter_error(acts_on(system, first.symbol), term, shown, p_value)
    })
}

/// A combination of numbers that no point of a box reaches.
struct Separated {
    weights: DVector<f64>,
    /// The point of the box that is nearest.
    nearest: DVector<f64>,
    /// Distance of the combination from the box, in standard deviations.
    distance: f64,
}

/// The combination that tells numbers with a covariance from the box about zero with half widths `half`; `None` if they lie in it.
fn separated(covariance: &DMatrix<f64>, moved: &DVector<f64>, half: &DVector<f64>) -> Option<Separated> {
    let precision = covariance.clone().cholesky()?.inverse();
    let mut nearest = DVector::zeros(moved.len());
    for _ in 0..SWEEPS {
        for j in 0..moved.len() {
            let slope = precision.row(j).transpose().dot(&(moved - &nearest));
            nearest[j] = (nearest[j] + slope / precision[(j, j)]).clamp(-half[j], half[j]);
        }
    }
    let weights = precision * (moved - &nearest);
    let beyond = weights.dot(moved) - weights.abs().dot(half);
    let std = weights.dot(&(covariance * &weights)).max(0.0).sqrt();
    (beyond > 0.0 && std > 0.0).then(|| Separated { weights, nearest, distance: beyond / std })
}

fn estimate(p: &RefittedParameter) -> Estimate {
    Estimate { name: p.name.clone(), nominal: p.before, value: p.after, std: p.std }
}

/// Size of what a model leaves, over the noise, and whether that is no more than the refitted model leaves; `None` if it cannot be simulated.
fn left(search: &Search<'_>, findings: &Findings, fit: &Fit, settings: &DiagnosisSettings) -> Option<(f64, bool)> {
    let windows = search.study.evaluate(fit, &search.windows).ok()?;
    if windows.iter().any(|w| w.count == 0) {
        return None;
    }
    let alarm = Alarm::of(&windows, search.study.system().states.len(), 0, &settings.verdict.alarm);
    Some(judged(&alarm, findings, settings))
}

fn judged(alarm: &Alarm, findings: &Findings, settings: &DiagnosisSettings) -> (f64, bool) {
    let noise = alarm.p_value >= settings.significance
        || alarm.size <= settings.verdict.columns.noise * findings.base.alarm.size.max(1.0);
    (alarm.size, noise)
}

/// The parameters of which one alone explains the data, all others as given, with its value.
fn alone<'p>(
    system: &System,
    search: &Search<'_>,
    findings: &Findings,
    among: impl Iterator<Item = &'p RefittedParameter>,
    settings: &DiagnosisSettings,
) -> Vec<(String, Value)> {
    let of = |p: &RefittedParameter| {
        if search.is_over() {
            search.study.counter().leave_out(1);
            return None;
        }
        let others = system.parameters.iter().map(|q| system.symbol_name(q.symbol)).filter(|name| *name != p.name);
        let study = StudySettings {
            fixed: others.map(str::to_owned).collect(),
            window: Some(search.study.windows_used().seconds),
            ..settings.study.clone()
        };
        let study = Study::counted(system, search.study.records(), &study, search.study.counter()).ok()?;
        let all: Vec<usize> = (0..study.windows().len()).collect();
        let fit = study.fit(&[], &all, None).ok()?;
        let found = fit.estimate(&p.name)?.clone();
        let alarm = Alarm::of(&fit.windows, system.states.len(), 1, &settings.verdict.alarm);
        let value = Value {
            value: found.value,
            std: found.widened(findings.scatter.width()),
            interval: None,
            unit: p.unit.clone(),
        };
        judged(&alarm, findings, settings).1.then(|| (p.name.clone(), value))
    };
    among.take(settings.verdict.naming.most_alone).filter_map(of).collect()
}
