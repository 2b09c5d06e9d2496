//! Forward selection with pairs, then backwards.

use super::explanation::{Explanation, Promise};
use super::jumps::with_slow_changes;
use super::noise::Scatter;
use super::precedence::surprise;
use super::search::{Search, Wanted};
use super::stage::Stage;
use crate::DiagnoseError;
use crate::settings::DiagnosisSettings;

/// What a selection ends with.
pub(crate) struct Selection {
    /// The explanation.
    pub(crate) chosen: Explanation,
    /// The scatter around it.
    pub(crate) scatter: Scatter,
    /// Number of candidates at their trials that were put against the data.
    pub(crate) tests: f64,
    /// Smallest p-value of a single candidate around the model without effects, corrected.
    pub(crate) screened: f64,
}

impl Selection {
    /// Nothing selected, nothing tried.
    pub(crate) fn nothing(base: &Explanation) -> Self {
        Self { chosen: base.clone(), scatter: Scatter::of(&base.alarm), tests: 1.0, screened: 1.0 }
    }
}

/// Adds causes as long as they are significant and matter, one or two at a time.
pub(crate) fn select(
    search: &mut Search<'_>,
    base: &Explanation,
    among: &[usize],
    settings: &DiagnosisSettings,
    progress: &mut dyn FnMut(Stage),
) -> Result<Selection, DiagnoseError> {
    if search.is_over() {
        search.study.counter().leave_out(among.len());
        return Ok(Selection::nothing(base));
    }
    let linearized = search.linearized(base, among)?;
    let mut promises = search.singles(&linearized);
    let tests = linearized.scores.groups.len().max(1) as f64 + search.scanned;
    let scatter_at_base = Scatter::linearized(&base.alarm, &linearized.scores);
    let screened_at_base = screened(&promises, &scatter_at_base, tests);
    let mut selection = Selection { chosen: base.clone(), scatter: scatter_at_base, tests, screened: screened_at_base };
    while selection.chosen.members.len() < settings.max_causes {
        let room = settings.max_causes - selection.chosen.members.len();
        let still = selection.chosen.alarm.p_value < settings.significance
            || screened(&promises, &selection.scatter, tests) < settings.significance;
        if !still || promises.is_empty() || search.is_over() || selection.chosen.spans(base, &settings.verdict.search) {
            break;
        }
        progress(Stage::Fit { causes: selection.chosen.members.len() + 1 });
        let tried = attempts(search, &selection, &promises, among, room, settings)?;
        let Some((next, scatter)) = best(search, &tried, among)? else { break };
        let gained = selection.chosen.square() - next.square();
        let added = next.numbers().saturating_sub(selection.chosen.numbers());
        let size = next.members.len().saturating_sub(selection.chosen.members.len());
        let p_value = scatter.p_value(gained, added) * tests.powi(size as i32);
        if p_value > settings.significance
            || gained < settings.verdict.selection.least_share * selection.chosen.alarm.excess()
        {
            break;
        }
        selection.chosen = next;
        selection.scatter = scatter;
        let linearized = search.linearized(&selection.chosen, among)?;
        promises = search.singles(&linearized);
    }
    let Selection { chosen, scatter, tests, .. } = &mut selection;
    backwards(search, chosen, scatter, *tests, settings);
    Ok(selection)
}

/// Smallest p-value among single candidates, corrected for their number.
fn screened(promises: &[Promise], scatter: &Scatter, tests: f64) -> f64 {
    promises.iter().map(|p| scatter.p_value(p.square, p.coefficients) * tests).fold(1.0, f64::min)
}

