//! Inputs that identify parameters.

use crate::common::{model, options};
use bracketry_experiment::{ExperimentError, ExperimentOptions, Identification, identify};

const LAG: &str = "states = ['y']\ninputs = ['u']\nparameters = { a = 1, b = 2 }\ndynamics = { y = '-a*y + b*u' }";

/// Determinant of the Fisher information of relative changes, from the standard deviations and their correlation.
fn determinant(found: &Identification) -> f64 {
    let r = found.correlation[0][1];
    let relative = |k: usize| found.parameters[k].std_after.unwrap() / found.parameters[k].value;
    1.0 / (relative(0) * relative(1)).powi(2) / (1.0 - r * r)
}

/// The same of y' = −a y + b u with held inputs, in closed form over each sample, by sums over the samples.
fn determinant_of_lag(inputs: impl Fn(usize) -> f64, samples: usize, h: f64, std: f64) -> f64 {
    // The rows of the linear system (y, a ∂y/∂a, b ∂y/∂b)' = M (y, …) + (b, 0, b) u with a = 1, b = 2.
    let (a, b) = (1.0_f64, 2.0);
    let e = (-a * h).exp();
    let (mut y, mut s, mut m) = (0.0, [0.0; 2], [0.0; 3]);
    for k in 0..samples {
        let rest = b * inputs(k) / a;
        // y = rest + (y0 − rest) e^{−at}; ∂y/∂a: S' = −a S − y.
        let (y0, d) = (y, y - rest);
        y = rest + d * e;
        s[0] = s[0] * e - (rest * (1.0 - e) / a + d * h * e);
        s[1] = y / b;
        let _ = y0;
        let w = [a * s[0] / std, b * s[1] / std];
        m[0] += w[0] * w[0];
        m[1] += w[0] * w[1];
        m[2] += w[1] * w[1];
    }
    m[0] * m[2] - m[1] * m[1]
}

#[test]
fn the_input_of_a_lag_is_as_good_as_the_best_of_all_switching_patterns() {
    let found = identify(&model(LAG), &["a".into(), "b".into()], &options(4.0)).unwrap();
    let samples = found.design.signals.times.len() - 1;
    let h = found.design.signals.times[1];
    // All patterns of twelve pieces.
    let pattern = |bits: usize| move |k: usize| if bits >> (12 * k / samples) & 1 == 1 { 1.0 } else { -1.0 };
    let best = (0..1 << 12).map(|bits| determinant_of_lag(pattern(bits), samples, h, 0.01)).fold(0.0, f64::max);
    let own = determinant_of_lag(|k| found.design.signals.values[k][0], samples, h, 0.01);
    assert!((own / determinant(&found) - 1.0).abs() < 1e-3, "{own} {}", determinant(&found));
    assert!(own > best, "{own} of {best}");
    assert!(found.design.signals.values.iter().all(|u| u[0].abs() <= 1.0));
}

#[test]
fn an_input_without_limits_is_refused() {
    let error = identify(&model(LAG), &["a".into()], &ExperimentOptions::lasting(4.0)).unwrap_err();
    assert!(matches!(&error, ExperimentError::NoLimits { input } if input == "u"), "{error}");
}

/// The generator of the tests: numbers from 0 to 1.
fn uniform(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
fn no_random_input_and_no_step_of_the_same_limits_identifies_random_systems_better() {
    let mut seed = 7;
    for _ in 0..6 {
        let (k, d, b) = (1.0 + 4.0 * uniform(&mut seed), 0.2 + uniform(&mut seed), 0.5 + uniform(&mut seed));
        let duration = 3.0 + 5.0 * uniform(&mut seed);
        let text = format!(
            "states = ['y', 'v']\ninputs = ['u']\nparameters = {{ k = {k}, d = {d}, b = {b} }}\noutputs = {{ y = 'y' }}\n\
             dynamics = {{ y = 'v', v = 'b*u - k*y - d*v' }}"
        );
        let names = ["k", "d", "b"].map(str::to_owned);
        let found = identify(&model(&text), &names, &options(duration)).unwrap();
        // The determinant is that of the inverse of the covariance.
        let own = information_of_oscillator([k, d, b], |i| found.design.signals.values[i][0], duration);
        let stds: Vec<f64> = found.parameters.iter().map(|p| p.std_after.unwrap() / p.value).collect();
        let covariance = determinant_of_three(&found.correlation) * (stds[0] * stds[1] * stds[2]).powi(2);
        assert!((own * covariance - 1.0).abs() < 1e-2, "{own} {covariance}");
        assert!(found.shorter.unwrap() >= 1.0);
        for trial in 0..200 {
            let mut levels = [0.0; 40];
            let hold = 1 + trial % 12;
            for i in 0..40 {
                let next = 2.0 * uniform(&mut seed) - 1.0;
                levels[i] = if i % hold > 0 {
                    levels[i - 1]
                } else if trial % 2 == 0 {
                    next.signum()
                } else {
                    next
                };
            }
            let random = information_of_oscillator([k, d, b], |i| levels[(i / 5).min(39)], duration);
            assert!(random <= own, "{random} {own}");
        }
        assert!(information_of_oscillator([k, d, b], |_| 1.0, duration) <= own);
    }
}

fn determinant_of_three(m: &[Vec<f64>]) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

/// Determinant of the Fisher information of relative changes of y'' = b u − k y − d y', by small steps of the classical method of Runge and Kutta.
fn information_of_oscillator([k, d, b]: [f64; 3], input: impl Fn(usize) -> f64, duration: f64) -> f64 {
    let (samples, steps) = (200, 8);
    let h = duration / f64::from(samples * steps);
    // y, v, and their derivatives by k, d, b.
    let field = |x: &[f64; 8], u: f64| {
        let sensitivity = |i: usize, direct: f64| [x[i + 1], direct - k * x[i] - d * x[i + 1]];
        let [a, e, g] = [sensitivity(2, -x[0]), sensitivity(4, -x[1]), sensitivity(6, u)];
        [x[1], b * u - k * x[0] - d * x[1], a[0], a[1], e[0], e[1], g[0], g[1]]
    };
    let mut x = [0.0; 8];
    let mut m = [[0.0; 3]; 3];
    for sample in 0..samples as usize {
        let u = input(sample);
        for _ in 0..steps {
            let moved = |dx: &[f64; 8], by: f64| std::array::from_fn(|i| x[i] + by * dx[i]);
            let k1 = field(&x, u);
            let k2 = field(&moved(&k1, h / 2.0), u);
            let k3 = field(&moved(&k2, h / 2.0), u);
            let k4 = field(&moved(&k3, h), u);
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        let s = [k * x[2], d * x[4], b * x[6]].map(|s| s / 0.01);
        (0..9).for_each(|i| m[i / 3][i % 3] += s[i / 3] * s[i % 3]);
    }
    determinant_of_three(&m.map(|row| row.to_vec()))
}
