//! The coordinates that loops positively span.

use super::margin::margin;

/// A margin below this is none.
pub(crate) const LEAST_MARGIN: f64 = 1e-3;
/// Most coordinates whose subsets are looked at.
const MAX_OPEN: usize = 8;
/// A displacement below this part of the size of the coordinate, at least of this much, is rounding of the simulation.
pub(crate) const ROUNDING: f64 = 1e-9;
/// Loops are left out as long as this part of the margin stays.
const KEPT_MARGIN: f64 = 0.7;

/// Coordinates that loops positively span.
pub(crate) struct Spanned {
    pub(crate) moving: Vec<usize>,
    /// By loop, over the moving coordinates.
    pub(crate) directions: Vec<Vec<f64>>,
    pub(crate) margin: f64,
}

/// The largest displacement of each of `count` coordinates.
pub(crate) fn sizes(changes: &[&[f64]], count: usize) -> Vec<f64> {
    (0..count).map(|c| changes.iter().map(|d| d[c].abs()).fold(0.0, f64::max)).collect()
}

/// The largest set of coordinates that loops positively span without a change of the other ones, with the directions of these
/// loops (0 for the others) and the margin.
pub(crate) fn spanned(changes: &[&[f64]], sizes: &[f64], open: &[usize]) -> Spanned {
    let mut sets: Vec<Vec<usize>> = (1u32..1 << open.len().min(MAX_OPEN))
        .map(|bits| (0..open.len()).filter(|k| bits >> k & 1 == 1).map(|k| open[k]).collect())
        .collect();
    sets.sort_by_key(|set| std::cmp::Reverse(set.len()));
    for set in sets {
        let is_alone = |change: &[f64]| {
            let others = open.iter().filter(|c| !set.contains(c));
            others.into_iter().all(|&c| change[c].abs() <= ROUNDING * sizes[c].max(1.0))
        };
        let of = |change: &&[f64]| {
            if is_alone(change) { direction(change, sizes, &set) } else { vec![0.0; set.len()] }
        };
        let directions: Vec<Vec<f64>> = changes.iter().map(of).collect();
        let found = margin(&directions);
        if found >= LEAST_MARGIN {
            return Spanned { moving: set, directions, margin: found };
        }
    }
    Spanned { moving: Vec::new(), directions: Vec::new(), margin: 0.0 }
}

/// Places of loops that span the coordinates with most of the margin of all; the last ones are left out first.
pub(crate) fn fewest(changes: &[&[f64]], sizes: &[f64], moving: &[usize]) -> Vec<usize> {
    let of = |used: &[usize]| {
        let list: Vec<&[f64]> = used.iter().map(|&k| changes[k]).collect();
        let found = spanned(&list, sizes, moving);
        if found.moving.len() == moving.len() { found.margin } else { 0.0 }
    };
    let mut used: Vec<usize> = (0..changes.len()).collect();
    let whole = of(&used);
    for k in (0..changes.len()).rev() {
        let fewer: Vec<usize> = used.iter().copied().filter(|&other| other != k).collect();
        if of(&fewer) >= KEPT_MARGIN * whole && whole > 0.0 {
            used = fewer;
        }
    }
    used
}

/// A displacement in units of the sizes, of length 1, over some coordinates.
pub(crate) fn direction(change: &[f64], sizes: &[f64], moving: &[usize]) -> Vec<f64> {
    let scaled: Vec<f64> = moving.iter().map(|&c| if sizes[c] > 0.0 { change[c] / sizes[c] } else { 0.0 }).collect();
    let length = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
    scaled.iter().map(|x| if length > 0.0 { x / length } else { 0.0 }).collect()
}

/// Whether a change of coordinates is more than rounding of the simulation.
pub(crate) fn is_displaced(change: &[f64], from: &[f64]) -> bool {
    change.iter().zip(from).any(|(d, q)| d.abs() > ROUNDING * q.abs().max(1.0))
}
