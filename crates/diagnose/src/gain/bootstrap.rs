//! Intervals from resampling windows.

use bracketry_numerics::statistics::quantile;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use crate::study::Linearization;

/// Ends of an interval of 95 %.
const INTERVAL_ENDS: [f64; 2] = [0.025, 0.975];

/// How far each column of a linearization goes, in its natural unit, when some windows count more than once and others not
/// at all: `(Σ wG + P)⁻¹(Σ wg + P pull)`; those that are `held` stay. `None` if the weighted windows do not determine a step.
pub(super) fn weighted_step(
    linearization: &Linearization,
    held: &[usize],
    weight: impl Fn(usize) -> f64,
) -> Option<DVector<f64>> {
    let n = linearization.columns.len();
    let mut gram = DMatrix::from_diagonal(&DVector::from_column_slice(&linearization.prior));
    let mut gradient = DVector::from_fn(n, |j, _| linearization.prior[j] * linearization.pull[j]);
    for (k, normal) in linearization.windows.iter().enumerate() {
        let w = weight(k);
        if w != 0.0 {
            gram += w * &normal.gram;
            gradient += w * &normal.gradient;
        }
    }
    for &j in held {
        gram.row_mut(j).fill(0.0);
        gram.column_mut(j).fill(0.0);
        gram[(j, j)] = 1.0;
        gradient[j] = 0.0;
    }
    let step = Cholesky::new(gram)?.solve(&gradient);
    let natural = DVector::from_fn(n, |j, _| step[j] * linearization.scales[j]);
    natural.iter().all(|v| v.is_finite()).then_some(natural)
}

/// Intervals of 95 % for the columns of a linearization, relative to the values at which it was made: percentiles over
/// `resamples` of whole windows (block bootstrap: Künsch 1989), each solved in linear approximation.
/// The step that all windows ask for, each once, is subtracted: it is what the iteration left undone, or what a kink in the sum
/// of squares hides, no scatter. Columns that are `held` do not move, and have no interval. `None` with fewer than five windows.
pub fn bootstrap(
    linearization: &Linearization,
    held: &[usize],
    resamples: usize,
    seed: u64,
) -> Option<Vec<Option<[f64; 2]>>> {
    let windows = linearization.windows.len();
    if windows < 5 {
        return None;
    }
    let rest = weighted_step(linearization, held, |_| 1.0)?;
    let mut random = StdRng::seed_from_u64(seed);
    let mut steps: Vec<Vec<f64>> = vec![Vec::with_capacity(resamples); linearization.columns.len()];
    for _ in 0..resamples {
        let mut times = vec![0.0; windows];
        for _ in 0..windows {
            times[random.random_range(0..windows)] += 1.0;
        }
        if let Some(step) = weighted_step(linearization, held, |k| times[k]) {
            steps.iter_mut().zip((step - &rest).iter()).for_each(|(list, v)| list.push(*v));
        }
    }
    let intervals = steps.into_iter().enumerate().map(|(j, list)| {
        let made = !held.contains(&j) && 2 * list.len() > resamples;
        made.then(|| middle(list)).flatten().filter(|[low, high]| *low <= 0.0 && 0.0 <= *high)
    });
    Some(intervals.collect())
}

/// The 2.5th and the 97.5th percentile of a list; `None` of an empty one.
pub(crate) fn middle(list: Vec<f64>) -> Option<[f64; 2]> {
    let [low, high] = INTERVAL_ENDS;
    Some([quantile(list.clone(), low)?, quantile(list, high)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Column, Normal};

    /// Windows of a linear problem `r = x δ + e` with as many samples each.
    fn windows(truth: f64, noise: f64, count: usize) -> Linearization {
        let mut random = StdRng::seed_from_u64(7);
        let normal = |window| {
            let (mut g, mut h, mut s) = (0.0, 0.0, 0.0);
            for _ in 0..50 {
                let x: f64 = random.random_range(-1.0..1.0);
                // Uniform with standard deviation `noise`.
                let r = truth * x + noise * 3.0_f64.sqrt() * random.random_range(-1.0..1.0);
                (g, h, s) = (g + x * r, h + x * x, s + r * r);
            }
            let gram = DMatrix::from_element(1, 1, h);
            Normal { window, gram, gradient: DVector::from_element(1, g), square: s, count: 50 }
        };
        Linearization {
            columns: vec![Column::Parameter(0)],
            scales: vec![2.0],
            prior: vec![0.0],
            pull: vec![0.0],
            trials: Vec::new(),
            failures: Vec::new(),
            windows: (0..count).map(normal).collect(),
        }
    }

    #[test]
    fn the_interval_has_the_width_of_least_squares() {
        let linearization = windows(0.3, 0.1, 60);
        let interval = bootstrap(&linearization, &[], 1000, 1).and_then(|b| b[0]);
        let [low, high] = interval.unwrap_or([f64::NAN; 2]);
        // Var x = 1/3: std = 2 · 0.1/√(3000/3), twice 1.96 of it.
        let expected = 2.0 * 1.96 * 2.0 * 0.1 / 1000_f64.sqrt();
        assert!(((high - low) / expected - 1.0).abs() < 0.25, "{low} {high} {expected}");
        assert!(low < 0.0 && 0.0 < high, "around the estimate, whatever the step to it: {low} {high}");
    }

    #[test]
    fn the_same_seed_gives_the_same_interval() {
        let linearization = windows(0.3, 0.1, 20);
        assert_eq!(bootstrap(&linearization, &[], 1000, 5), bootstrap(&linearization, &[], 1000, 5));
        assert_ne!(bootstrap(&linearization, &[], 1000, 5), bootstrap(&linearization, &[], 1000, 6));
    }

    #[test]
    fn what_is_held_has_no_interval_and_does_not_move_the_others() {
        let mut linearization = windows(0.3, 0.1, 20);
        for normal in &mut linearization.windows {
            // A second column that is the first: if it were free, nothing would be known of either.
            normal.gram = DMatrix::from_element(2, 2, normal.gram[(0, 0)]);
            normal.gradient = DVector::from_element(2, normal.gradient[0]);
        }
        linearization.columns.push(Column::Parameter(1));
        for list in [&mut linearization.scales, &mut linearization.prior, &mut linearization.pull] {
            list.push(list[0]);
        }
        let alone = bootstrap(&windows(0.3, 0.1, 20), &[], 1000, 1).and_then(|b| b[0]);
        assert_eq!(bootstrap(&linearization, &[1], 1000, 1), Some(vec![alone, None]));
    }

    #[test]
    fn few_windows_give_no_interval() {
        assert_eq!(bootstrap(&windows(0.3, 0.1, 4), &[], 1000, 1), None);
    }
}
