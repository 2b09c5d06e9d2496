//! Effects with states that no column shows: fitted, not screened.

use super::explanation::Explanation;
use super::search::{Search, started};
use crate::Coefficient;
use crate::library::hidden_states;
use crate::settings::DiagnosisSettings;

/// One of so many windows tells whether a hidden state is worth a fit to all of them.
const ONE_OF: usize = 4;

/// Adds effects with hidden states to the candidates, and fits them exactly from several values of their shape, until one leaves no more than noise:
/// far from the truth, the linearized problem tells nothing of them. A fit to some windows comes first, which ends where it does not come to
/// explain nearly all: beside other causes of its size, a hidden state is not looked for.
pub(super) fn fit_hidden(search: &mut Search<'_>, base: &Explanation, settings: &DiagnosisSettings) {
    let study = search.study;
    let effects = hidden_states(study.system(), study.records(), study.windows_used().seconds, &settings.library);
    let some: Vec<usize> = search.windows.iter().copied().step_by(ONE_OF).collect();
    let square: f64 = base.fit.windows.iter().filter(|w| some.contains(&w.window)).map(|w| w.square).sum();
    let reach = square * (1.0 - settings.verdict.search.told * base.alarm.excess() / base.square());
    for (place, effect) in search.extend(effects.clone()).into_iter().zip(effects) {
        let values = |c: &Coefficient| c.trials.first().map_or(c.nominal, |v| *v);
        let start: Vec<(String, f64)> = effect.coefficients.iter().map(|c| (c.name.clone(), values(c))).collect();
        let shape = effect.coefficients.iter().position(|c| c.trials.len() > 1);
        let trials = shape.map_or(&[][..], |i| &effect.coefficients[i].trials);
        for trial in trials {
            if search.is_over() {
                study.counter().leave_out(1);
                return;
            }
            search.scanned += 1.0;
            let mut start = start.clone();
            if let Some(i) = shape {
                start[i].1 = *trial;
            }
            let start = started(base.fit.clone(), &start);
            let first = study.fit_toward(std::slice::from_ref(&effect), &some, &start, reach).ok();
            let Some(first) = first.filter(|fit| fit.square() <= reach) else { continue };
            let values: Vec<(String, f64)> = first.values.iter().map(|e| (e.name.clone(), e.value)).collect();
            let found = search.refit(vec![place], &started(base.fit.clone(), &values));
            let found = found.and_then(|e| search.refit(vec![place], &e.fit));
            if found.is_some_and(|e| e.alarm.p_value >= settings.significance) {
                return;
            }
        }
    }
}
