//! What each candidate explains alone.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::explanation::Explanation;
use super::findings::Findings;
use super::search::Search;
use crate::gain::middle;
use crate::report::Candidate;
use crate::settings::DiagnosisSettings;

/// Candidates by what their exact fit alone explains, with intervals from resampling windows.
pub(super) fn ranking(search: &Search<'_>, findings: &Findings, settings: &DiagnosisSettings) -> Vec<Candidate> {
    let base = &findings.base;
    let excess = base.alarm.excess();
    let mut singles: Vec<&Explanation> = search.fitted().filter(|e| e.members.len() == 1).collect();
    singles.sort_by(|a, b| a.square().total_cmp(&b.square()).then_with(|| a.members.cmp(&b.members)));
    singles
        .iter()
        .take(settings.verdict.naming.listed_candidates)
        .map(|e| {
            let member = e.members[0];
            let effect = &search.candidates[member];
            let gained = base.square() - e.square();
            // A fit to noise takes away more than the excess, and priors may cost more than an effect gains.
            let share = (excess > 0.0).then(|| (gained / excess).clamp(0.0, 1.0));
            Candidate {
                name: effect.cause,
                equation: effect.equation.clone(),
                term: effect.term.clone(),
                share,
                interval: share.and_then(|share| interval(base, e, share, settings)),
                p_value: (findings.scatter.p_value(gained, e.numbers()) * findings.tests).min(1.0),
                chosen: findings.chosen.members.contains(&member),
            }
        })
        .collect()
}

/// The interval of 95 % for the share of the excess that an explanation takes away: percentiles of the ratio of both over resamples of
/// whole windows (Künsch 1989), parameters at the values that all windows give.
fn interval(
    base: &Explanation,
    explanation: &Explanation,
    share: f64,
    settings: &DiagnosisSettings,
) -> Option<[f64; 2]> {
    let noise = base.alarm.floor / base.alarm.freedom;
    let pairs: Vec<[f64; 2]> = explanation
        .fit
        .windows
        .iter()
        .filter_map(|e| {
            let b = base.fit.windows.iter().find(|b| b.window == e.window && b.count == e.count && b.count > 0)?;
            Some([b.square - e.square, b.square - noise * b.count as f64])
        })
        .collect();
    if pairs.len() < settings.verdict.naming.fewest_resampled {
        return None;
    }
    let mut random = StdRng::seed_from_u64(settings.seed);
    let resamples = settings.gain.resamples;
    let mut shares = Vec::with_capacity(resamples);
    for _ in 0..resamples {
        let drawn = (0..pairs.len()).map(|_| pairs[random.random_range(0..pairs.len())]);
        let [gained, excess] = drawn.fold([0.0, 0.0], |sum, pair| [sum[0] + pair[0], sum[1] + pair[1]]);
        if excess > 0.0 {
            shares.push((gained / excess).clamp(0.0, 1.0));
        }
    }
    // Where hardly any excess is left in some resamples, the ratio says nothing.
    if 10 * shares.len() < 9 * resamples {
        return None;
    }
    let [low, high] = middle(shares)?;
    // The share counts fitted numbers as well, which single windows do not have.
    Some([low.min(share), high.max(share)])
}
