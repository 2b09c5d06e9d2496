//! Smoothing splines against the filter they are, and against motions known exactly.

use std::f64::consts::TAU;

use approx::assert_relative_eq;
use bracketry_sim::{Bandwidth, SmoothingSpline, smooth};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

fn times(n: usize, step: f64) -> Vec<f64> {
    (0..n).map(|k| k as f64 * step).collect()
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn the_gain_is_that_of_a_butterworth_filter_run_both_ways() {
    let t = times(4000, 1e-3);
    let cutoff = 20.0;
    for frequency in [2.0, 10.0, 20.0, 40.0] {
        let wave: Vec<f64> = t.iter().map(|t| (TAU * frequency * t).sin()).collect();
        let (value, first, second) = smooth(&wave, &t, cutoff).unwrap();
        let gain = 1.0 / (1.0 + (frequency / cutoff).powi(6));
        let omega = TAU * frequency;
        for k in 1000..3000 {
            // Without phase: in step with the wave.
            assert!((value[k] - gain * wave[k]).abs() < 1e-5);
            assert!((first[k] - gain * omega * (omega * t[k]).cos()).abs() < 1e-5 * omega);
            assert!((second[k] + gain * omega * omega * wave[k]).abs() < 1e-5 * omega * omega);
        }
    }
}

#[test]
fn parabolas_pass_whatever_the_samples() {
    let mut rng = StdRng::seed_from_u64(1);
    for cutoff in [0.01, 1.0, 100.0] {
        let mut t = 0.0;
        let times: Vec<f64> = (0..500)
            .map(|_| {
                t += rng.random_range(0.001..0.02);
                t
            })
            .collect();
        let mut values: Vec<f64> = times.iter().map(|t| 3.0 - 2.0 * t + 0.7 * t * t).collect();
        for k in [0, 10, 11, 12, 499] {
            values[k] = f64::NAN;
        }
        let spline = SmoothingSpline::fit(&times, &values, Bandwidth::Cutoff(cutoff)).unwrap();
        for t in [-1.0, 0.3, 2.0, 20.0] {
            let [x, v, a] = spline.at(t);
            assert_relative_eq!(x, 3.0 - 2.0 * t + 0.7 * t * t, epsilon = 1e-5, max_relative = 1e-6);
            assert_relative_eq!(v, 1.4 * t - 2.0, epsilon = 1e-5, max_relative = 1e-6);
            assert_relative_eq!(a, 1.4, epsilon = 1e-5);
        }
    }
}

/// The same minimum by a dense solution on a basis of splines: values and derivatives at the knots as unknowns, tied by the
/// conditions that third and fourth derivative do not jump (natural spline) — here by the normal equations of the discretized
/// functional on a fine grid.
#[test]
fn the_curve_is_the_minimum_of_the_functional() {
    let mut rng = StdRng::seed_from_u64(2);
    let times: Vec<f64> = (0..12).map(|k| f64::from(k) + rng.random_range(-0.3..0.3)).collect();
    let values: Vec<f64> = (0..12).map(|_| rng.random_range(-1.0..1.0)).collect();
    let cutoff = 0.15;
    let spline = SmoothingSpline::fit(&times, &values, Bandwidth::Cutoff(cutoff)).unwrap();
    let mut steps: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    let weight = 1.0 / ((TAU * cutoff).powi(6) * steps[steps.len() / 2]);
    let functional = |curve: &dyn Fn(f64) -> f64, third: &dyn Fn(f64) -> f64| {
        let misfit: f64 = times.iter().zip(&values).map(|(t, y)| (y - curve(*t)).powi(2)).sum();
        let n = 40_000;
        let h = (times[11] - times[0]) / f64::from(n);
        let rough: f64 = (0..n).map(|k| third(times[0] + (f64::from(k) + 0.5) * h).powi(2) * h).sum();
        misfit + weight * rough
    };
    let third = |t: f64| (spline.at(t + 1e-5)[2] - spline.at(t - 1e-5)[2]) / 2e-5;
    let best = functional(&|t| spline.at(t)[0], &third);
    for frequency in [0.3, 0.7, 1.5] {
        for size in [1e-2, -1e-2] {
            let bump = |t: f64| size * (frequency * t).sin();
            let bump3 = |t: f64| -size * frequency.powi(3) * (frequency * t).cos();
            let other = functional(&|t| spline.at(t)[0] + bump(t), &|t| third(t) + bump3(t));
            assert!(other > best, "{other} {best}");
        }
        // The first variation vanishes.
        let with = |size: f64| {
            functional(&|t| spline.at(t)[0] + size * (frequency * t).sin(), &|t| {
                third(t) - size * frequency.powi(3) * (frequency * t).cos()
            })
        };
        assert!((with(1e-3) - with(-1e-3)).abs() < 1e-6 * best, "{}", (with(1e-3) - with(-1e-3)) / best);
    }
}

#[test]
fn cross_validation_finds_the_motion_and_the_noise() {
    for seed in 0..5 {
        let mut rng = StdRng::seed_from_u64(seed);
        let t = times(4000, 1e-3);
        let parts: Vec<(f64, f64)> =
            (1..=8).map(|_| (rng.random_range(0.3..4.0), rng.random_range(0.0..TAU))).collect();
        let sum = |t: f64, order: i32| -> f64 {
            parts
                .iter()
                .map(|(f, phase)| (TAU * f).powi(order) * (TAU * f * t + phase + f64::from(order) * TAU / 4.0).sin())
                .sum()
        };
        let noise = Normal::new(0.0, 0.02).unwrap();
        let values: Vec<f64> = t.iter().map(|t| sum(*t, 0) + noise.sample(&mut rng)).collect();
        let spline = SmoothingSpline::fit(&t, &values, Bandwidth::CrossValidated).unwrap();
        assert_relative_eq!(spline.residual, 0.02, max_relative = 0.05);
        let inner = 200..3800;
        let error = |order: i32, found: &[f64]| {
            root_mean_square(inner.clone().map(|k| found[k] - sum(t[k], order)))
                / root_mean_square(inner.clone().map(|k| sum(t[k], order)))
        };
        assert!(error(0, &spline.values) < 0.005, "{}", error(0, &spline.values));
        assert!(error(1, &spline.first) < 0.02, "{}", error(1, &spline.first));
        assert!(error(2, &spline.second) < 0.08, "{}", error(2, &spline.second));
    }
}

#[test]
fn samples_without_noise_are_followed() {
    let t = times(1000, 5e-3);
    // Rounded to nine digits, as in a file.
    let values: Vec<f64> = t.iter().map(|t| (0.03 * (TAU * 3.0 * t).sin() * 1e9).round() * 1e-9).collect();
    let spline = SmoothingSpline::fit(&t, &values, Bandwidth::CrossValidated).unwrap();
    let size = 0.03 * (TAU * 3.0).powi(2);
    for k in 20..980 {
        let exact = -size * (TAU * 3.0 * t[k]).sin();
        assert!((spline.second[k] - exact).abs() < 1e-3 * size, "{} {exact}", spline.second[k]);
    }
}
