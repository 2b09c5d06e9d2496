//! What else could explain the data as well as a named cause.

use std::cmp::Ordering;
use std::collections::HashMap;

use super::explanation::{Explanation, Promise};
use super::findings::Rivals;
use super::held_out::UnseenWindows;
use super::noise::Scatter;
use super::search::Search;
use super::select::{add_all, merit, price};
use crate::DiagnoseError;
use crate::settings::VerdictSettings;

/// Puts each other candidate in the place of each cause; where one turns out better, the explanation changes.
///
/// Better is what has the better merit, or predicts held-out data better. Of two with as many causes the one with fewer
/// coefficients is preferred unless the other removes a substantial share of its excess: where
/// structure remains that no cause explains, a further coefficient always finds something in it. For the same reason a rival
/// stays, whatever the scatter says, if next to that structure it does nearly all that the cause does; next to it alone, any
/// candidate would stay in place of a small cause. It also stays, and wins with fewer coefficients, if structure near the
/// noise remains and it leaves no more of it than the inexactness of any law does.
///
/// What gains nearly as much beside the cause as in its place is no rival either: were it the truth and the cause its image,
/// nothing would be left for it beside the cause.
pub(crate) fn rivals(
    search: &mut Search<'_>,
    chosen: &mut Explanation,
    scatter: &Scatter,
    among: &[usize],
    held_out: Option<&UnseenWindows>,
    (significance, tolerance): (f64, f64),
) -> Result<Vec<Rivals>, DiagnoseError> {
    let VerdictSettings { search: limits, selection, rivals: settings, .. } = search.settings;
    let least_share = selection.least_share;
    let mut swaps = 0;
    'retry: loop {
        if search.is_over() {
            search.study.counter().leave_out(chosen.members.len());
            return Ok(vec![Vec::new(); chosen.members.len()]);
        }
        let linearized = search.linearized(chosen, among)?;
        let beside: HashMap<usize, f64> =
            search.singles(&linearized).iter().map(|p| (p.candidates[0], p.square)).collect();
        let structured = chosen.alarm.p_value < significance && chosen.alarm.size < limits.near_noise;
        let inexact = search.base().map_or(0.0, |b| limits.inexact * b.alarm.excess());
        // Where only noise remains, a parameter that has left its tolerance is one more thing that is wrong.
        let complete = chosen.alarm.p_value >= significance;
        let merit = |search: &Search<'_>, e: &Explanation| {
            if complete { price(search, e, scatter, tolerance) } else { merit(search, e, scatter) }
        };
        let mut all = vec![Vec::new(); chosen.members.len()];
        // What is least sure of its place first: if another takes it, all comparisons of the other members begin anew.
        for (turn, place) in by_certainty(search, chosen).into_iter().enumerate() {
            let member = chosen.members[place];
            if turn == 1 {
                search.without_each(chosen);
            }
            let Some(rest) = search.without(chosen, member) else { continue };
            let found = of_one(search, chosen, &rest, member, scatter, among)?;
            let little = least_share * (rest.square() - chosen.square());
            let limit = chosen.square() + settings.margin * scatter.unit();
            let mut near = Vec::new();
            let mut better: Option<Explanation> = None;
            for (candidate, rival) in found {
                let mut wins = merit(search, &rival) < merit(search, chosen);
                if let Some(held_out) = held_out {
                    let worse = held_out.worse(&rival, chosen)?;
                    if worse > settings.different {
                        continue;
                    }
                    wins |= worse < -settings.different;
                }
                // More coefficients must be worth it; what is not is told by the simpler one as well.
                let told = told_as_well(&rival, chosen, least_share) && rival.square() - chosen.square() < little
                    || structured && rival.square() - chosen.square() < inexact;
                match rival.numbers().cmp(&chosen.numbers()) {
                    Ordering::Less => wins |= rival.physical && told,
                    Ordering::Equal => {}
                    Ordering::Greater => {
                        let gained = chosen.square() - rival.square();
                        wins &= !(told_as_well(chosen, &rival, least_share) || structured && gained < inexact);
                    }
                }
                if wins && better.as_ref().is_none_or(|b| merit(search, &rival) < merit(search, b)) {
                    better = Some(rival.clone());
                }
                let own = rest.square() - rival.square();
                let besides = |b: f64| b > settings.margin * scatter.unit() && b > settings.beside * own;
                let other = beside.get(&candidate).is_some_and(|&b| besides(b));
                if (rival.square() <= limit || told) && !other {
                    near.push((candidate, rival));
                }
            }
            if let Some(better) = better
                && swaps < settings.most_swaps
            {
                *chosen = better;
                swaps += 1;
                continue 'retry;
            }
            all[place] = near;
        }
        return Ok(all);
    }
}

/// The places of the members, that of the least certain first: by the squares of amplitudes over standard deviations.
fn by_certainty(search: &Search<'_>, explanation: &Explanation) -> Vec<usize> {
    let certainty = |&place: &usize| explanation.expected_cost(&search.candidates[explanation.members[place]]);
    let mut places: Vec<usize> = (0..explanation.members.len()).collect();
    places.sort_by(|a, b| certainty(a).total_cmp(&certainty(b)));
    places
}

/// Whether `full` takes away less than this share of the excess that `plain` leaves.
fn told_as_well(plain: &Explanation, full: &Explanation, least_share: f64) -> bool {
    plain.square() - full.square() < least_share * plain.alarm.excess()
}

fn of_one(
    search: &mut Search<'_>,
    chosen: &Explanation,
    rest: &Explanation,
    member: usize,
    scatter: &Scatter,
    among: &[usize],
) -> Result<Rivals, DiagnoseError> {
    let linearized = search.linearized(rest, among)?;
    let promises = search.singles(&linearized);
    let own = promises.iter().find(|p| p.candidates == [member]).map_or(f64::INFINITY, |p| p.square);
    let exact = rest.square() - chosen.square();
    // What is there altogether or not at all changes too much for the linearized problem to tell its gain.
    let whole = search.candidates[member].coefficients.iter().all(|c| c.settled().is_some());
    let told = if whole { exact } else { own.min(exact) };
    let settings = &search.settings.rivals;
    let needed = settings.underrated * told - settings.margin * scatter.unit();
    let mut found = Rivals::new();
    let near = promises.iter().filter(|p| p.candidates != [member] && p.square >= needed);
    let near: Vec<&Promise> = near.take(settings.most_fits).collect();
    for (promise, explanation) in near.iter().zip(add_all(search, rest, near.iter().copied())) {
        found.extend(explanation.map(|explanation| (promise.candidates[0], explanation)));
    }
    found.sort_by(|a, b| a.1.square().total_cmp(&b.1.square()));
    Ok(found)
}
