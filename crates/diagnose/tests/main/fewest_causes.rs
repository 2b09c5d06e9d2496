//! Of two sets of causes that explain the data, the smaller one is named.

use crate::tier;
use std::collections::BTreeMap;

use bracketry_diagnose::{Cause, DiagnosisSettings, NamedCause, Record, RecordSettings, Report, diagnose};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

const STEP: f64 = 5.0;

/// A heated body and a cooled one, and what the model lacks: a loss of the first to surroundings at 20 degrees.
fn exchanger(seed: u64) -> Report {
    let mut random = StdRng::seed_from_u64(seed);
    let mut around = |value: f64| value * random.random_range(0.8..1.25);
    let (ch, cc, ua, mh, loss) = (around(5200.0), around(6900.0), around(63.0), around(88.0), around(20.0));
    let model = format!(
        "states = ['h', 'c']\ninputs = ['a', 'm']\nparameters = {{ Ch = {ch}, Cc = {cc}, UA = {ua}, w = {mh} }}\n[dynamics]\n\
         h = '(w*(a - h) - UA*(h - c))/Ch'\nc = '(4180*m*(14 - c) + UA*(h - c))/Cc'"
    );
    let system = System::parse("exchanger.toml", &model).unwrap();
    let noise = Normal::new(0.0, 0.06).unwrap();
    let (mut z, mut times) = ([50.0, 25.0], Vec::new());
    let mut columns = BTreeMap::from(["a", "m", "h", "c"].map(|name| (name.to_owned(), Vec::new())));
    let (mut a, mut m) = (60.0, 0.02);
    for n in 0..1200 {
        if n % 60 == 0 {
            (a, m) = (random.random_range(45.0..72.0), random.random_range(0.012..0.03));
        }
        times.push(f64::from(n) * STEP);
        let measured =
            [("a", a), ("m", m), ("h", z[0] + noise.sample(&mut random)), ("c", z[1] + noise.sample(&mut random))];
        for (name, value) in measured {
            columns.get_mut(name).unwrap().push(value);
        }
        let rate = |z: &[f64; 2], _: f64| {
            [
                (mh * (a - z[0]) - ua * (z[0] - z[1]) - loss * (z[0] - 20.0)) / ch,
                (4180.0 * m * (14.0 - z[1]) + ua * (z[0] - z[1])) / cc,
            ]
        };
        for _ in 0..10 {
            z = crate::integrate::step(rate, &z, STEP / 10.0);
        }
    }
    let record = Record::from_columns("run.csv", times, columns, &system, &RecordSettings::default()).unwrap();
    diagnose(&system, &[record], &[], &DiagnosisSettings::default(), &mut |_| {}).unwrap()
}

/// A loss to surroundings is a leak and a constant. A gain of the inlet, a constant, and another flow say the same with one thing more.
#[test]
fn causes_without_a_moved_parameter_come_before_those_with_one() {
    for seed in 0..tier::cases(2, 6) {
        let report = exchanger(seed);
        let names: Vec<Cause> = report.causes.iter().map(|c| c.name).collect();
        assert!(names.len() <= 2 && !names.contains(&Cause::ParameterError), "seed {seed}: {names:?}");
        // Where parameters within their tolerances make the gain equal to the leak, the report says that it may be either.
        let stated = |c: &NamedCause| c.name == Cause::Leak || c.confusable_with.contains(&Cause::Leak);
        assert!(report.causes.iter().any(stated), "seed {seed}: {:?}", report.causes);
    }
}
