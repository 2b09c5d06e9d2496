//! Tables that are not clean: what is left out, what is filled, and what a run is afterwards.

use std::collections::BTreeMap;

use bracketry_diagnose::{DiagnoseError, Record, RecordSettings, Warning};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

const STEP: f64 = 0.01;
const ROWS: usize = 1000;

/// A table of `t, u, x, v` whose inputs and positions are smooth.
#[derive(Clone)]
struct Rows(Vec<[f64; 4]>);

impl Rows {
    fn new() -> Self {
        let row = |k: usize| {
            let t = k as f64 * STEP;
            [t, (2.0 * t).sin(), 0.3 * (1.3 * t).cos() + 0.2, -0.39 * (1.3 * t).sin()]
        };
        Rows((0..ROWS).map(row).collect())
    }

    fn read(&self) -> Result<Record, DiagnoseError> {
        let column = |k: usize| self.0.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let columns = [("u", 1), ("x", 2), ("v", 3)].map(|(name, k)| (name.to_owned(), column(k)));
        let text = "states = ['x', 'v']\ninputs = ['u']\n[dynamics]\nx = 'v'\nv = 'u - x'";
        let system = System::parse("spring.toml", text).unwrap();
        Record::from_columns("run", column(0), BTreeMap::from(columns), &system, &RecordSettings::default())
    }

    /// The run and its warnings, all in one text.
    fn run(&self) -> (Record, String) {
        let record = self.read().unwrap();
        let warnings = &record.audit.as_ref().unwrap().warnings;
        let text = warnings.iter().map(Warning::message).collect::<Vec<_>>().join("; ");
        (record, text)
    }
}

fn lost(record: &Record, column: usize) -> Vec<usize> {
    let values = &record.measured[column].values;
    (0..values.len()).filter(|&k| values[k].is_nan()).collect()
}

/// Positions, apart from each other, in the middle of a table.
fn places(random: &mut StdRng, count: usize) -> Vec<usize> {
    (0..count).map(|k| 50 + k * (ROWS - 100) / count + random.random_range(0..20)).collect()
}

#[test]
fn a_clean_table_stays_as_it_is() {
    let (record, warnings) = Rows::new().run();
    assert_eq!((record.times.len(), warnings.as_str()), (ROWS, ""));
}

#[test]
fn repeated_rows_are_left_out() {
    let mut rows = Rows::new();
    for k in places(&mut StdRng::seed_from_u64(1), 7).into_iter().rev() {
        rows.0.insert(k, rows.0[k]);
    }
    let (record, warnings) = rows.run();
    assert_eq!(record, Record { audit: record.audit.clone(), ..Rows::new().run().0 });
    assert!(warnings.contains("7 repeated rows left out"), "{warnings}");
}

#[test]
fn rounded_times_are_spread_evenly() {
    for digits in [0, 1] {
        let mut rows = Rows::new();
        let unit = 10f64.powi(digits);
        rows.0.iter_mut().for_each(|row| row[0] = ((row[0] + 1e-9) * unit).floor() / unit);
        let (record, warnings) = rows.run();
        let worst = record.times.iter().enumerate().map(|(k, t)| (t - k as f64 * STEP).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9 && record.gaps.is_empty(), "{digits} digits: {worst}");
        assert!(warnings.contains("the time of the row before"), "{warnings}");
    }
}

#[test]
fn numbers_that_stand_for_lost_values_are_lost() {
    for (seed, mark) in [(2, -9999.0), (3, 32_767.0), (4, 1e30), (5, -999.0), (6, 99_999.0)] {
        let mut rows = Rows::new();
        let at = places(&mut StdRng::seed_from_u64(seed), 6);
        for &k in &at {
            rows.0[k][2] = mark;
        }
        let (record, warnings) = rows.run();
        assert_eq!(lost(&record, 1), at, "{mark}: {warnings}");
        assert!(
            warnings.contains("`x` has the value") && warnings.contains("6 times") && !warnings.contains("were lost"),
            "{warnings}"
        );
    }
}

/// A number that is in use is a measurement where the column comes near it. By itself in the middle of a smooth motion, it is an outlier.
#[test]
fn measurements_are_no_marks() {
    let mut rows = Rows::new();
    rows.0.iter_mut().for_each(|row| row[2..].iter_mut().for_each(|v| *v = (*v * 1998.0).round()));
    let (record, warnings) = rows.run();
    assert!(record.measured[1].values.contains(&999.0));
    assert!(record.measured.iter().all(|m| m.values.iter().all(|v| v.is_finite())), "{warnings}");
    rows.0[400][2] = 999.0;
    let (record, warnings) = rows.run();
    assert_eq!(lost(&record, 1), [400]);
    assert!(warnings.contains("`x`: 1 of 1000 value stands alone"), "{warnings}");
}

