//! Columns on another scale of temperature.

use crate::tier;
use std::collections::BTreeMap;

use bracketry_diagnose::{
    ColumnFault, DiagnosisSettings, Outcome, Record, RecordSettings, Report, Rescaling, ScaledColumn, TemperatureScale,
    Verdict, diagnose,
};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

const STEP: f64 = 2.0;

/// Two bodies, of which one is heated, and the surroundings. The columns are those of the model but for `column`, whose values are as `changed`.
fn heated(seed: u64, column: &str, changed: impl Fn(f64) -> f64) -> Report {
    let mut random = StdRng::seed_from_u64(seed);
    let [c1, c2, k, loss] = [(), (), (), ()].map(|()| random.random_range(0.7..1.4));
    let model = format!(
        "states = ['a', 'b']\ninputs = ['p', 's']\nparameters = {{ C1 = {}, C2 = {}, k = {}, c = {} }}\n[dynamics]\n\
         a = '(p - k*(a - b))/C1'\nb = '(k*(a - b) - c*(b - s))/C2'",
        50.0 * c1,
        80.0 * c2,
        k,
        loss
    );
    let system = System::parse("bodies.toml", &model).unwrap();
    let noise = Normal::new(0.0, 0.05).unwrap();
    let (mut z, mut times) = ([60.0, 40.0], Vec::new());
    let mut columns = BTreeMap::from(["p", "s", "a", "b"].map(|name| (name.to_owned(), Vec::new())));
    for n in 0..600 {
        let t = f64::from(n) * STEP;
        times.push(t);
        let power = 30.0 + 20.0 * (t / 90.0).sin() + 10.0 * (t / 23.0).cos();
        let around = 15.0 + 5.0 * (t / 150.0).sin();
        let values = [
            ("p", power),
            ("s", around),
            ("a", z[0] + noise.sample(&mut random)),
            ("b", z[1] + noise.sample(&mut random)),
        ];
        for (name, value) in values {
            let value = if name == column { changed(value) } else { value };
            columns.get_mut(name).unwrap().push(value);
        }
        let rate = |z: &[f64; 2], _: f64| {
            [(power - k * (z[0] - z[1])) / (50.0 * c1), (k * (z[0] - z[1]) - loss * (z[1] - around)) / (80.0 * c2)]
        };
        for _ in 0..10 {
            z = crate::integrate::step(rate, &z, STEP / 10.0);
        }
    }
    let record = Record::from_columns("run.csv", times, columns, &system, &RecordSettings::default()).unwrap();
    diagnose(&system, &[record], &[], &DiagnosisSettings::default(), &mut |_| {}).unwrap()
}

#[test]
fn another_scale_of_a_column_is_named() {
    use TemperatureScale::{Celsius, Fahrenheit, Kelvin};
    for seed in 0..tier::cases(1, 4) {
        for column in ["a", "b", "s"] {
            for (from, factor, offset) in [(Kelvin, 1.0, 273.15), (Fahrenheit, 1.8, 32.0)] {
                let report = heated(seed, column, |c| factor * c + offset);
                assert_eq!(report.verdict, Verdict::WrongUnit, "{seed} {column} {from:?}: {:?}", report.reason);
                let Outcome::WrongColumns { fault, .. } = &report.reason.outcome else { panic!("{:?}", report.reason) };
                let by = Rescaling::Temperature { from, to: Celsius };
                let columns = ScaledColumn::Column(column.to_owned());
                // Where the surroundings are in kelvin, the rest may as well be in degrees Celsius.
                let rival = report.causes[0].rivals.iter().any(|r| r.equation == column);
                assert!(*fault == ColumnFault::Scaled { columns, by } || rival, "{seed}: {:?}", report.causes);
            }
        }
    }
}

/// An offset of a sensor that is no difference of scales stays an offset.
#[test]
fn an_offset_is_no_scale() {
    for (seed, offset) in [(0, 250.0), (1, 32.0), (2, -12.0), (3, 3.0)].into_iter().take(tier::cases(2, 4) as usize) {
        let report = heated(seed, "a", |c| c + offset);
        assert_ne!(report.verdict, Verdict::WrongUnit, "{offset}");
    }
    assert_eq!(heated(5, "", |c| c).verdict, Verdict::NothingFound);
}
