//! Inputs that identify parameters.

use bracketry_experiment::{ExperimentError, ExperimentOptions, Identification, Limit, identify};
use bracketry_system::System;

const LAG: &str = "states = ['y']\ninputs = ['u']\nparameters = { a = 1, b = 2 }\ndynamics = { y = '-a*y + b*u' }";

fn model(text: &str) -> System {
    System::parse("model.toml", text).unwrap()
}

fn options(duration: f64) -> ExperimentOptions {
    ExperimentOptions {
        limits: vec![Limit::new("u", -1.0, 1.0)],
        noise: vec![("y".into(), 0.01)],
        ..ExperimentOptions::lasting(duration)
    }
}

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
