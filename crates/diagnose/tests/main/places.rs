//! Where a model is wrong, and what it misses over time.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use bracketry_diagnose::{DiagnosisSettings, Place, Record, RecordSettings, Regime, Report, StudySettings, diagnose};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

/// Time between samples, s.
const STEP: f64 = 0.01;

/// A run of ten seconds under a held random multisine, with noise of `share` of each column's size on the columns named.
fn run<const N: usize>(
    system: &System,
    rate: impl Fn(&[f64; N], f64) -> [f64; N],
    x0: [f64; N],
    (input, size): (&str, f64),
    (columns, share): (&[(&str, usize)], f64),
) -> (Record, Vec<[f64; N]>) {
    let mut random = StdRng::seed_from_u64(7);
    let lines: Vec<(f64, f64)> =
        (0..12).map(|_| (random.random_range(0.2..2.0), random.random_range(0.0..TAU))).collect();
    let times: Vec<f64> = (0..1000).map(|k| f64::from(k) * STEP).collect();
    let u: Vec<f64> =
        times.iter().map(|t| size * lines.iter().map(|(f, p)| (TAU * f * t + p).sin()).sum::<f64>()).collect();
    let mut x = x0;
    let mut states = Vec::new();
    for &u in &u {
        states.push(x);
        for _ in 0..10 {
            x = crate::integrate::step(|x, _| rate(x, u), &x, STEP / 10.0);
        }
    }
    let mut table = BTreeMap::from([(input.to_owned(), u)]);
    for &(name, state) in columns {
        let values: Vec<f64> = states.iter().map(|x| x[state]).collect();
        let size = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
        let noise = Normal::new(0.0, share * size).unwrap();
        table.insert(name.to_owned(), values.iter().map(|v| v + noise.sample(&mut random)).collect());
    }
    (Record::from_columns("run.csv", times, table, system, &RecordSettings::default()).unwrap(), states)
}

/// The verdict with the first parameter, a mass, at its value.
fn verdict(system: &System, record: Record) -> Report {
    let study = StudySettings {
        fixed: vec![system.symbol_name(system.parameters[0].symbol).to_owned()],
        ..StudySettings::default()
    };
    diagnose(system, &[record], &[], &DiagnosisSettings { study, ..DiagnosisSettings::default() }, &mut |_| {}).unwrap()
}

fn sum(places: &[Place], of: impl Fn(&Place) -> bool) -> f64 {
    places.iter().filter(|p| of(p)).map(|p| p.share).sum()
}

/// A cart with a hanging pendulum; viscous friction of the cart accelerates both.
const CART: &str = r#"
    states = ["p", "th", "v", "w"]
    inputs = ["F"]
    parameters = { M = 1.0, m = 0.2, l = 0.5, g = 9.81 }
    [definitions]
    D = "M + m*sin(th)^2"
    [dynamics]
    p = "v"
    th = "w"
    v = "(F + m*sin(th)*(l*w^2 + g*cos(th)))/D"
    w = "(-F*cos(th) - m*l*w^2*cos(th)*sin(th) - (M+m)*g*sin(th))/(l*D)"
"#;

#[test]
fn friction_of_a_cart_is_in_the_equation_of_the_cart() {
    let system = System::parse("cart.toml", CART).unwrap();
    let (mass, bob, length, gravity, damping) = (1.0, 0.2, 0.5, 9.81, 0.8);
    let rate = |x: &[f64; 4], u: f64| {
        let [_, th, v, w] = *x;
        let (s, c) = th.sin_cos();
        let d = mass + bob * s * s;
        let force = u - damping * v;
        [
            v,
            w,
            (force + bob * s * (length * w * w + gravity * c)) / d,
            (-force * c - bob * length * w * w * c * s - (mass + bob) * gravity * s) / (length * d),
        ]
    };
    let (record, _) = run(&system, rate, [0.0, 0.3, 0.0, 0.0], ("F", 0.8), (&[("p", 0), ("th", 1)], 0.002));
    let report = verdict(&system, record);
    assert!(!report.places.is_empty(), "{report:?}");
    assert!(sum(&report.places, |p| p.equation == "v") > 0.8, "{report:?}");
    assert!((sum(&report.places, |_| true) - 1.0).abs() < 1e-9);
    // By tilt the same error, once more.
    let tilted =
        sum(&report.regimes, |p| p.equation == "v" && matches!(&p.regime, Regime::Tilt { name, .. } if name == "th"));
    assert!((tilted - sum(&report.places, |p| p.equation == "v")).abs() < 0.05, "{report:?}");
}

