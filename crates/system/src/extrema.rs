//! Least and greatest values of continuous functions on boxes, by branch and bound with enclosures of value and gradient
//! (Hansen and Walster 2004, ch. 12).

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::enclosure::{Enclosed, Enclosure};

/// Boxes that are divided before the search is given up.
const MAX_BOXES: usize = 20_000;

/// Relative accuracy of an extreme value.
const ACCURACY: f64 = 1e-11;

/// A least value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Least {
    /// A number that no value is below, and that some value comes near to the accuracy.
    pub(crate) value: f64,
    /// The corner that it is taken at, for each variable whether its upper end; `None` where it is not known to be one.
    pub(crate) corner: Option<Vec<bool>>,
}

struct Part {
    lower: f64,
    region: Vec<Enclosure>,
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Part {}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Part {
    /// The part with the least bound is the greatest, so that a heap gives it first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.lower.total_cmp(&self.lower)
    }
}

struct Search<'a> {
    /// The function and its gradient.
    enclosed: &'a mut Enclosed,
    /// 1, or −1 for greatest values.
    sign: f64,
    /// The least value seen.
    seen: f64,
    out: Vec<Enclosure>,
}

/// The least value of `sign` times the first output on the box; the other outputs are its derivatives (generalized
/// gradients where it has kinks). `None` where the search was given up or the function is not bounded.
pub(crate) fn least(enclosed: &mut Enclosed, sign: f64, region: &[Enclosure]) -> Option<Least> {
    let mut search = Search { enclosed, sign, seen: f64::INFINITY, out: Vec::new() };
    let mut heap = BinaryHeap::new();
    let first = search.bounded(region.to_vec());
    heap.push(first);
    for _ in 0..MAX_BOXES {
        let part = heap.pop()?;
        let point = part.region.iter().all(|x| x.lower == x.upper);
        if search.seen - part.lower <= ACCURACY * (1.0 + search.seen.abs()) {
            let value = part.lower;
            let alone = heap.peek().is_none_or(|next| next.lower >= search.seen);
            let is_corner = |(x, whole): (&Enclosure, &Enclosure)| x.lower == whole.lower || x.lower == whole.upper;
            let corner = (point && alone && part.region.iter().zip(region).all(is_corner))
                .then(|| part.region.iter().zip(region).map(|(x, whole)| x.lower == whole.upper).collect());
            return Some(Least { value, corner });
        }
        if point || !part.lower.is_finite() && part.region.iter().all(|x| x.width() < ACCURACY) {
            return None;
        }
        for half in halves(&part.region) {
            let half = search.bounded(half);
            if half.lower <= search.seen {
                heap.push(half);
            }
        }
    }
    None
}

/// The region in two along its widest side.
fn halves(region: &[Enclosure]) -> [Vec<Enclosure>; 2] {
    let widest = region.iter().enumerate().max_by(|a, b| a.1.width().total_cmp(&b.1.width())).map_or(0, |(k, _)| k);
    let middle = region[widest].middle();
    let mut both = [region.to_vec(), region.to_vec()];
    both[0][widest].upper = middle;
    both[1][widest].lower = middle;
    both
}

impl Search<'_> {
    fn evaluate(&mut self, region: &[Enclosure]) {
        self.enclosed.on(region, &mut self.out);
        if self.sign < 0.0 {
            for x in &mut self.out {
                *x = Enclosure { lower: -x.upper, upper: -x.lower };
            }
        }
    }

    /// The part with a lower bound, reduced to a face where the function rises or falls across all of it.
    fn bounded(&mut self, mut region: Vec<Enclosure>) -> Part {
        self.evaluate(&region);
        let mut reduced = false;
        for (x, slope) in region.iter_mut().zip(&self.out[1..]) {
            if x.lower < x.upper && (slope.lower >= 0.0 || slope.upper <= 0.0) {
                let end = if slope.lower >= 0.0 { x.lower } else { x.upper };
                (*x, reduced) = (Enclosure::point(end), true);
            }
        }
        if reduced {
            self.evaluate(&region);
        }
        let whole = self.out.clone();
        let middle: Vec<Enclosure> = region.iter().map(|x| Enclosure::point(x.middle())).collect();
        self.evaluate(&middle);
        let mut linear = self.out[0];
        self.seen = self.seen.min(linear.upper);
        for ((x, m), &slope) in region.iter().zip(&middle).zip(&whole[1..]) {
            let step = x.sum(Enclosure::point(-m.lower));
            if x.lower < x.upper {
                linear = linear.sum(slope.product(step));
            }
        }
        Part { lower: whole[0].lower.max(linear.lower), region }
    }
}
