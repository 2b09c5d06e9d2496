//! Terms without a name, for what no named cause explains.

use super::explanation::Explanation;
use super::noise::Scatter;
use super::search::Search;
use super::select::{add_all, leading, price};
use super::stage::Stage;
use crate::DiagnoseError;
use crate::settings::DiagnosisSettings;

/// An explanation with terms among `terms` that is better than the one of named causes, if there is one.
///
/// Where named causes leave structure over, up to two terms alone are tried, and one term beside the named causes; better
/// means by Schwarz's criterion with the price of terms without a name, and by a substantial share of the excess. Where they
/// leave none, a single term alone may still say the same more simply: several causes that imitate it, or parameters that
/// had to leave their tolerance for it, are more coefficients than one.
///
/// A term of the dictionary stands for a law that is not in it exactly; a second member that takes away only what the first
/// leaves of the law is no cause of its own. Beside another member, term or named, it must therefore take away a tenth of
/// the residual of the *model*, unless nothing but noise is left then. Where a parameter stops at a limit, a term
/// takes what the parameter may not: such explanations are none.
pub(crate) fn unnamed(
    search: &mut Search<'_>,
    base: &Explanation,
    chosen: &Explanation,
    (named, terms): (&[usize], &[usize]),
    settings: &DiagnosisSettings,
    progress: &mut dyn FnMut(Stage),
) -> Result<Option<(Explanation, Scatter)>, DiagnoseError> {
    progress(Stage::Dictionary);
    let limits = &settings.verdict.selection;
    let structured = chosen.alarm.p_value < settings.significance;
    let terms = &search.shortlist(base, terms, limits.shortlist)?;
    let linearized = search.linearized(base, terms)?;
    let mut tried = Vec::new();
    let promises = search.singles(&linearized);
    let top = promises.first().map_or(0.0, |p| p.square);
    let near = |i: usize, square: f64| i < limits.most_terms_beside || square >= limits.near_best_term * top;
    let best = promises.iter().enumerate().take_while(|(i, p)| near(*i, p.square));
    let best = best.take(limits.most_terms_alone).map(|(_, promise)| promise);
    tried.extend(add_all(search, base, best).into_iter().flatten());
    let alone = tried.iter().map(Explanation::square).fold(base.square(), f64::min);
    if structured {
        let own = limits.least_share * base.alarm.excess();
        let worth = |e: &Explanation, less: f64| e.alarm.p_value >= settings.significance || e.square() < less - own;
        let pairs =
            if settings.max_causes < 2 { Vec::new() } else { search.pairs(&linearized, limits.most_term_pairs) };
        let pairs = add_all(search, base, &pairs);
        tried.extend(pairs.into_iter().flatten().filter(|e| worth(e, alone)));
        if (1..settings.max_causes).contains(&chosen.members.len()) {
            let linearized = search.linearized(chosen, terms)?;
            let singles = search.singles(&linearized);
            let beside = add_all(search, chosen, singles.iter().take(limits.most_terms_beside));
            tried.extend(beside.into_iter().flatten().filter(|e| worth(e, alone.min(chosen.square()))));
        }
    }
    tried.retain(|e| e.stopped(settings.verdict.search.vanished).next().is_none());
    let Some(closest) = tried.iter().min_by(|a, b| a.square().total_cmp(&b.square())) else { return Ok(None) };
    let linearized = search.linearized(closest, named)?;
    let scatter = Scatter::linearized(&closest.alarm, &linearized.scores);
    let Some(best) = leading(search, &tried, &scatter).cloned() else { return Ok(None) };
    let substantial = chosen.square() - best.square() >= limits.substantial * chosen.alarm.excess();
    let better =
        price(search, &best, &scatter, settings.tolerance) < price(search, chosen, &scatter, settings.tolerance);
    Ok(((substantial || !structured) && better).then_some((best, scatter)))
}