#[test]
fn a_slower_sensor_counts_once_per_reading() {
    for every in [2, 5, 33] {
        let mut rows = Rows::new();
        for k in 0..ROWS {
            rows.0[k][2] = rows.0[k - k % every][2];
        }
        let (record, warnings) = rows.run();
        let expected: Vec<usize> = (0..ROWS).filter(|k| k % every != 0).collect();
        assert_eq!(lost(&record, 1), expected);
        assert!(warnings.contains(&format!("a new value only every {every} rows")), "{warnings}");
    }
}

/// Two rates in one table: empty fields are as many as the rates say.
#[test]
fn a_column_may_be_mostly_empty() {
    let mut rows = Rows::new();
    (0..ROWS).filter(|k| k % 20 != 0).for_each(|k| rows.0[k][2] = f64::NAN);
    assert_eq!(lost(&rows.run().0, 1).len(), ROWS - ROWS / 20);
    (0..ROWS).filter(|k| k % 100 != 0).for_each(|k| rows.0[k][2] = f64::NAN);
    assert!(rows.read().unwrap_err().to_string().contains("`x`: 990 of 1000 values were lost"));
}

#[test]
fn lost_inputs_are_filled_alone_and_cut_in_rows() {
    let mut random = StdRng::seed_from_u64(7);
    let mut rows = Rows::new();
    let single = places(&mut random, 5);
    for &k in &single {
        rows.0[k][1] = f64::NAN;
    }
    let (record, warnings) = rows.run();
    let exact = Rows::new();
    for k in single {
        assert!((record.inputs[0].values[k] - exact.0[k][1]).abs() < 4.0 * STEP * STEP, "{k}");
    }
    assert!(record.gaps.is_empty() && warnings.contains("5 lost entries of inputs"), "{warnings}");

    let mut rows = Rows::new();
    (400..407).for_each(|k| rows.0[k][1] = f64::NAN);
    let (record, warnings) = rows.run();
    assert_eq!((record.times.len(), record.gaps.as_slice()), (ROWS - 7, [400].as_slice()));
    assert!(warnings.contains("7 rows without an input left out"), "{warnings}");
}

#[test]
fn single_missing_rows_are_inserted_and_longer_gaps_stay() {
    let mut random = StdRng::seed_from_u64(8);
    let at = places(&mut random, 9);
    let mut rows = Rows::new();
    for &k in at.iter().rev() {
        rows.0.remove(k);
    }
    let (record, warnings) = rows.run();
    assert_eq!((record.times.len(), lost(&record, 0), lost(&record, 1)), (ROWS, at.clone(), at.clone()));
    assert!(record.gaps.is_empty() && warnings.contains("9 single rows are missing"), "{warnings}");
    assert!(!warnings.contains("were lost"), "{warnings}");
    let exact = Rows::new();
    for k in at {
        assert!((record.inputs[0].values[k] - exact.0[k][1]).abs() < 4.0 * STEP * STEP, "{k}");
    }

    let mut rows = Rows::new();
    rows.0.drain(300..340);
    assert_eq!(rows.run().0.gaps, [300]);
}

#[test]
fn times_that_fall_are_refused() {
    let mut rows = Rows::new();
    rows.0.swap(10, 11);
    assert!(rows.read().unwrap_err().to_string().contains("less than"));
    rows.0.iter_mut().for_each(|row| row[0] = 1.0);
    assert!(rows.read().unwrap_err().to_string().contains("all times are the same"));
}

/// Of a long run as many rows are left as its motion needs, and a held input keeps its impulse.
#[test]
fn long_runs_are_thinned_as_far_as_their_motion_allows() {
    let long = |rate: f64, fast: f64| {
        let mut random = StdRng::seed_from_u64(9);
        let row = |k: usize| {
            let t = k as f64 / rate;
            let noise = 1e-4 * random.random_range(-1.0..1.0);
            [t, (5.0 * t).sin(), (fast * t).cos() + noise, -fast * (fast * t).sin() + fast * noise]
        };
        Rows((0..200_000).map(row).collect())
    };
    let rows = long(1000.0, 2.0);
    let (record, warnings) = rows.run();
    assert_eq!(record.times.len(), 20_000);
    assert!(warnings.contains("one of every 10 rows is used, of 200000"), "{warnings}");
    let impulse = |values: &[f64], step: f64| values.iter().take(values.len() / 2).sum::<f64>() * step;
    let column: Vec<f64> = rows.0.iter().map(|row| row[1]).collect();
    assert!((impulse(&record.inputs[0].values, 0.01) - impulse(&column, 0.001)).abs() < 1e-12);
    // A motion of a few rows per period keeps them all.
    assert_eq!(long(10.0, 8.0).run().0.times.len(), 200_000);
}
