//! Forward selection with pairs, then backwards.

use super::noise::Scatter;
use super::search::{Explanation, Promise, Search, scatter};
use super::{Settings, precedence::surprise};
use crate::DiagnoseError;

/// Exact fits are made of single candidates that promise at least this share of what the best one promises.
const NEAR: f64 = 0.5;
/// Most exact fits of singles, and of pairs, per round.
const MOST_FITS: usize = 5;
const MOST_PAIRS: usize = 3;
/// A cause must take away this share of the excess that is there without it.
const LEAST_SHARE: f64 = 0.1;

/// What a selection ends with.
pub(crate) struct Selection {
    /// The explanation.
    pub(crate) chosen: Explanation,
    /// The scatter around it.
    pub(crate) scatter: Scatter,
    /// Number of candidates at their trials that were put against the data.
    pub(crate) tests: f64,
    /// What single candidates promise around the model without effects, the best first.
    pub(crate) promises: Vec<Promise>,
    /// Smallest p-value of a single candidate around the model without effects, corrected.
    pub(crate) screened: f64,
}

/// Adds causes as long as they are significant and matter, one or two at a time.
pub(crate) fn select(
    search: &mut Search<'_>,
    base: &Explanation,
    among: &[usize],
    settings: &Settings,
    progress: &mut dyn FnMut(super::Stage),
) -> Result<Selection, DiagnoseError> {
    let around = search.around(base, among)?;
    let promises = search.singles(&around);
    let tests = around.scores.groups.len().max(1) as f64;
    let mut selection =
        Selection { chosen: base.clone(), scatter: scatter(base, &around.scores), tests, screened: 1.0, promises };
    selection.screened = screened(&selection.promises, &selection.scatter, tests);
    let mut promises = selection.promises.clone();
    while selection.chosen.members.len() < settings.max_causes {
        let room = settings.max_causes - selection.chosen.members.len();
        let still = selection.chosen.alarm.p_value < settings.significance
            || screened(&promises, &selection.scatter, tests) < settings.significance;
        if !still || promises.is_empty() {
            break;
        }
        progress(super::Stage::Fit { causes: selection.chosen.members.len() + 1 });
        let tried = attempts(search, &selection.chosen, &promises, among, room)?;
        let Some(next) = best(search, &tried, among)? else { break };
        let (next, scatter) = next;
        let gained = selection.chosen.square() - next.square();
        let added = next.coefficients - selection.chosen.coefficients;
        let size = next.members.len() - selection.chosen.members.len();
        let p_value = scatter.p_value(gained, added) * tests.powi(size as i32);
        if p_value > settings.significance || gained < LEAST_SHARE * selection.chosen.alarm.excess() {
            break;
        }
        selection.chosen = next;
        selection.scatter = scatter;
        let around = search.around(&selection.chosen, among)?;
        promises = search.singles(&around);
    }
    backwards(search, &mut selection, settings);
    Ok(selection)
}

/// Smallest p-value among single candidates, corrected for their number.
fn screened(promises: &[Promise], scatter: &Scatter, tests: f64) -> f64 {
    promises.iter().map(|p| scatter.p_value(p.square, p.coefficients) * tests).fold(1.0, f64::min)
}

/// Exact fits of the most promising extensions of `current`.
fn attempts(
    search: &mut Search<'_>,
    current: &Explanation,
    promises: &[Promise],
    among: &[usize],
    room: usize,
) -> Result<Vec<Explanation>, DiagnoseError> {
    let mut tried = Vec::new();
    let top = promises.first().map_or(0.0, |p| p.square);
    for promise in promises.iter().take_while(|p| p.square >= NEAR * top).take(MOST_FITS) {
        tried.extend(add(search, current, promise));
    }
    if room >= 2 {
        let around = search.around(current, among)?;
        let reached = tried.iter().map(|e| current.square() - e.square()).fold(top, f64::max);
        for promise in search.pairs(&around, MOST_PAIRS) {
            if promise.square > reached {
                tried.extend(add(search, current, &promise));
            }
        }
    }
    Ok(tried)
}

/// The exact fit of `current` with a promise added.
pub(crate) fn add(search: &mut Search<'_>, current: &Explanation, promise: &Promise) -> Option<Explanation> {
    let mut members = current.members.clone();
    members.extend(&promise.candidates);
    search.explain(&members, &current.fit, &promise.start)
}

/// The best of some explanations, with the scatter around it.
fn best(
    search: &mut Search<'_>,
    tried: &[Explanation],
    among: &[usize],
) -> Result<Option<(Explanation, Scatter)>, DiagnoseError> {
    let Some(closest) = tried.iter().min_by(|a, b| a.square().total_cmp(&b.square())) else { return Ok(None) };
    let around = search.around(closest, among)?;
    let scatter = scatter(closest, &around.scores);
    let chosen = tried.iter().min_by(|a, b| merit(search, a, &scatter).total_cmp(&merit(search, b, &scatter))).cloned();
    Ok(chosen.map(|e| (e, scatter)))
}

/// Schwarz's criterion with what names are worth: smaller is better.
pub(crate) fn merit(search: &Search<'_>, explanation: &Explanation, scatter: &Scatter) -> f64 {
    let names: f64 = explanation.members.iter().map(|&m| surprise(&search.candidates[m])).sum();
    let unphysical = if explanation.physical { 0.0 } else { scatter.price() };
    scatter.criterion(explanation.square(), explanation.coefficients) + names + unphysical
}

/// Takes causes out that are not needed once all are there.
fn backwards(search: &mut Search<'_>, selection: &mut Selection, settings: &Settings) {
    loop {
        let chosen = selection.chosen.clone();
        if chosen.members.len() < 2 {
            return;
        }
        let mut smallest: Option<(f64, Explanation)> = None;
        for &member in &chosen.members {
            let Some(without) = without(search, &chosen, member) else { continue };
            let gained = without.square() - chosen.square();
            let p_value =
                selection.scatter.p_value(gained, search.candidates[member].coefficients.len()) * selection.tests;
            let matters = gained >= LEAST_SHARE * without.alarm.excess();
            let badness = if matters { p_value } else { 1.0_f64.max(p_value) };
            if badness > settings.significance && smallest.as_ref().is_none_or(|s| badness > s.0) {
                smallest = Some((badness, without));
            }
        }
        let Some((_, without)) = smallest else { return };
        selection.chosen = without;
    }
}

/// The explanation without one of its members.
pub(crate) fn without(search: &mut Search<'_>, explanation: &Explanation, member: usize) -> Option<Explanation> {
    let rest: Vec<usize> = explanation.members.iter().copied().filter(|&m| m != member).collect();
    search.explain(&rest, &explanation.fit, &[])
}
