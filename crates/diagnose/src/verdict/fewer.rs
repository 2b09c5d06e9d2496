//! Whether fewer causes explain as much as a set of them.

use super::alarm::Alarm;
use super::explanation::{Explanation, Promise};
use super::noise::Scatter;
use super::search::{Search, started};
use super::select::price;
use crate::settings::DiagnosisSettings;
use crate::{DiagnoseError, Estimate, Fit};

/// A smaller explanation that is as good as one of several causes, if there is one; a parameter that has left its tolerance counts as a cause.
///
/// Parameters that are refitted without any cause go where they imitate it best, and from there another set may promise more than the one
/// cause that explains all, as a constant force and a saturation promise more than a one-sided dead zone. What single causes, and pairs of
/// them, promise is therefore asked once more with the parameters of the set that was found, and with those of the model as given. Only a
/// set that leaves no structure is reduced: beside structure, all promises are those of what is not in the library.
pub(super) fn fewer(
    search: &mut Search<'_>,
    base: &Explanation,
    chosen: &Explanation,
    among: &[usize],
    scatter: &Scatter,
    settings: &DiagnosisSettings,
) -> Result<Option<Explanation>, DiagnoseError> {
    let complete = chosen.alarm.p_value >= settings.significance || chosen.spans(base, &settings.verdict.search);
    // Where inputs are motions, whose derivatives the model uses, each of these takes long simulations.
    let cheap = search.study.system().input_derivatives.is_empty();
    let count = |e: &Explanation| e.members.len() + e.moved_parameters(settings.tolerance);
    if !complete || !cheap || chosen.members.len() < 2 {
        return Ok(None);
    }
    let limits = &settings.verdict.selection;
    let parameters = chosen.fit.values.len() - chosen.coefficients;
    let given = |e: &Estimate| Estimate { value: e.nominal, ..e.clone() };
    let found: Vec<Estimate> = chosen.fit.values[..parameters].to_vec();
    let mut tried = Vec::new();
    // Initial states go with the parameters; those of hidden states and filters stay with their causes.
    let own = |&m: &usize| !search.candidates[m].hidden().is_empty() || search.candidates[m].is_filter();
    let states = (!chosen.members.iter().any(own)).then(|| chosen.fit.windows.clone());
    for (values, states) in [(found.iter().map(given).collect(), None), (found.clone(), states)] {
        if search.is_over() {
            search.study.counter().leave_out(1);
            break;
        }
        let at = without_causes(search, values, settings)?;
        // Without the causes, some windows may have no motion.
        let running: Vec<usize> = at.fit.windows.iter().filter(|w| w.count > 0).map(|w| w.window).collect();
        if 2 * running.len() < search.windows.len() {
            continue;
        }
        let linearized = search.linearize(&at, among.to_vec(), &running)?;
        let mut promises: Vec<Promise> = search.singles(&linearized);
        promises.truncate(limits.most_single_fits);
        promises.extend(with_values_of(search, chosen, among));
        if count(chosen) > 2 {
            promises.extend(search.pairs(&linearized, limits.most_pair_fits));
        }
        let near = states.map_or_else(|| at.fit.clone(), |windows| Fit { windows, ..at.fit.clone() });
        for promise in promises {
            tried.extend(search.refit(promise.candidates.clone(), &started(near.clone(), &promise.start)));
        }
    }
    let price = |e: &Explanation| price(search, e, scatter, settings.tolerance);
    tried.retain(|e| count(e) < count(chosen) && price(e) < price(chosen));
    Ok(tried.into_iter().min_by(|a, b| count(a).cmp(&count(b)).then(price(a).total_cmp(&price(b)))))
}

/// Causes with one coefficient on an input on which a member of a set acts, at the values of the coefficients of that member in the same unit: the limit of
/// a saturation may be the width of a dead zone.
fn with_values_of(search: &Search<'_>, chosen: &Explanation, among: &[usize]) -> Vec<Promise> {
    let mut promises = Vec::new();
    let inputs = search.study.system().input_names();
    for &member in &chosen.members {
        let effect = &search.candidates[member];
        if !inputs.contains(&effect.equation) {
            continue;
        }
        for &candidate in among.iter().filter(|c| !chosen.members.contains(c)) {
            let other = &search.candidates[candidate];
            let [own] = other.coefficients.as_slice() else { continue };
            if other.equation != effect.equation || !other.hidden().is_empty() {
                continue;
            }
            for c in effect.coefficients.iter().filter(|c| c.unit == own.unit) {
                let Some(found) = chosen.fit.estimate(&c.name) else { continue };
                let value = if own.physical_sign < 0 { -found.value.abs() } else { found.value.abs() };
                let start = vec![(own.name.clone(), value.clamp(own.min, own.max))];
                promises.push(Promise { candidates: vec![candidate], square: 0.0, coefficients: 1, start });
            }
        }
    }
    promises
}

/// The model without causes at some values of its parameters.
fn without_causes(
    search: &Search<'_>,
    values: Vec<Estimate>,
    settings: &DiagnosisSettings,
) -> Result<Explanation, DiagnoseError> {
    let fit = Fit { values, ..search.study.nominal() };
    let windows = search.study.evaluate(&fit, &search.windows)?;
    let alarm = Alarm::of(&windows, search.study.system().states.len(), 0, &settings.verdict.alarm);
    Ok(Explanation { members: Vec::new(), fit: Fit { windows, ..fit }, alarm, coefficients: 0, physical: true })
}
