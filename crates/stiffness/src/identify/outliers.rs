//! Measurements that contradict the rest.

use super::error::IdentificationError;
use super::statistics::{CHI_SQUARE_MEDIAN, CHI_SQUARE_REJECTED};
use bracketry_numerics::statistics::median;

/// Random subsets to start from. With 5 % outliers, 12 measurements are all good in 54 % of them; with 20 % still in 7 %.
const SUBSETS: usize = 60;
/// Share of outliers beyond which the model is questioned instead.
const MOST: f64 = 0.3;

/// Median of the squared distances, in units of the one expected, beyond which noise (ten times as large as stated) is no explanation.
const CONTRADICTING: f64 = 100.0;

/// What to do about outliers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outliers {
    /// All measurements are used as they are.
    #[default]
    Keep,
    /// Measurements beyond the 99.9 % point of χ² are left out.
    Reject,
}

/// The measurements (from 0) that agree with each other: least median of squared Mahalanobis distances over random subsets, then
/// refits on everything within the 99.9 % point of χ² until the set stays (Rousseeuw and Leroy 1987, reweighted least squares). Iterated
/// reweighting from the full fit would not do: wrong loads have leverage, and pull that fit to themselves.
///
/// A noise larger than stated widens the bound: the median tells by how much. Beyond ten times it is refused.
///
/// `fit` makes a model of some measurements, `distances` gives its squared Mahalanobis distances (6 degrees of freedom) to all.
pub(super) fn consensus<M>(
    count: usize,
    subset: usize,
    fit: impl Fn(&[usize]) -> Option<M>,
    distances: impl Fn(&M) -> Vec<f64>,
) -> Result<Vec<usize>, IdentificationError> {
    let all: Vec<usize> = (0..count).collect();
    let mut draw = Draw(0x9e37_79b9_7f4a_7c15);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..SUBSETS {
        let Some(model) = fit(&draw.subset(&all, subset)) else { continue };
        let squared = distances(&model);
        let middle = median(squared.clone()).unwrap_or(0.0);
        if middle.is_finite() && best.as_ref().is_none_or(|(least, _)| middle < *least) {
            best = Some((middle, squared));
        }
    }
    // Where no subset can be fitted, the set as a whole will say why.
    let Some((_, mut squared)) = best else { return Ok(all) };
    let mut kept = Vec::new();
    for _ in 0..30 {
        let scale = (median(squared.clone()).unwrap_or(0.0) / CHI_SQUARE_MEDIAN).max(1.0);
        let next: Vec<usize> = all.iter().copied().filter(|i| squared[*i] <= CHI_SQUARE_REJECTED * scale).collect();
        if next == kept {
            break;
        }
        kept = next;
        match fit(&kept) {
            Some(model) => squared = distances(&model),
            None => break,
        }
    }
    let left_out = count - kept.len();
    let contradicting = median(squared.clone()).unwrap_or(0.0) > CONTRADICTING * CHI_SQUARE_MEDIAN;
    if left_out as f64 > MOST * count as f64 || contradicting {
        let found = if contradicting { squared.iter().filter(|d| **d > CHI_SQUARE_REJECTED).count() } else { left_out };
        return Err(IdentificationError::TooManyOutliers { found, of: count });
    }
    Ok(kept)
}

/// A sequence that is the same in every run (xorshift, Marsaglia 2003): the same data give the same answer.
pub(super) struct Draw(pub(super) u64);

impl Draw {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) % end as u64) as usize
    }

    /// Some of them without repetition, in random order.
    pub(super) fn subset(&mut self, all: &[usize], size: usize) -> Vec<usize> {
        let mut drawn = all.to_vec();
        for i in 0..size.min(all.len()) {
            let other = i + self.below(all.len() - i);
            drawn.swap(i, other);
        }
        drawn.truncate(size);
        drawn
    }
}
