//! Refitting and linearizing: a slider over 8 s at 1 kHz, position and velocity measured. Items are samples of the record.

use bracketry_diagnose::{Cause, Change, Coefficient, Effect, Record, RecordSettings, Role, Study, StudySettings};
use bracketry_system::System;
use bracketry_trials::{Slider, SliderSensors};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use rand::SeedableRng;
use rand::rngs::StdRng;
use std::collections::BTreeMap;

fn main() {
    divan::main();
}

fn study() -> Study {
    let mut random = StdRng::seed_from_u64(1);
    let slider = Slider::basic(SliderSensors::PositionAndVelocity, &mut random);
    let log = slider.run(&[], 1).expect("a log");
    let system = System::parse("slider.toml", &log.model).expect("a model");
    let mut columns: BTreeMap<String, Vec<f64>> = log.columns.into_iter().collect();
    let times = columns.remove("t").expect("times");
    let record = Record::from_columns("log", times, columns, &system, &RecordSettings::default()).expect("a record");
    Study::new(&system, &[record], &StudySettings::default()).expect("a study")
}

/// `count` terms that are no multiples of each other.
fn candidates(count: usize) -> Vec<Effect> {
    let term = |i: usize| match i % 3 {
        0 => format!("-k{i}*v*abs(v)^{}", i / 3),
        1 => format!("k{i}*sin({}*x)", 1 + i),
        _ => format!("-k{i}*sign(v)*exp(-abs(v)*{i})"),
    };
    (0..count)
        .map(|i| Effect {
            cause: Cause::UnknownTerm,
            equation: "v".into(),
            term: term(i).as_str().into(),
            coefficients: vec![Coefficient {
                name: format!("k{i}"),
                role: Role::Amplitude,
                nominal: 0.0,
                scale: 1.0,
                min: f64::NEG_INFINITY,
                max: f64::INFINITY,
                trials: Vec::new(),
                physical_sign: 0,
                sign_flipped: None,
                period_of: None,
                unit: String::new(),
                about: String::new(),
            }],
            change: Change::Terms(vec![("v".into(), term(i))]),
        })
        .collect()
}

#[divan::bench]
fn refit(bencher: Bencher) {
    let study = study();
    let windows: Vec<usize> = (0..study.windows().len()).collect();
    let samples = study.records()[0].times.len();
    bencher.counter(ItemsCount::new(samples)).bench_local(|| black_box(study.fit(&[], &windows, None)));
}

#[divan::bench]
fn linearize_30_candidates(bencher: Bencher) {
    let study = study();
    let windows: Vec<usize> = (0..study.windows().len()).collect();
    let fit = study.fit(&[], &windows, None).expect("a fit");
    let candidates = candidates(30);
    let samples = study.records()[0].times.len();
    bencher.counter(ItemsCount::new(samples)).bench_local(|| black_box(study.linearize(&fit, &candidates, &windows)));
}
