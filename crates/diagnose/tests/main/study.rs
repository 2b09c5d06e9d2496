//! Fits over windows: what they recover, how certain they say they are, what they do with windows that fail.

use bracketry_diagnose::{
    Cause, Change, Coefficient, DiagnoseError, DiagnosisSettings, Effect, Fit, FitStatus, Measured, Note, Path,
    Quantity, Record, Role, Signal, Study, StudySettings, Window, diagnose,
};
use bracketry_sim::{Hold, Inputs, Model, Samples, SimulationSettings, Stepper};
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
    let mut stepper = Stepper::new(model, 0.0, &vec![0.0; truth.states.len()], &SimulationSettings::default()).unwrap();
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
        audit: None,
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
        sign_flipped: None,
        period_of: None,
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

/// A record of a position that is measured exactly, under a given input.
fn exact(times: Vec<f64>, u: Vec<f64>, hold: Hold, x: Vec<f64>, noise: f64) -> Record {
    let measured = Measured { name: "x".into(), quantity: Quantity::State(0), values: x, noise };
    Record {
        name: "exact".into(),
        times,
        gaps: Vec::new(),
        inputs: vec![Signal { values: u, hold }],
        input_derivatives: Vec::new(),
        measured: vec![measured],
        audit: None,
    }
}

/// `⟨a, b⟩` of what is left of both after the best straight line.
fn without_line(t: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let n = t.len() as f64;
    let mean = t.iter().sum::<f64>() / n;
    let size = t.iter().map(|t| (t - mean).powi(2)).sum::<f64>();
    let left = |y: &[f64]| -> Vec<f64> {
        let offset = y.iter().sum::<f64>() / n;
        let slope = y.iter().zip(t).map(|(y, t)| y * (t - mean)).sum::<f64>() / size;
        y.iter().zip(t).map(|(y, t)| y - offset - slope * (t - mean)).collect()
    };
    left(a).iter().zip(left(b)).map(|(a, b)| a * b).sum()
}

/// A mass pushed from rest by `u = a t`: `x = a t³/(6 m)`, `∂x/∂m = −a t³/(6 m²)`, `∂x/∂τ = −a t²/(2 m)`, up to straight lines,
/// which the initial state takes.
#[test]
fn sensitivities_are_those_of_the_closed_form() {
    let mass = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 2.0 }\n[dynamics]\nx = 'v'\nv = 'u/m'";
    let (a, m, m_true, noise) = (3.0, 2.0, 2.2, 1e-3);
    let times: Vec<f64> = (0..401).map(|k| k as f64 * 5e-3).collect();
    let position = |t: f64, m: f64| a * t.powi(3) / (6.0 * m);
    let x = times.iter().map(|&t| position(t, m_true)).collect();
    let record = exact(times.clone(), times.iter().map(|t| a * t).collect(), Hold::Linear, x, noise);
    let settings = StudySettings { window: Some(0.5), ..StudySettings::default() };
    let study = Study::new(&system(mass), &[record], &settings).unwrap();
    let windows = all(&study);
    let linearization = study.linearize(&study.nominal(), &[delay_of_u()], &windows).unwrap();
    assert_eq!(linearization.columns.len(), 2);
    // The first window has no input before it to be delayed.
    for normal in &linearization.windows[1..] {
        let window = study.windows()[normal.window];
        let t = &times[window.from..window.to];
        let sampled = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { t.iter().map(|&t| f(t) / noise).collect() };
        let columns = [
            sampled(&|t| -linearization.scales[0] * a * t.powi(3) / (6.0 * m * m)),
            sampled(&|t| -linearization.scales[1] * a * t * t / (2.0 * m)),
        ];
        let residual = sampled(&|t| position(t, m_true) - position(t, m));
        for i in 0..2 {
            for j in 0..2 {
                let expected = without_line(t, &columns[i], &columns[j]);
                let found = normal.gram[(i, j)];
                assert!((found - expected).abs() < 2e-3 * expected.abs(), "{i} {j}: {found}, not {expected}");
            }
            let expected = without_line(t, &columns[i], &residual);
            let found = normal.gradient[i];
            assert!((found - expected).abs() < 2e-3 * expected.abs(), "{i}: {found}, not {expected}");
        }
    }
}

