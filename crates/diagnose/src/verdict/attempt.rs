//! One search for causes, with windows of one length.

use super::explanation::Explanation;
use super::held_out::thinned;
use super::hidden::fit_hidden;
use super::search::Search;
use super::select::{Selection, add_all, select};
use super::stage::Stage;
use super::{jumps, periods};
use crate::settings::{DiagnosisSettings, SearchSettings};
use crate::{Cause, DiagnoseError, Effect, Fit, Study};

/// One search, with windows of one length.
pub(super) struct Attempt<'a> {
    pub(super) search: Search<'a>,
    pub(super) base: Explanation,
    pub(super) selection: Selection,
}

impl<'a> Attempt<'a> {
    pub(super) fn new(
        study: &'a Study,
        near: Option<&Fit>,
        library: &[Effect],
        settings: &'a DiagnosisSettings,
        progress: &mut dyn FnMut(Stage),
    ) -> Result<Self, DiagnoseError> {
        let limits = &settings.verdict;
        // Only the parameters carry over: windows of another length have other initial states.
        let start = near.map(Fit::without_windows);
        let windows = thinned(study.windows().len(), limits.search.most_windows);
        let mut fit = study.fit(&[], &windows, start.as_ref())?;
        if near.is_none() && !fit.limited.is_empty() {
            fit = from_short_windows(study, fit, &windows, &limits.search)?;
        }
        let mut library = library.to_vec();
        periods::tune(study, &fit, &mut library, &limits.periods);
        let mut named: Vec<usize> = (0..library.len()).collect();
        progress(Stage::Screen { candidates: library.len() });
        let mut search = Search::new(study, library, windows, limits);
        let base = search.nothing(fit);
        // Where inputs are motions, whose derivatives the model uses, each of these takes long simulations.
        if near.is_none()
            && study.system().input_derivatives.is_empty()
            && base.alarm.p_value < settings.significance
            && !search.is_over()
            && promised(&mut search, &base, &named)? < limits.search.told * base.alarm.excess()
        {
            named.extend(changes(&mut search, &base, settings)?);
            fit_hidden(&mut search, &base, settings);
        }
        let patient = near.is_some() || settings.study.window.is_some();
        // Three causes at once are left to the windows that suit what remains.
        let brief = DiagnosisSettings { max_causes: settings.max_causes.min(2), ..settings.clone() };
        let settings = if patient { settings } else { &brief };
        let selection = if patient || search.is_over() || within_reach(&mut search, &base, &named)? {
            select(&mut search, &base, &named, settings, progress)?
        } else {
            Selection::nothing(&base)
        };
        Ok(Self { search, base, selection })
    }
}

/// What the best single candidate promises.
fn promised(search: &mut Search<'_>, base: &Explanation, named: &[usize]) -> Result<f64, DiagnoseError> {
    let linearized = search.linearized(base, named)?;
    Ok(search.singles(&linearized).first().map_or(0.0, |promise| promise.square))
}

/// Adds changes during the run to the candidates; returns their places.
fn changes(
    search: &mut Search<'_>,
    base: &Explanation,
    settings: &DiagnosisSettings,
) -> Result<Vec<usize>, DiagnoseError> {
    let changes = jumps::promising(search, base, settings)?;
    search.scanned += changes.scanned;
    let mut added = Vec::new();
    for change in changes.effects {
        let places = search.extend(change.to_vec());
        search.changes.extend(<[usize; 2]>::try_from(places.as_slice()));
        added.extend(places);
    }
    Ok(added)
}

/// The fit, or a better one that begins with the parameters that short windows give: over long ones, parameters that are far
/// off leave local minima, in which motions fall out of step.
fn from_short_windows(
    study: &Study,
    mut fit: Fit,
    windows: &[usize],
    settings: &SearchSettings,
) -> Result<Fit, DiagnoseError> {
    let failures = |fit: &Fit| fit.windows.iter().filter(|w| w.count == 0).count();
    let Some(first) = study.windows().first() else { return Ok(fit) };
    let times = &study.records()[first.record].times;
    let length = times[first.to - 1] - times[first.from];
    for &part in &settings.shorter {
        let short = study.with_windows(part * length)?;
        let start = short.fit(&[], &thinned(short.windows().len(), settings.most_windows), None)?;
        let refit = study.fit(&[], windows, Some(&start.without_windows()))?;
        if failures(&refit) <= failures(&fit) && refit.square() < fit.square() {
            fit = refit;
        }
    }
    Ok(fit)
}

/// Whether some pair of candidates promises to bring the residual near the noise, or a delay, a filter, or a jump does so.
fn within_reach(search: &mut Search<'_>, base: &Explanation, named: &[usize]) -> Result<bool, DiagnoseError> {
    let linearized = search.linearized(base, named)?;
    let promised = search.pairs(&linearized, 1).first().map_or(0.0, |p| p.square);
    let reach = search.settings.search.within_reach;
    let near = |square: f64| square < reach * reach * base.alarm.floor;
    let fitted = search.fitted().any(|e| near(e.square()));
    if fitted || near(base.square() - promised) {
        return Ok(true);
    }
    // Secants of delays, filters, and jumps hold less far than others.
    let mut late = search.singles(&linearized);
    let least = search.settings.search.least_late * base.alarm.excess();
    let far = |effect: &Effect| effect.is_late() || effect.cause == Cause::ParameterJump;
    late.retain(|promise| promise.square >= least && promise.candidates.iter().all(|&c| far(&search.candidates[c])));
    late.truncate(search.settings.search.most_late);
    Ok(add_all(search, base, &late).into_iter().flatten().any(|explanation| near(explanation.square())))
}
