//! The noise of a column against noise that was put there.

use std::f64::consts::TAU;

use bracketry_diagnose::{Noise, NoiseSettings, estimate_noise};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal, StandardNormal};

fn noise_of(times: &[f64], values: &[f64]) -> Noise {
    estimate_noise(times, values, &NoiseSettings::default())
}

/// A random smooth motion of size about one with frequencies up to `highest` Hz.
fn motion(rng: &mut StdRng, highest: f64) -> impl Fn(f64) -> f64 + use<> {
    let parts: Vec<(f64, f64)> = (0..8).map(|_| (rng.random_range(0.1..highest), rng.random_range(0.0..TAU))).collect();
    move |t| parts.iter().map(|(f, phase)| 0.5 * (TAU * f * t + phase).sin()).sum()
}

fn even(n: usize, step: f64) -> Vec<f64> {
    (0..n).map(|k| k as f64 * step).collect()
}

fn white(rng: &mut StdRng, n: usize, std: f64) -> Vec<f64> {
    let normal = Normal::new(0.0, std).unwrap();
    (0..n).map(|_| normal.sample(rng)).collect()
}

fn sum(times: &[f64], motion: impl Fn(f64) -> f64, noise: &[f64]) -> Vec<f64> {
    times.iter().zip(noise).map(|(t, e)| motion(*t) + e).collect()
}

/// Mean of estimated over true standard deviation over seeds, and the largest deviation from one.
fn calibration(trial: impl Fn(&mut StdRng) -> f64) -> (f64, f64) {
    let ratios: Vec<f64> = (0..20).map(|seed| trial(&mut StdRng::seed_from_u64(seed))).collect();
    let worst = ratios.iter().map(|r| (r - 1.0).abs()).fold(0.0, f64::max);
    (ratios.iter().sum::<f64>() / 20.0, worst)
}

#[test]
fn white_noise_is_measured_to_a_few_percent_at_any_sampling_rate() {
    // Samples per second, number, standard deviation; motion up to 5 Hz.
    for (rate, n, std) in [(1000.0, 8000, 1e-2), (10_000.0, 8000, 1e-4), (200.0, 2000, 1e-3), (100.0, 1000, 1e-2)] {
        let (mean, worst) = calibration(|rng| {
            let times = even(n, 1.0 / rate);
            let noise = white(rng, n, std);
            noise_of(&times, &sum(&times, motion(rng, 5.0), &noise)).std / std
        });
        assert!((mean - 1.0).abs() < 0.03 && worst < 0.1, "{rate} Hz: {mean}, {worst}");
    }
}

#[test]
fn lost_values_gaps_reversals_and_an_uneven_clock_do_not_matter() {
    let (mean, worst) = calibration(|rng| {
        let mut t = 0.0;
        let mut times = Vec::new();
        for k in 0..4000 {
            t += 1e-3 * rng.random_range(0.5..1.5) + if k % 1500 == 0 { 0.3 } else { 0.0 };
            times.push(t);
        }
        let noise = white(rng, 4000, 2e-3);
        let smooth = motion(rng, 3.0);
        // A velocity that jumps in its slope every 0.4 s, as dry friction makes it.
        let mut values = sum(&times, |t| smooth(t) + 2.0 * (t / 0.4 - (t / 0.4).round()).abs(), &noise);
        for _ in 0..150 {
            values[rng.random_range(0..4000)] = f64::NAN;
            values[rng.random_range(0..4000)] += 0.3;
        }
        noise_of(&times, &values).std / 2e-3
    });
    assert!((mean - 1.0).abs() < 0.08 && worst < 0.15, "{mean}, {worst}");
}