#[test]
fn estimates_scatter_as_their_standard_deviations_say() {
    let truth = system(&SLIDER.replace("m = 1.0, c = 1.0", "m = 1.03, c = 0.95"));
    let mut scores = Vec::new();
    for seed in 0..20 {
        let mut rng = StdRng::seed_from_u64(100 + seed);
        let record = log(&truth, 2.0, 250.0, 0.0, 2, 0.02, &mut rng);
        let study = Study::new(&system(SLIDER), &[record], &StudySettings::default()).unwrap();
        let fit = study.fit(&[], &all(&study), None).unwrap();
        scores.push((fit.values[0].value - 1.03) / fit.values[0].std);
        scores.push((fit.values[1].value - 0.95) / fit.values[1].std);
    }
    let square: f64 = scores.iter().map(|z| z * z).sum();
    // Chi-square with 40 degrees of freedom: 99.9 % lie between 16.9 and 76.
    assert!((16.9..76.0).contains(&square), "{square}");
    assert!(scores.iter().all(|z| z.abs() < 4.0), "{scores:?}");
}

const EXPLOSIVE: &str =
    "states = ['x']\ninputs = ['u']\nparameters = { a = 1000.0, b = 1.0 }\n[dynamics]\nx = 'a*x^2 + b*u'";

/// From `x = 1` on, `x' = 1000 x²` ends after 1 ms.
#[test]
fn a_window_that_cannot_be_simulated_is_left_out_and_says_why() {
    let times: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.01).collect();
    let x = times.iter().map(|&t| if t < 1.0 { 0.0 } else { 1.0 }).collect();
    let record = exact(times, vec![0.0; 200], Hold::Previous, x, 1e-3);
    let settings = StudySettings { window: Some(0.25), fixed: vec!["a".into()], ..StudySettings::default() };
    let study = Study::new(&system(EXPLOSIVE), &[record], &settings).unwrap();
    let windows = all(&study);
    let fit = study.fit(&[], &windows, None).unwrap();
    for w in &fit.windows {
        let explodes = study.windows()[w.window].from >= 100;
        assert_eq!(w.failure.is_some(), explodes, "{w:?}");
        assert_eq!(w.count > 0, !explodes);
    }
    let late: Vec<usize> = windows.into_iter().filter(|&w| study.windows()[w].from >= 100).collect();
    assert!(matches!(study.fit(&[], &late, None), Err(DiagnoseError::NoWindow { windows: 4, .. })));
}

/// Of `a` and `b` the data tell the product alone; gravity is not fitted at all.
#[test]
fn parameters_that_the_data_cannot_tell_are_listed() {
    let gravity = "{ value = 9.80665, unit = 'm/s²' }";
    let model = SLIDER.replace("m = 1.0, c = 1.0", &format!("a = 1.0, b = 1.0, mu = 0.1, fall = {gravity}"));
    let model = model.replace("(u - c*sign(v))/m", "a*b*u - mu*fall*sign(v)");
    let mut rng = StdRng::seed_from_u64(3);
    let record = log(&system(&model.replace("a = 1.0", "a = 1.2")), 2.0, 500.0, 0.0, 2, 0.01, &mut rng);
    let study = Study::new(&system(&model), &[record], &StudySettings::default()).unwrap();
    let fit = study.fit(&[], &all(&study), None).unwrap();
    let names: Vec<&str> = fit.values.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "mu"]);
    assert_eq!(fit.unidentified, [0, 1]);
    assert!((fit.values[0].value * fit.values[1].value - 1.2).abs() < 5e-3);
}

#[test]
fn a_prediction_from_the_fitted_initial_state_follows_the_data() {
    let mut rng = StdRng::seed_from_u64(4);
    let record = log(&system(SLIDER), 2.0, 500.0, 0.0, 2, 0.01, &mut rng);
    let noise: Vec<f64> = record.measured.iter().map(|m| m.noise).collect();
    let study = Study::new(&system(SLIDER), std::slice::from_ref(&record), &StudySettings::default()).unwrap();
    let predictor = study.predictor(&study.nominal()).unwrap();
    let first = Window { record: 0, from: 200, to: 300 };
    let x0 = predictor.fit_initial_state(first).unwrap().unwrap();
    let predicted = predictor.predict(Window { to: 500, ..first }, &x0).unwrap();
    for (column, (m, noise)) in predicted.iter().zip(record.measured.iter().zip(noise)) {
        let square: f64 = column.iter().zip(&m.values[200..500]).map(|(p, y)| ((p - y) / noise).powi(2)).sum();
        // Chi-square with 300 degrees of freedom has a standard deviation of 24.5; the initial state adds a little.
        assert!((180.0..440.0).contains(&square), "{square}");
    }
    assert!(matches!(predictor.predict(Window { to: 5000, ..first }, &x0), Err(DiagnoseError::NoSuchStretch { .. })));
}