/// Exact fits of the most promising extensions of what is chosen.
///
/// Pairs are fitted only if they promise significantly more than the best single candidate reaches.
fn attempts(
    search: &mut Search<'_>,
    selection: &Selection,
    promises: &[Promise],
    among: &[usize],
    room: usize,
    settings: &DiagnosisSettings,
) -> Result<Vec<Explanation>, DiagnoseError> {
    let current = &selection.chosen;
    let limits = &settings.verdict.selection;
    let mut tried = Vec::new();
    let top = promises.first().map_or(0.0, |p| p.square);
    let near = promises.iter().take_while(|p| p.square >= limits.near_best * top).take(limits.most_single_fits);
    tried.extend(add_all(search, current, near).into_iter().flatten());
    tried.extend(search.with_sign_flips(current));
    let spread = settings.verdict.jumps.spread;
    tried.extend(with_slow_changes(search, &tried, spread));
    // What is fitted already counts, whatever it promised.
    let more = |e: &&Explanation| {
        e.members.len() == current.members.len() + 1 && current.members.iter().all(|m| e.members.contains(m))
    };
    tried.extend(search.fitted().filter(more).cloned());
    let reached = tried.iter().min_by(|a, b| a.square().total_cmp(&b.square())).unwrap_or(current).clone();
    if room >= 2 {
        let linearized = search.linearized(current, among)?;
        let scatter = Scatter::of(&reached.alarm);
        let mut pairs = search.pairs(&linearized, limits.most_pair_fits);
        pairs.retain(|promise| {
            let more = promise.square - (current.square() - reached.square());
            let added = (current.numbers() + promise.coefficients).saturating_sub(reached.numbers());
            more > 0.0 && scatter.p_value(more, added) * selection.tests.powi(2) < settings.significance
        });
        let pairs: Vec<Explanation> = add_all(search, current, &pairs).into_iter().flatten().collect();
        tried.extend(with_slow_changes(search, &pairs, spread));
        tried.extend(pairs);
    }
    Ok(tried)
}

/// The exact fits of `current` with each promise added, side by side.
pub(crate) fn add_all<'p>(
    search: &mut Search<'_>,
    current: &Explanation,
    promises: impl IntoIterator<Item = &'p Promise>,
) -> Vec<Option<Explanation>> {
    let with = |promise: &Promise| Wanted {
        members: current.members.iter().chain(&promise.candidates).copied().collect(),
        start: promise.start.clone(),
    };
    let attempts: Vec<Wanted> = promises.into_iter().map(with).collect();
    search.explain_all(&current.fit, &attempts)
}

/// The best of some explanations, with the scatter around it.
fn best(
    search: &mut Search<'_>,
    tried: &[Explanation],
    among: &[usize],
) -> Result<Option<(Explanation, Scatter)>, DiagnoseError> {
    let Some(closest) = tried.iter().min_by(|a, b| a.square().total_cmp(&b.square())) else { return Ok(None) };
    // As if the residual of the closest were white noise; then with the actual scatter.
    let first = leading(search, tried, &Scatter::of(&closest.alarm)).unwrap_or(closest);
    let scatter = Scatter::linearized(&first.alarm, &search.linearized(first, among)?.scores);
    Ok(leading(search, tried, &scatter).map(|e| (e.clone(), scatter)))
}

/// The best by its merit.
pub(crate) fn leading<'e>(search: &Search<'_>, tried: &'e [Explanation], scatter: &Scatter) -> Option<&'e Explanation> {
    tried.iter().min_by(|a, b| merit(search, a, scatter).total_cmp(&merit(search, b, scatter)))
}

/// Schwarz's criterion with what names are worth: smaller is better.
pub(crate) fn merit(search: &Search<'_>, explanation: &Explanation, scatter: &Scatter) -> f64 {
    let measured = search.study.records().first().map_or(0, |r| r.measured.len());
    let names: f64 = explanation.members.iter().map(|&m| surprise(&search.candidates[m], measured)).sum();
    let unphysical = if explanation.physical { 0.0 } else { scatter.price() };
    scatter.criterion(explanation.square(), explanation.numbers()) + names + unphysical
}

/// The merit with a price for every parameter that had to leave its tolerance, as for a coefficient.
pub(crate) fn price(search: &Search<'_>, explanation: &Explanation, scatter: &Scatter, tolerance: f64) -> f64 {
    merit(search, explanation, scatter) + scatter.price() * explanation.moved_parameters(tolerance) as f64
}

/// Takes causes out that are not needed once all are there.
pub(crate) fn backwards(
    search: &mut Search<'_>,
    chosen: &mut Explanation,
    scatter: &Scatter,
    tests: f64,
    settings: &DiagnosisSettings,
) {
    while chosen.members.len() > 1 {
        let mut worst: Option<(f64, Explanation)> = None;
        search.without_each(chosen);
        for &member in &chosen.members {
            let Some(without) = search.without(chosen, member) else { continue };
            let gained = without.square() - chosen.square();
            let p_value = scatter.p_value(gained, search.numbers(member)) * tests;
            let least = settings.verdict.selection.least_share * without.alarm.excess();
            let needed = p_value <= settings.significance && gained >= least;
            if !needed && worst.as_ref().is_none_or(|w| gained < w.0) {
                worst = Some((gained, without));
            }
        }
        let Some((_, without)) = worst else { return };
        *chosen = without;
    }
}
