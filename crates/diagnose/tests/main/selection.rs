//! What is named and what is not: laws outside the library, parameters far off, parameters held by their limits.

use std::collections::BTreeMap;

use bracketry_diagnose::{
    Cause, DiagnosisSettings, Note, Record, RecordSettings, Report, Verdict, diagnose, reference_candidates,
};
use bracketry_system::System;
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

/// Two sines with an offset.
fn input(t: f64, slow: f64) -> f64 {
    (slow * t).sin() + 0.7 * (2.7 * slow * t + 1.0).sin()
}

/// Runs `rate` from `x0` by the classical method of Runge and Kutta, the input held; all states are measured with noise.
fn run<const N: usize>(
    system: &System,
    (count, dt, noise): (usize, f64, f64),
    mut x: [f64; N],
    drive: impl Fn(f64) -> f64,
    rate: impl Fn(&[f64; N], f64) -> [f64; N],
) -> Record {
    let random = &mut StdRng::seed_from_u64(3);
    let (mut times, mut u, mut states) = (Vec::new(), Vec::new(), vec![Vec::new(); N]);
    for k in 0..count {
        let t = k as f64 * dt;
        let held = drive(t);
        times.push(t);
        u.push(held);
        for (column, x) in states.iter_mut().zip(&x) {
            let kick: f64 = StandardNormal.sample(random);
            column.push(x + noise * kick);
        }
        let h = 0.1 * dt;
        for _ in 0..10 {
            let moved = |by: &[f64; N], s: f64| std::array::from_fn(|i| x[i] + s * by[i]);
            let a = rate(&x, held);
            let b = rate(&moved(&a, 0.5 * h), held);
            let c = rate(&moved(&b, 0.5 * h), held);
            let d = rate(&moved(&c, h), held);
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
    }
    let mut columns: BTreeMap<String, Vec<f64>> = system.state_names().into_iter().zip(states).collect();
    columns.insert(system.input_names()[0].clone(), u);
    Record::from_columns("run", times, columns, system, &RecordSettings::default()).unwrap()
}

fn verdict(system: &System, record: &Record, settings: &DiagnosisSettings) -> Report {
    diagnose(system, std::slice::from_ref(record), &[], settings, &mut |_| ()).unwrap()
}

fn tank(parameters: &str, outflow: &str) -> System {
    let text = format!(
        "states = ['h']\ninputs = ['q']\nparameters = {{ A = 0.5, {parameters} }}\n[dynamics]\nh = '(q - {outflow})/A'\n"
    );
    System::parse("tank", &text).unwrap()
}

/// A tank that empties by Torricelli's law, 0.5 √h.
fn emptying(system: &System) -> Record {
    let drive = |t: f64| 0.5 + 0.15 * input(t, 0.1);
    run(system, (1500, 0.1, 2e-3), [1.0], drive, |h, q| [(q - 0.5 * h[0].max(0.0).sqrt()) / 0.5])
}

#[test]
fn one_term_without_a_name_is_not_helped_by_a_sensor() {
    let system = tank("k = 0.4", "k*h");
    let report = verdict(&system, &emptying(&system), &DiagnosisSettings::default());
    let names: Vec<Cause> = report.causes.iter().map(|c| c.name).collect();
    assert_eq!(names, [Cause::UnknownTerm], "{:?}", report.causes);
}

#[test]
fn a_law_of_a_reference_takes_the_place_of_one_with_the_same_parameter() {
    let (system, reference) = (tank("k = 0.4", "k*h"), tank("k = 0.4", "k*sqrt(h)"));
    let settings = DiagnosisSettings {
        candidates: reference_candidates(&system, &reference).unwrap(),
        ..DiagnosisSettings::default()
    };
    let report = verdict(&system, &emptying(&system), &settings);
    assert_eq!(report.causes.len(), 1, "{:?}", report.causes);
    let (_, amplitude) = &report.causes[0].parameters[0];
    assert!((amplitude.value - 1.0).abs() < 0.05, "{:?}", report.causes[0]);
    let k = report.parameters.iter().find(|p| p.name == "k").unwrap();
    assert!((k.after - 0.5).abs() < 0.02, "{}", k.after);
}

fn spring(k: &str) -> System {
    let text = format!(
        "states = ['x', 'v']\ninputs = ['F']\n[parameters]\nm = 1.0\nc = 0.5\nk = {k}\n[dynamics]\nx = 'v'\nv = '(F - k*x - c*v)/m'\n"
    );
    System::parse("spring", &text).unwrap()
}

/// A spring of 20 N/m.
fn swinging(system: &System) -> Record {
    let drive = |t: f64| 3.0 * input(t, 2.0);
    run(system, (1000, 0.01, 2e-3), [0.1, 0.0], drive, |x, force| [x[1], force - 20.0 * x[0] - 0.5 * x[1]])
}

#[test]
fn a_parameter_that_is_ten_times_off_is_the_cause() {
    for given in ["200.0", "2.0"] {
        let system = spring(given);
        let report = verdict(&system, &swinging(&system), &DiagnosisSettings::default());
        let causes: Vec<_> = report.causes.iter().map(|c| (c.name, c.parameters[0].0.as_str())).collect();
        assert_eq!(causes, [(Cause::ParameterError, "k")], "{given}: {:?}", report.causes);
        assert!((report.causes[0].parameters[0].1.value - 20.0).abs() < 0.5, "{:?}", report.causes[0]);
    }
}

#[test]
fn what_a_limit_holds_back_gets_no_term_of_its_own() {
    let system = tank("k = { value = 0.2, min = 0.1, max = 0.3 }", "k*h");
    let drive = |t: f64| 0.5 + 0.15 * input(t, 0.1);
    let record = run(&system, (1500, 0.1, 2e-3), [1.0], drive, |h, q| [(q - 0.45 * h[0]) / 0.5]);
    let report = verdict(&system, &record, &DiagnosisSettings::default());
    assert!(report.causes.iter().all(|c| c.name != Cause::UnknownTerm), "{:?}", report.causes);
    assert_ne!(report.verdict, Verdict::NothingFound);
    assert!(report.notes.iter().any(|n| matches!(n, Note::AtLimit { name, .. } if name == "k")), "{:?}", report.notes);
}

#[test]
fn a_search_that_ends_at_the_number_of_causes_allowed_says_so() {
    let text = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 1 }\n[dynamics]\nx = 'v'\nv = 'u/m'\n";
    let system = System::parse("cart", text).unwrap();
    let drive = |t: f64| 2.0 * input(t, 1.3);
    let record = run(&system, (800, 0.01, 2e-3), [0.0, 0.0], drive, |x, u| [x[1], u - 0.8 * x[1] - 3.0 * x[0]]);
    let named = |most: usize| {
        let report = verdict(&system, &record, &DiagnosisSettings { max_causes: most, ..DiagnosisSettings::default() });
        let ended = report.notes.iter().any(|note| matches!(note, Note::MostCauses { .. }));
        (report.causes.iter().map(|c| c.name).collect::<Vec<_>>(), ended)
    };
    let (one, ended) = named(1);
    assert!(one.len() == 1 && ended, "{one:?}");
    let (mut both, ended) = named(3);
    both.sort();
    assert_eq!(both, [Cause::ViscousFriction, Cause::LinearStiffness]);
    assert!(!ended);
}

#[test]
fn a_changed_setting_changes_what_is_named() {
    let text = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 1 }\n[dynamics]\nx = 'v'\nv = 'u/m'\n";
    let system = System::parse("cart", text).unwrap();
    let drive = |t: f64| 2.0 * input(t, 1.3);
    let record = run(&system, (800, 0.01, 2e-3), [0.0, 0.0], drive, |x, u| [x[1], u - 0.01 * x[1]]);
    let named = |settings: DiagnosisSettings| {
        let report = verdict(&system, &record, &settings);
        report.causes.into_iter().map(|c| c.name).collect::<Vec<_>>()
    };
    assert_eq!(named(DiagnosisSettings::default()), [Cause::ViscousFriction]);
    // Nothing is that significant, and nothing moves that far.
    assert_eq!(named(DiagnosisSettings { significance: 0.0, ..DiagnosisSettings::default() }), []);
    let mut strict = DiagnosisSettings::default();
    strict.verdict.alarm.motion_spread = 1e9;
    assert_eq!(named(strict), []);
}