/// Where the model is right, only noise limits, and long windows need fewer initial states.
#[test]
fn with_the_right_model_long_windows_are_best() {
    let mut rng = StdRng::seed_from_u64(5);
    let record = log(&system(SLIDER), 4.0, 500.0, 0.0, 1, 0.01, &mut rng);
    let study = Study::new(&system(SLIDER), &[record], &StudySettings::default()).unwrap();
    let (study, fit) = study.with_best_windows(&[], None).unwrap();
    let lengths = study.window_lengths();
    assert!(lengths.len() > 1);
    assert!(lengths.windows(2).all(|w| w[0].uncertainty > w[1].uncertainty), "{lengths:?}");
    assert_eq!(study.windows().len(), 16);
    assert_eq!(fit.windows.len(), 16);
}

const SPRING: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    parameters = { m = 1.0, k = 20.0, d = 0.5 }
    [dynamics]
    x = "v"
    v = "(u - k*x - d*v)/m"
"#;

/// A spring of 20 N/m.
fn spring_log(seed: u64) -> Record {
    log(&system(SPRING), 6.0, 100.0, 0.0, 2, 0.01, &mut StdRng::seed_from_u64(seed))
}

fn with_stiffness(k: &str) -> System {
    system(&SPRING.replace("k = 20.0", &format!("k = {k}")))
}

/// Three and a half times the truth, and a quarter of it: the range moves with the fit. From ten times the truth no way leads back,
/// and the fit says that it stopped.
#[test]
fn a_parameter_that_is_wrong_by_far_is_found() {
    for (seed, k) in [(10, "70.0"), (12, "5.0")] {
        let study = Study::new(&with_stiffness(k), &[spring_log(seed)], &StudySettings::default()).unwrap();
        let fit = study.fit(&[], &all(&study), None).unwrap();
        assert_eq!(fit.limited, [0; 0], "{k}: {:?}", fit.values);
        assert_recovered(&fit, "k", 20.0, 0.2);
    }
    let study = Study::new(&with_stiffness("200.0"), &[spring_log(11)], &StudySettings::default()).unwrap();
    assert!(study.fit(&[], &all(&study), None).unwrap().limited.contains(&1));
}

/// Limits of the model file hold, narrower or wider than what a refit may do without them.
#[test]
fn limits_of_the_model_file_win() {
    let fit = |k: &str| {
        let study = Study::new(&with_stiffness(k), &[spring_log(14)], &StudySettings::default()).unwrap();
        study.fit(&[], &all(&study), None).unwrap()
    };
    let narrow = fit("{ value = 12.0, max = 15.0 }");
    assert_eq!((narrow.values[1].value, narrow.limited.as_slice()), (15.0, [1].as_slice()));
    let wide = fit("{ value = 1.0, min = 0.1, max = 1000.0 }");
    assert_recovered(&wide, "k", 20.0, 0.2);
    assert_eq!(wide.limited, [0; 0]);
}

#[test]
fn a_value_at_its_limit_has_a_note_and_no_interval() {
    let model = with_stiffness("{ value = 19.0, max = 19.9 }");
    let report = diagnose(&model, &[spring_log(15)], &[], &DiagnosisSettings::default(), &mut |_| {}).unwrap();
    let k = report.parameters.iter().find(|p| p.name == "k").unwrap();
    assert_eq!((k.after, k.interval), (19.9, None));
    assert!(
        report
            .notes
            .iter()
            .any(|n| matches!(n, Note::AtLimit { name, value, .. } if name == "k" && (value - 19.9).abs() < 0.005)),
        "{:?}",
        report.notes
    );
    for p in report.parameters.iter().filter(|p| p.name != "k") {
        let [low, high] = p.interval.unwrap();
        assert!(low <= p.after && p.after <= high, "{p:?}");
    }
}

#[test]
fn a_model_that_cannot_be_simulated_names_the_parameter_that_is_zero() {
    let model = system(&SPRING.replace("m = 1.0", "m = 0.0"));
    let study = Study::new(&model, &[spring_log(16)], &StudySettings::default()).unwrap();
    let error = study.fit(&[], &all(&study), None).unwrap_err().to_string();
    assert!(error.ends_with("if the equations divide by `m` = 0, give another value"), "{error}");
}
