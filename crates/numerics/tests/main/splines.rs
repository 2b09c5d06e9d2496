//! Splines of known curves: convergence of derivatives, noise, ends.

use bracketry_numerics::spline::{NaturalSpline, ReinschSpline, noise};

/// The sine has no curvature at 0 and 2π, so that the error of the spline and of its derivatives falls as the powers of the step
/// that theory states: 4, 3 and 2.
#[test]
fn the_spline_of_a_sine_converges_with_its_derivatives() {
    let error = |points: usize, order: u32| {
        let times: Vec<f64> = (0..=points).map(|k| std::f64::consts::TAU * k as f64 / points as f64).collect();
        let spline = NaturalSpline::new(times.clone(), times.iter().map(|t| t.sin()).collect());
        let truth = |t: f64| [t.sin(), t.cos(), -t.sin()][order as usize];
        let at = (0..997).map(|k| std::f64::consts::TAU * f64::from(k) / 997.0);
        at.fold(0.0, |w: f64, t| w.max((spline.derivative(t, order) - truth(t)).abs()))
    };
    for (order, power) in [(0, 4.0), (1, 3.0), (2, 2.0)] {
        let found = (error(20, order) / error(80, order)).log(4.0);
        assert!((found - power).abs() < 0.3, "derivative {order}: {found}");
    }
}

/// A straight line stays one, whatever the steps, and one point is a constant.
#[test]
fn lines_are_reproduced_and_ends_hold() {
    let times = vec![0.0, 0.1, 0.5, 0.6, 2.0];
    let line = NaturalSpline::new(times.clone(), times.iter().map(|t| 3.0 - 2.0 * t).collect());
    for t in [0.0, 0.05, 0.3, 0.55, 1.9] {
        assert!((line.derivative(t, 0) - (3.0 - 2.0 * t)).abs() < 1e-12);
        assert!((line.derivative(t, 1) + 2.0).abs() < 1e-12 && line.derivative(t, 2).abs() < 1e-12);
    }
    assert_eq!((line.derivative(-1.0, 0), line.derivative(5.0, 0), line.derivative(5.0, 1)), (3.0, -1.0, 0.0));
    let point = NaturalSpline::new(vec![1.0], vec![7.0]);
    assert_eq!((point.derivative(0.0, 0), point.derivative(2.0, 0), point.derivative(1.0, 1)), (7.0, 7.0, 0.0));
}

fn samples(n: usize, step: f64, f: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
    let t: Vec<f64> = (0..n).map(|k| k as f64 * step).collect();
    let y = t.iter().map(|t| f(*t)).collect();
    (t, y)
}

#[test]
fn exact_samples_are_interpolated_with_their_derivatives() {
    let (t, y) = samples(501, 2e-3, |t| (12.0 * t).sin());
    let spline = ReinschSpline::fit(&t, &y);
    for k in 0..500 {
        let at = t[k] + 0.7e-3;
        let [value, rate, acceleration] = spline.at(at);
        let exact = [(12.0 * at).sin(), 12.0 * (12.0 * at).cos(), -144.0 * (12.0 * at).sin()];
        // At the ends the second derivative is that of a cubic through a few samples, within 1 % of the largest.
        let end = !(20..480).contains(&k);
        let [a, b, c] = if end { [1e-6, 1e-3, 1.44] } else { [1e-8, 1e-5, 0.02] };
        assert!((value - exact[0]).abs() < a && (rate - exact[1]).abs() < b, "{at}");
        assert!((acceleration - exact[2]).abs() < c, "{at}");
    }
}

#[test]
fn the_slope_is_the_derivative_of_the_value_and_the_curvature_that_of_the_slope() {
    let (t, y) = samples(20, 0.1, |t| t * t * t - 2.0 * t * t);
    let spline = ReinschSpline::fit(&t, &y);
    let h = 1e-5;
    for at in [0.031, 0.55, 1.234, 1.87] {
        let [before, now, after] = [at - h, at, at + h].map(|t| spline.at(t));
        assert!(((after[0] - before[0]) / (2.0 * h) - now[1]).abs() < 1e-8);
        assert!(((after[1] - before[1]) / (2.0 * h) - now[2]).abs() < 1e-8);
    }
}

#[test]
fn noise_is_estimated_and_taken_away() {
    // A reproducible sequence, uniform in ±1 with standard deviation 1/√3.
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let (t, exact) = samples(3000, 2e-3, |t| 0.02 * (12.0 * t).sin());
    let noisy: Vec<f64> = exact.iter().map(|v| v + 1e-5 * random()).collect();
    let expected = 1e-5 / 3f64.sqrt();
    assert!((noise(&noisy) / expected - 1.0).abs() < 0.15, "{}", noise(&noisy));
    let spline = ReinschSpline::fit(&t, &noisy);
    let rms = |f: &dyn Fn(usize) -> f64| ((50..2950).map(|k| f(k).powi(2)).sum::<f64>() / 2900.0).sqrt();
    let value = rms(&|k| spline.at(t[k])[0] - exact[k]);
    assert!(value < 0.5 * expected, "{value}");
    let curvature = rms(&|k| spline.at(t[k])[2] + 144.0 * exact[k]);
    // Second differences of the samples would be off by √6 σ/h² = 3.5 m/s².
    assert!(curvature < 0.1, "{curvature}");
}

#[test]
fn short_columns_are_interpolated() {
    assert_eq!(ReinschSpline::fit(&[0.0], &[3.0]).at(1.0), [3.0, 0.0, 0.0]);
    let two = ReinschSpline::fit(&[0.0, 2.0], &[0.0, 1.0]);
    assert_eq!(two.at(1.0), [0.5, 0.5, 0.0]);
    assert_eq!(two.at(4.0), [2.0, 0.5, 0.0]);
    let three = ReinschSpline::fit(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0]);
    assert!((three.at(1.0)[0] - 1.0).abs() < 1e-12 && three.at(1.0)[2] < 0.0);
}
