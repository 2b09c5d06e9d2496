//! Inputs that tell two explanations apart.

use crate::common::{model, options};
use bracketry_experiment::{ExperimentError, Limit, tell};
use bracketry_system::System;

fn lag(text: &str) -> System {
    model(&format!("states = ['y']\ninputs = ['u']\n{text}"))
}

/// The output of y' = (b u − y)/T from 0 at the samples, in closed form.
fn response(time_constant: f64, gain: f64, inputs: &dyn Fn(usize) -> f64, samples: usize, h: f64) -> Vec<f64> {
    let e = (-h / time_constant).exp();
    let mut y = 0.0;
    let next = |k: usize| {
        y = gain * inputs(k) + (y - gain * inputs(k)) * e;
        y
    };
    std::iter::once(0.0).chain((0..samples).map(next)).collect()
}

/// Sum of squares of what another start of y' = −y/T does not explain.
fn without_start(gap: impl Iterator<Item = f64>, time_constant: f64, h: f64) -> f64 {
    let (mut gaps, mut along, mut size) = (0.0, 0.0, 0.0);
    for (k, gap) in gap.enumerate() {
        let e = (-h * k as f64 / time_constant).exp();
        gaps += gap * gap;
        along += gap * e;
        size += e * e;
    }
    gaps - along * along / size
}

#[test]
fn two_lags_are_told_apart_as_well_as_by_the_best_of_all_switching_patterns() {
    let fixed = |t: f64| lag(&format!("dynamics = {{ y = '(u - y)/{t}' }}"));
    let found = tell([("fast", &fixed(0.5)), ("slow", &fixed(0.7))], &options(4.0)).unwrap();
    let samples = found.design.signals.times.len() - 1;
    let h = found.design.signals.times[1];
    let square = |inputs: &dyn Fn(usize) -> f64| -> f64 {
        let [a, b] = [0.5, 0.7].map(|t| response(t, 1.0, inputs, samples, h));
        let gap = || a.iter().zip(&b).map(|(a, b)| (a - b) / 0.01);
        without_start(gap(), 0.5, h).min(without_start(gap(), 0.7, h))
    };
    let pattern = |bits: usize| move |k: usize| if bits >> (12 * k / samples) & 1 == 1 { 1.0 } else { -1.0 };
    let best = (0..1 << 12).map(|bits| square(&pattern(bits))).fold(0.0, f64::max);
    let own = square(&|k| found.design.signals.values[k][0]);
    assert!((own / found.weaker().chi_square - 1.0).abs() < 1e-4, "{own} {}", found.weaker().chi_square);
    assert!(own > 0.99 * best, "{own} of {best}");
    assert!(found.resolves());
}

#[test]
fn what_a_change_of_parameters_makes_equal_is_not_resolved() {
    let a = lag("parameters = { a = 1, b = 2 }\ndynamics = { y = 'b*u - a*y' }");
    let b = lag("parameters = { T = 0.7, k = 1.5 }\ndynamics = { y = '(k*u - y)/T' }");
    let found = tell([("rate", &a), ("time", &b)], &options(4.0)).unwrap();
    assert!(!found.resolves(), "{:?}", found.separations);
    assert!(found.weaker().deviations < 0.1, "{:?}", found.separations);
    assert!(found.weaker().as_given > 25.0);
}

#[test]
fn limits_of_states_hold_for_both_explanations_on_the_exact_models() {
    let text = |force: &str| {
        model(&format!(
            "states = ['x', 'v']\ninputs = ['u']\nparameters = {{ c = 0.4 }}\ndynamics = {{ x = 'v', v = 'u - {force}' }}"
        ))
    };
    let (a, b) = (text("c*v"), text("c*sign(v)"));
    let mut options = options(6.0);
    options.noise = vec![("x".into(), 0.002), ("v".into(), 0.01)];
    options.limits.extend([Limit::new("x", -0.5, 0.5), Limit::new("v", -1.0, 1.0)]);
    let found = tell([("viscous", &a), ("dry", &b)], &options).unwrap();
    for outputs in &found.outputs {
        for y in outputs {
            assert!(y[0].abs() <= 0.5 + 1e-8 && y[1].abs() <= 1.0 + 1e-8, "{y:?}");
        }
    }
    assert!(found.resolves());
    assert!(found.weaker().deviations >= found.before);
}

#[test]
fn explanations_of_different_systems_are_refused() {
    let a = lag("dynamics = { y = 'u - y' }");
    let b = model("states = ['y']\ninputs = ['w']\ndynamics = { y = 'w - y' }");
    assert!(matches!(tell([("a", &a), ("b", &b)], &options(1.0)), Err(ExperimentError::DifferentInputs { .. })));
    let c = model("states = ['z']\ninputs = ['u']\ndynamics = { z = 'u - z' }");
    assert!(matches!(tell([("a", &a), ("c", &c)], &options(1.0)), Err(ExperimentError::NoColumns)));
    let mut wrong = options(1.0);
    wrong.limits.push(Limit::new("w", -1.0, 1.0));
    assert!(tell([("a", &a), ("a", &a)], &wrong).unwrap_err().to_string().contains("`w`"));
}

#[test]
fn no_values_on_a_grid_explain_the_other_explanation_better_than_the_refit() {
    let mass = |force: &str| {
        model(&format!(
            "states = ['v']\ninputs = ['u']\nparameters = {{ m = 1.2, c = 0.5 }}\ndynamics = {{ v = '(u - c*{force})/m' }}"
        ))
    };
    let (a, b) = (mass("v"), mass("v*abs(v)"));
    let mut options = options(8.0);
    options.noise = vec![("v".into(), 0.02)];
    let found = tell([("viscous", &a), ("quadratic", &b)], &options).unwrap();
    assert!(found.resolves() && found.weaker().deviations > 1.2 * found.before, "{:?}", found.separations);
    let (signals, truth) = (&found.design.signals, &found.outputs[1]);
    let h = signals.times[1];
    let inputs = |k: usize| signals.values[k][0];
    let square = |m: f64, c: f64| {
        let v = response(m / c, 1.0 / c, &inputs, signals.times.len() - 1, h);
        without_start(v.iter().zip(truth).map(|(v, y)| (v - y[0]) / 0.02), m / c, h)
    };
    let grid = (1..60).flat_map(|i| (1..60).map(move |j| (0.06 * f64::from(i), 0.03 * f64::from(j))));
    let best = grid.map(|(m, c)| square(m, c)).fold(f64::INFINITY, f64::min);
    let own = &found.separations[0];
    assert_eq!((own.truth.as_str(), own.refitted.as_str()), ("quadratic", "viscous"));
    let (m, c) = (own.parameters[0].1, own.parameters[1].1);
    assert!((square(m, c) / own.chi_square - 1.0).abs() < 1e-4);
    assert!(own.chi_square <= best, "{} of {best}", own.chi_square);
}
