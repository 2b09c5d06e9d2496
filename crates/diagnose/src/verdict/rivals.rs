//! What else could explain the data as well as a named cause.

use std::cmp::Ordering;

use super::held_out::{DIFFERENT, HeldOut};
use super::noise::Scatter;
use super::search::{Explanation, Search};
use super::select::{LEAST_SHARE, add, merit, without};
use crate::DiagnoseError;

/// A rival stays if its sum of squares exceeds the chosen one's by less than this many units of scatter.
///
/// If the rival is the truth, at distance d (in standard deviations) from the chosen explanation, the difference is
/// normal with mean −d² and standard deviation 2d. It exceeds 9 with probability Φ(−(d² + 9)/(2d)), at most Φ(−3) = 0.13 %
/// whatever d is: so seldom is the truth left out.
pub(crate) const MARGIN: f64 = 9.0;
/// The linearised problem may underrate what an exact fit gains by this factor.
const UNDERRATED: f64 = 0.6;
/// Most times that a rival takes a cause's place.
const MOST_SWAPS: usize = 4;
/// Most exact fits per cause.
const MOST_FITS: usize = 8;

/// A cause's rivals: candidate and explanation with it in the cause's place, the best first.
pub(crate) type Rivals = Vec<(usize, Explanation)>;

/// Puts each other candidate in the place of each cause; where one turns out better, the explanation changes.
///
/// Better is what has the better merit, or predicts held-out data better. Of two with as many causes the one with fewer
/// coefficients is preferred unless the other takes away a substantial share of what it leaves over beyond noise: where
/// structure remains that no cause explains, a further coefficient always finds something in it.
pub(crate) fn rivals(
    search: &mut Search<'_>,
    chosen: &mut Explanation,
    scatter: &Scatter,
    among: &[usize],
    held_out: Option<&HeldOut>,
) -> Result<Vec<Rivals>, DiagnoseError> {
    let mut swaps = 0;
    'again: loop {
        let mut all = Vec::new();
        for member in chosen.members.clone() {
            let found = of_one(search, chosen, member, scatter, among)?;
            let limit = chosen.square() + MARGIN * scatter.unit();
            let mut near = Vec::new();
            let mut better: Option<Explanation> = None;
            for (candidate, rival) in found {
                let mut wins = merit(search, &rival, scatter) < merit(search, chosen, scatter);
                if let Some(held_out) = held_out {
                    let worse = held_out.worse(&rival, chosen)?;
                    if worse > DIFFERENT {
                        continue;
                    }
                    wins |= worse < -DIFFERENT;
                }
                // More coefficients must be worth it; what is not is told by the simpler one as well.
                let told = told_as_well(&rival, chosen);
                match rival.coefficients.cmp(&chosen.coefficients) {
                    Ordering::Less => wins |= rival.physical && told,
                    Ordering::Equal => {}
                    Ordering::Greater => wins &= !told_as_well(chosen, &rival),
                }
                if wins && better.as_ref().is_none_or(|b| merit(search, &rival, scatter) < merit(search, b, scatter)) {
                    better = Some(rival.clone());
                }
                if rival.square() <= limit || told {
                    near.push((candidate, rival));
                }
            }
            if let Some(better) = better
                && swaps < MOST_SWAPS
            {
                *chosen = better;
                swaps += 1;
                continue 'again;
            }
            all.push(near);
        }
        return Ok(all);
    }
}

/// Whether `full` takes away no substantial share of the excess that `plain` leaves.
fn told_as_well(plain: &Explanation, full: &Explanation) -> bool {
    plain.square() - full.square() < LEAST_SHARE * plain.alarm.excess()
}

fn of_one(
    search: &mut Search<'_>,
    chosen: &Explanation,
    member: usize,
    scatter: &Scatter,
    among: &[usize],
) -> Result<Rivals, DiagnoseError> {
    let Some(rest) = without(search, chosen, member) else { return Ok(Vec::new()) };
    let around = search.around(&rest, among)?;
    let promises = search.singles(&around);
    let own = promises.iter().find(|p| p.candidates == [member]).map_or(f64::INFINITY, |p| p.square);
    let exact = rest.square() - chosen.square();
    let needed = UNDERRATED * own.min(exact) - MARGIN * scatter.unit();
    let mut found = Vec::new();
    let near = promises.iter().filter(|p| p.candidates != [member] && p.square >= needed);
    for promise in near.take(MOST_FITS) {
        if let Some(explanation) = add(search, &rest, promise) {
            found.push((promise.candidates[0], explanation));
        }
    }
    found.sort_by(|a, b| a.1.square().total_cmp(&b.1.square()));
    Ok(found)
}