#[test]
fn correlated_noise_is_found_to_be_so() {
    for correlation in [0.5, 0.8, -0.5] {
        let (mean, worst) = calibration(|rng| {
            let n = 8000;
            let times = even(n, 1e-3);
            let mut state = 0.0;
            let innovation = f64::sqrt(1.0 - correlation * correlation);
            let noise: Vec<f64> = (0..n)
                .map(|_| {
                    let e: f64 = StandardNormal.sample(rng);
                    state = correlation * state + innovation * e;
                    1e-2 * state
                })
                .collect();
            let found = noise_of(&times, &sum(&times, motion(rng, 2.0), &noise));
            assert!((found.correlation - correlation).abs() < 0.15, "{correlation}: {found:?}");
            found.std / 1e-2
        });
        assert!((mean - 1.0).abs() < 0.1 && worst < 0.2, "{correlation}: {mean}, {worst}");
    }
}

#[test]
fn white_noise_is_not_taken_for_correlated() {
    let mut correlated = 0;
    for seed in 0..100 {
        let mut rng = StdRng::seed_from_u64(seed);
        let n = rng.random_range(300..8000);
        let times = even(n, 1e-3);
        let noise = white(&mut rng, n, 1e-2);
        let found = noise_of(&times, &sum(&times, motion(&mut rng, 5.0), &noise));
        correlated += usize::from(found.correlation != 0.0);
    }
    assert!(correlated <= 5, "{correlated} of 100");
}

#[test]
fn a_coarse_column_has_the_noise_of_its_rounding() {
    for seed in 0..10 {
        let mut rng = StdRng::seed_from_u64(seed);
        let times = even(8000, 1e-3);
        let q = 1e-3;
        let round = |noise: Vec<f64>, smooth: &dyn Fn(f64) -> f64| -> Noise {
            let values: Vec<f64> = sum(&times, smooth, &noise).iter().map(|v| (v / q).round() * q).collect();
            noise_of(&times, &values)
        };
        let smooth = motion(&mut rng, 2.0);
        let exact = round(vec![0.0; 8000], &smooth);
        assert!((exact.resolution.unwrap() / q - 1.0).abs() < 1e-6);
        assert!(exact.std > 0.999 * q / 12f64.sqrt() && exact.std < 0.45 * q, "{exact:?}");
        // At rest nothing but the rounding is left.
        assert!(
            (round(vec![0.0; 8000], &|t| if t < 4.0 { t } else { 4.0 }).std / (q / 12f64.sqrt()) - 1.0).abs() < 0.4
        );
        let noisy = round(white(&mut rng, 8000, 2.0 * q), &smooth);
        assert!((noisy.std / (q * (4.0f64 + 1.0 / 12.0).sqrt()) - 1.0).abs() < 0.06, "{noisy:?}");
    }
}

#[test]
fn columns_without_noise_or_motion_have_a_positive_finite_one() {
    let times = even(100, 0.01);
    for values in [vec![0.0; 100], vec![1e300; 100], vec![f64::NAN; 100], times.clone()] {
        let found = noise_of(&times, &values);
        assert!(found.std > 0.0 && found.std.is_finite(), "{found:?}");
    }
    for n in 0..12 {
        let found = noise_of(&times[..n], &times[..n]);
        assert!(found.std > 0.0 && found.std.is_finite(), "{found:?}");
    }
}

/// A sensor that is slower than the record has values in every tenth row or so only: its noise is that of its own samples.
#[test]
fn the_noise_of_a_slower_sensor_is_that_of_its_own_samples() {
    for (every, std) in [(2, 1e-2), (5, 1e-3), (12, 3e-2)] {
        let (mean, worst) = calibration(|rng| {
            let times = even(500 * every, 0.05 / every as f64);
            let noise = white(rng, times.len(), std);
            let mut values = sum(&times, motion(rng, 1.0), &noise);
            for (k, value) in values.iter_mut().enumerate() {
                if k % every != 0 {
                    *value = f64::NAN;
                }
            }
            noise_of(&times, &values).std / std
        });
        assert!((mean - 1.0).abs() < 0.05 && worst < 0.25, "every {every}: {mean}, {worst}");
    }
}