#[test]
fn what_is_missing_over_time_is_the_force_per_mass_with_the_scatter_that_it_says() {
    let text = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 2 }\n[dynamics]\nx = 'v'\nv = '(u - 8*x)/m'";
    let system = System::parse("block.toml", text).unwrap();
    let rate = |x: &[f64; 2], u: f64| [x[1], (u - 8.0 * x[0] - 1.5 * x[1]) / 2.0];
    let (record, states) = run(&system, rate, [0.2, 0.0], ("u", 2.0), (&[("x", 0), ("v", 1)], 0.01));
    let report = verdict(&system, record);
    let [missing] = report.residual_acceleration.as_slice() else { panic!("{report:?}") };
    assert_eq!((missing.equation.as_str(), missing.record.as_str()), ("v", "run.csv"));
    let mut square = 0.0;
    for (t, value) in missing.times.iter().zip(&missing.values) {
        let [_, v] = states[(t / STEP).round() as usize];
        square += (value + 0.75 * v).powi(2);
    }
    let scatter = (square / missing.values.len() as f64).sqrt();
    assert!(missing.values.len() > 300 && missing.std > 0.0);
    assert!(scatter < 3.0 * missing.std, "{scatter} {}", missing.std);
    let largest = missing.values.iter().map(|v| v.abs()).fold(0.0, f64::max);
    assert!(largest > 10.0 * missing.std, "{largest} {}", missing.std);
    // Friction acts either way, and not at rest.
    let moving = sum(&report.places, |p| matches!(p.regime, Regime::Motion { sliding: false, .. }));
    let near_zero = sum(&report.places, |p| matches!(p.regime, Regime::Reversal { .. } | Regime::Rest { .. }));
    assert!(moving > 0.9 && near_zero < 0.05, "{report:?}");
    let rate = sum(&report.regimes, |p| matches!(&p.regime, Regime::Rate { name, .. } if name == "v"));
    let position = sum(&report.regimes, |p| matches!(&p.regime, Regime::Third { name, .. } if name == "x"));
    for share in [rate, position] {
        assert!((share - 1.0).abs() < 0.05, "{share}: {report:?}");
    }
}

#[test]
fn the_ranking_has_intervals_that_hold_the_share_and_narrow_where_it_is_sure() {
    let text = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 2 }\n[dynamics]\nx = 'v'\nv = '(u - 8*x)/m'";
    let system = System::parse("block.toml", text).unwrap();
    let rate = |x: &[f64; 2], u: f64| [x[1], (u - 8.0 * x[0] - 1.5 * x[1]) / 2.0];
    let (record, _) = run(&system, rate, [0.2, 0.0], ("u", 2.0), (&[("x", 0), ("v", 1)], 0.01));
    let report = verdict(&system, record);
    assert!(report.candidates.len() > 2, "{report:?}");
    for c in &report.candidates {
        let ([low, high], share) = (c.interval.unwrap(), c.share.unwrap());
        assert!(low <= share && share <= high && high - low < 1.0, "{report:?}");
    }
    let first = &report.candidates[0];
    let [low, high] = first.interval.unwrap();
    assert!(first.chosen && high - low < 0.1 && high - low > 0.0, "{report:?}");
}
