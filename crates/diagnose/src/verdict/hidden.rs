//! Masses that no column shows: fitted, not screened.

use super::explanation::Explanation;
use super::search::{Search, started};
use crate::Coefficient;
use crate::library::hidden_masses;
use crate::settings::DiagnosisSettings;

/// Adds masses that no column shows to the candidates, and fits them exactly from several frequencies, until one leaves no more than noise:
/// far from resonance, the linearized problem tells nothing of them.
pub(super) fn fit_hidden_masses(search: &mut Search<'_>, base: &Explanation, settings: &DiagnosisSettings) {
    let study = search.study;
    let masses = hidden_masses(study.system(), study.records(), study.windows_used().seconds, &settings.library);
    for (place, effect) in search.extend(masses.clone()).into_iter().zip(masses) {
        let values = |c: &Coefficient| c.trials.first().map_or(c.nominal, |v| *v);
        let start: Vec<(String, f64)> = effect.coefficients.iter().map(|c| (c.name.clone(), values(c))).collect();
        let frequency = effect.coefficients.iter().position(|c| c.trials.len() > 1);
        let trials = frequency.map_or(&[][..], |i| &effect.coefficients[i].trials);
        for trial in trials {
            search.scanned += 1.0;
            let mut start = start.clone();
            if let Some(i) = frequency {
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
