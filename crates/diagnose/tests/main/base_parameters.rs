//! Parameters of which the data determine only a combination.

use crate::tier;
use std::collections::BTreeMap;

use bracketry_diagnose::{Cause, DiagnosisSettings, Note, Record, RecordSettings, Report, Verdict, diagnose};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

const STEP: f64 = 0.01;

/// A speed with a gain `a*b` that the run takes `factor` times as large, and a loss `c`; `b` is known or not.
fn driven(a: f64, b: f64, known: bool, factor: f64, seed: u64) -> Report {
    let b_entry = format!("{{ value = {b}, fixed = {known} }}");
    let model = format!(
        "states = ['v']\ninputs = ['u']\nparameters = {{ a = {a}, b = {b_entry}, c = 0.8 }}\n[dynamics]\nv = 'a*b*u - c*v'"
    );
    let system = System::parse("product.toml", &model).unwrap();
    let mut random = StdRng::seed_from_u64(seed);
    let noise = Normal::new(0.0, 0.005 * a * b).unwrap();
    let (mut v, mut times) = ([0.0], Vec::new());
    let mut columns = BTreeMap::from(["u", "v"].map(|name| (name.to_owned(), Vec::new())));
    for k in 0..1200 {
        let t = k as f64 * STEP;
        let u = (1.1 * t).sin() + 0.6 * (2.9 * t).cos();
        times.push(t);
        columns.get_mut("u").unwrap().push(u);
        columns.get_mut("v").unwrap().push(v[0] + noise.sample(&mut random));
        for _ in 0..10 {
            v = crate::integrate::step(|v: &[f64; 1], _: f64| [factor * a * b * u - 0.8 * v[0]], &v, STEP / 10.0);
        }
    }
    let record = Record::from_columns("run.csv", times, columns, &system, &RecordSettings::default()).unwrap();
    diagnose(&system, &[record], &[], &DiagnosisSettings::default(), &mut |_| {}).unwrap()
}

#[test]
fn a_combination_that_has_left_its_tolerance_is_named_and_no_single_parameter() {
    for seed in 0..tier::cases(5, 12) {
        let mut random = StdRng::seed_from_u64(seed);
        let (a, b) = (random.random_range(0.3..3.0), random.random_range(0.3..3.0));
        let factor =
            if random.random_bool(0.5) { random.random_range(1.3..1.9) } else { random.random_range(0.5..0.75) };
        let report = driven(a, b, false, factor, seed);
        assert_eq!(report.verdict, Verdict::CauseFound, "seed {seed}: {:?}", report.reason);
        let [cause] = report.causes.as_slice() else { panic!("seed {seed}: {:?}", report.causes) };
        assert_eq!(cause.name, Cause::ParameterError);
        let combination = cause.combination.as_ref().unwrap();
        let weight = |name: &str| combination.weights.get(name).copied().unwrap_or(0.0);
        assert!((weight("a") - weight("b")).abs() < 0.02 && weight("a") > 0.4, "seed {seed}: {combination:?}");
        assert_eq!(combination.change > 0.0, factor > 1.0, "seed {seed}: {combination:?}");
        assert!(combination.as_given.is_some_and(|size| size > 3.0), "seed {seed}: {combination:?}");
        // Either of the two explains the data alone, with the factor; the loss does not.
        let names: Vec<&str> = combination.alone.iter().map(|(name, _)| name.as_str()).collect();
        assert!(names.len() == 2 && names.contains(&"a") && names.contains(&"b"), "seed {seed}: {combination:?}");
        for (name, value) in combination.alone.iter() {
            let given = if name == "a" { a } else { b };
            assert!((value.value / given - factor).abs() < 0.02 * factor, "seed {seed}: {combination:?}");
        }
    }
}

#[test]
fn combinations_within_their_tolerances_are_calibration() {
    for seed in 20..30 {
        let mut random = StdRng::seed_from_u64(seed);
        let (a, b) = (random.random_range(0.3..3.0), random.random_range(0.3..3.0));
        let report = driven(a, b, false, random.random_range(0.9..1.1), seed);
        assert_eq!(report.verdict, Verdict::NothingFound, "seed {seed}: {:?}", report.causes);
        let alone = |n: &Note| matches!(n, Note::HardlyIdentifiable(names) | Note::OnlyInCombination(names) if names.len() == 2);
        assert!(report.notes.iter().any(alone), "{:?}", report.notes);
        assert!(!report.notes.iter().any(|n| matches!(n, Note::NoInterval(_))), "{:?}", report.notes);
    }
}

#[test]
fn a_parameter_beside_a_fixed_one_is_named() {
    for seed in 40..46 {
        let mut random = StdRng::seed_from_u64(seed);
        let (a, b) = (random.random_range(0.3..3.0), random.random_range(0.3..3.0));
        let factor = random.random_range(1.3..1.9);
        let report = driven(a, b, true, factor, seed);
        let [cause] = report.causes.as_slice() else { panic!("seed {seed}: {:?}", report.causes) };
        let value = cause.parameters.get("a").unwrap().value;
        assert!((value / a - factor).abs() < 0.02 * factor && cause.combination.is_none(), "seed {seed}: {cause:?}");
        assert!(report.notes.contains(&Note::Fixed(vec!["b".into()])), "{:?}", report.notes);
        assert!(report.parameters.iter().all(|p| p.name != "b"));
    }
}
