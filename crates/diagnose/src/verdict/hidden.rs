//! Effects with states that no column shows: fitted, not screened.

use super::explanation::Explanation;
use super::search::{Search, started};
use crate::Coefficient;
use crate::library::hidden_states;
use crate::settings::DiagnosisSettings;

/// Adds effects with hidden states to the candidates, and fits them exactly from several values of their shape, until one leaves no more than noise:
/// far from the truth, the linearized problem tells nothing of them.
pub(super) fn fit_hidden(search: &mut Search<'_>, base: &Explanation, settings: &DiagnosisSettings) {
    let study = search.study;
    let effects = hidden_states(study.system(), study.records(), study.windows_used().seconds, &settings.library);
    for (place, effect) in search.extend(effects.clone()).into_iter().zip(effects) {
        let values = |c: &Coefficient| c.trials.first().map_or(c.nominal, |v| *v);
        let start: Vec<(String, f64)> = effect.coefficients.iter().map(|c| (c.name.clone(), values(c))).collect();
        let shape = effect.coefficients.iter().position(|c| c.trials.len() > 1);
        let trials = shape.map_or(&[][..], |i| &effect.coefficients[i].trials);
        for trial in trials {
            search.scanned += 1.0;
            let mut start = start.clone();
            if let Some(i) = shape {
                start[i].1 = *trial;
            }
            let found = search.refit(vec![place], &started(base.fit.clone(), &start));
            let found = found.and_then(|e| search.refit(vec![place], &e.fit));
            if found.is_some_and(|e| e.alarm.p_value >= settings.significance) {
                return;
            }
        }
    }
}
