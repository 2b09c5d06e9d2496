//! Fits over windows: what they recover, how certain they say they are, what they do with windows that fail.
#![allow(clippy::unwrap_used)]

use bracketry_diagnose::{
    Cause, Change, Coefficient, Effect, Fit, FitStatus, Measured, Path, Quantity, Record, Role, Signal, Study,
    StudySettings,
};
use bracketry_sim::{Hold, Inputs, Model, Samples, Settings, Stepper};
use bracketry_system::System;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rand_distr::StandardNormal;

const SLIDER: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    parameters = { m = 1.0, c = 1.0 }
    [dynamics]
    x = "v"
    v = "(u - c*sign(v))/m"
"#;

fn system(text: &str) -> System {
    System::parse("model.toml", text).unwrap()
}

/// A multisine of the given rms, random phases, 0.3 to 6 Hz.
fn multisine(times: &[f64], rms: f64, rng: &mut StdRng) -> Vec<f64> {
    let lines: Vec<(f64, f64)> = (0..20).map(|k| (0.3 + 0.3 * k as f64, 6.3 * rng.random::<f64>())).collect();
    let amplitude = rms * (2.0 / lines.len() as f64).sqrt();
    times
        .iter()
        .map(|t| lines.iter().map(|(f, p)| amplitude * (std::f64::consts::TAU * f * t + p).sin()).sum())
        .collect()
}

/// Simulates `truth` at rest from zero and measures the first `columns` states with noise of `level` of each state's rms.
fn log(truth: &System, seconds: f64, rate: f64, delay: f64, columns: usize, level: f64, rng: &mut StdRng) -> Record {
    let times: Vec<f64> = (0..(seconds * rate) as usize).map(|k| k as f64 / rate).collect();
    let u = multisine(&times, 3.0, rng);
    let shifted = times.iter().map(|t| t + delay).collect();
    let inputs = Inputs::new().samples("u", Samples::new(shifted, u.clone(), Hold::Previous).unwrap());
    let model = Model::new(truth, &inputs).unwrap();
    let mut stepper = Stepper::new(model, 0.0, &vec![0.0; truth.states.len()], &Settings::default()).unwrap();
    let mut states = vec![Vec::new(); truth.states.len()];
    for &t in &times {
        assert!(stepper.advance(t).is_finished());
        for (list, x) in states.iter_mut().zip(stepper.state()) {
            list.push(*x);
        }
    }
    let names = truth.state_names();
    let measured = (0..columns)
        .map(|i| {
            let rms = (states[i].iter().map(|x| x * x).sum::<f64>() / states[i].len() as f64).sqrt();
            let noise = level * rms;
            let values = states[i].iter().map(|x| x + noise * rng.sample::<f64, _>(StandardNormal)).collect();
            Measured { name: names[i].clone(), quantity: Quantity::State(i), values, noise }
        })
        .collect();
    Record {
        name: "log".into(),
        times,
        gaps: Vec::new(),
        inputs: vec![Signal { values: u, hold: Hold::Previous }],
        input_derivatives: Vec::new(),
        measured,
    }
}

fn amplitude(name: &str, nominal: f64, scale: f64, min: f64) -> Coefficient {
    Coefficient {
        name: name.into(),
        role: Role::Amplitude,
        nominal,
        scale,
        min,
        max: f64::INFINITY,
        trials: Vec::new(),
        physical_sign: 1,
        unit: String::new(),
        about: String::new(),
    }
}

fn delay_of_u() -> Effect {
    Effect {
        cause: Cause::InputDelay,
        equation: "u".into(),
        term: "u(t - tau)".into(),
        coefficients: vec![amplitude("tau", 0.0, 0.01, 0.0)],
        change: Change::Path { path: Path::InputDelay, signals: vec!["u".into()] },
    }
}

fn all(study: &Study) -> Vec<usize> {
    (0..study.windows().len()).collect()
}

/// Within five standard deviations, which themselves are small.
fn assert_recovered(fit: &Fit, name: &str, truth: f64, largest_std: f64) {
    let e = fit.values.iter().find(|e| e.name == name).unwrap();
    assert!(e.std < largest_std, "{e:?}");
    assert!((e.value - truth).abs() < 5.0 * e.std, "{e:?}, truth {truth}");
}

/// The sum of squares over its number is that of noise alone: within five standard deviations of the chi-square law.
fn assert_only_noise(fit: &Fit) {
    let square: f64 = fit.windows.iter().map(|w| w.square).sum();
    let count: usize = fit.windows.iter().map(|w| w.count).sum();
    let fitted: usize = fit.windows.iter().map(|w| w.x0.len()).sum::<usize>() + fit.values.len();
    let freedom = (count - fitted) as f64;
    assert!((square - freedom).abs() < 5.0 * (2.0 * freedom).sqrt(), "{square} with {freedom} degrees of freedom");
}

#[test]
fn parameters_of_a_sticking_slider_are_recovered() {
    let mut rng = StdRng::seed_from_u64(1);
    let truth = system(&SLIDER.replace("m = 1.0, c = 1.0", "m = 1.03, c = 0.95"));
    let record = log(&truth, 4.0, 500.0, 0.0, 2, 0.01, &mut rng);
    let study = Study::new(&system(SLIDER), &[record], &StudySettings::default()).unwrap();
    let fit = study.fit(&[], &all(&study), None).unwrap();
    assert_eq!(fit.status, FitStatus::Converged);
    assert_recovered(&fit, "m", 1.03, 2e-3);
    assert_recovered(&fit, "c", 0.95, 2e-3);
    assert_only_noise(&fit);
}

#[test]
fn a_delay_of_the_input_is_recovered() {
    let mut rng = StdRng::seed_from_u64(2);
    let record = log(&system(SLIDER), 4.0, 500.0, 0.0083, 2, 0.01, &mut rng);
    let study = Study::new(&system(SLIDER), &[record], &StudySettings::default()).unwrap();
    let fit = study.fit(&[delay_of_u()], &all(&study), None).unwrap();
    assert_recovered(&fit, "tau", 0.0083, 1e-4);
    assert_recovered(&fit, "m", 1.0, 2e-3);
    assert_only_noise(&fit);
}
