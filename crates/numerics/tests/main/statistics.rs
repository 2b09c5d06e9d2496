//! Statistics of samples against their definitions.

use bracketry_numerics::statistics::{extremes, median, quantile, rms, steps};

/// Values whose order is not that of their places.
fn scattered(n: usize) -> Vec<f64> {
    (0..n).map(|k| (k * 7919 % 104_729) as f64 - 5e4).collect()
}

#[test]
fn a_quantile_is_the_value_of_its_rank() {
    for n in 1..40 {
        let mut sorted = scattered(n);
        sorted.sort_by(f64::total_cmp);
        for share in [0.0, 0.1, 0.25, 0.5, 0.77, 1.0] {
            let rank = ((n - 1) as f64 * share).round() as usize;
            assert_eq!(quantile(scattered(n), share), Some(sorted[rank]));
        }
        assert_eq!(median(scattered(n)), Some(sorted[n / 2]));
    }
}

#[test]
fn without_values_there_is_no_quantile_and_no_spread() {
    assert_eq!((quantile(Vec::new(), 0.5), median(Vec::new())), (None, None));
    assert_eq!(rms([f64::NAN, f64::INFINITY].into_iter()), 0.0);
    assert_eq!(extremes(std::iter::empty()), (f64::INFINITY, f64::NEG_INFINITY));
    assert!(steps(&[1.0]).is_empty());
}

#[test]
fn what_is_not_a_number_counts_as_the_largest() {
    assert_eq!(median(vec![f64::NAN, 1.0, 2.0]), Some(2.0));
    assert_eq!(quantile(vec![f64::NAN, 1.0, 2.0], 0.0), Some(1.0));
}
