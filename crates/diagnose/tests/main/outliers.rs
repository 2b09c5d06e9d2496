//! Samples that stand alone: which are left out, and what is never taken for one.

use std::collections::BTreeMap;

use bracketry_diagnose::{Record, RecordSettings, Warning};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

const STEP: f64 = 0.01;

fn read(x: Vec<f64>, u: Vec<f64>) -> Record {
    let text = "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u - x' }";
    let system = System::parse("lag.toml", text).unwrap();
    let times = (0..x.len()).map(|k| k as f64 * STEP).collect();
    let columns = BTreeMap::from([("x".to_owned(), x), ("u".to_owned(), u)]);
    Record::from_columns("run", times, columns, &system, &RecordSettings::default()).unwrap()
}

fn lost(record: &Record) -> Vec<usize> {
    let values = &record.measured[0].values;
    (0..values.len()).filter(|&k| values[k].is_nan()).collect()
}

fn said(record: &Record) -> Option<&Warning> {
    record.audit.as_ref().unwrap().warnings.iter().find(|w| matches!(w, Warning::Outliers { .. }))
}

fn noise(random: &mut StdRng, count: usize, std: f64) -> Vec<f64> {
    (0..count).map(|_| std * Distribution::<f64>::sample(&StandardNormal, random)).collect()
}

/// A smooth motion of random frequencies with white noise of a random size.
fn motion(random: &mut StdRng, count: usize) -> (Vec<f64>, f64) {
    let std = 10f64.powf(random.random_range(-4.0..-1.0));
    let waves: Vec<[f64; 3]> = (0..5)
        .map(|_| [random.random_range(0.2..1.0), random.random_range(0.5..4.0), random.random_range(0.0..6.0)])
        .collect();
    let at = |k: usize| waves.iter().map(|[a, w, p]| a * (w * k as f64 * STEP + p).sin()).sum::<f64>();
    (noise(random, count, std).into_iter().enumerate().map(|(k, n)| at(k) + n).collect(), std)
}

fn wave(count: usize) -> Vec<f64> {
    (0..count).map(|k| (0.02 * k as f64).sin()).collect()
}

#[test]
fn samples_that_stand_alone_are_left_out_and_stated() {
    for seed in 0..40 {
        let random = &mut StdRng::seed_from_u64(seed);
        let count = random.random_range(500..3000);
        let (mut x, std) = motion(random, count);
        // About one sample of a hundred, some of them in a row or with one sample between, and at an end.
        let mut at = Vec::new();
        let mut k = random.random_range(4..100);
        while k + 4 < count {
            at.push(k);
            if random.random_bool(0.1) && k + 6 < count {
                at.push(k + random.random_range(1..3));
            }
            k += random.random_range(7..190);
        }
        if seed % 4 == 0 {
            at.push(count - 1);
        }
        let sign = |random: &mut StdRng| if random.random_bool(0.5) { 1.0 } else { -1.0 };
        for &k in &at {
            x[k] += sign(random) * (30.0 * std + random.random_range(1.0..4.0));
        }
        let record = read(x, wave(count));
        assert_eq!(lost(&record), at, "seed {seed}, noise {std}");
        let Some(Warning::Outliers { name, count, at: first, left_out, .. }) = said(&record) else { panic!("unsaid") };
        assert_eq!((name.as_str(), *count, *left_out), ("x", at.len(), true));
        assert_eq!(first[..], at.iter().take(3).map(|k| *k as f64 * STEP).collect::<Vec<_>>());
        let column = record.audit.as_ref().unwrap().columns.iter().find(|c| c.name == "x").unwrap();
        assert_eq!((column.outliers, column.lost), (Some(at.len()), at.len()));
        assert!((0.9..1.1).contains(&(record.measured[0].noise / std)), "{}", record.measured[0].noise / std);
    }
}

#[test]
fn white_noise_has_no_outliers() {
    for seed in 0..5 {
        let random = &mut StdRng::seed_from_u64(seed);
        let record = read(noise(random, 100_000, 1.0), wave(100_000));
        assert_eq!((lost(&record).len(), said(&record)), (0, None));
    }
}

/// Steps, tips of triangles, relays, an encoder's rate of mostly zero, stick and slip, impulses of the input, and a sensor's coarse steps.
#[test]
fn motions_have_no_outliers() {
    const N: usize = 4000;
    for seed in 0..20 {
        let random = &mut StdRng::seed_from_u64(seed);
        let std = [0.0, 1e-3, 1e-2][seed as usize % 3];
        let period = random.random_range(7..200_usize);
        let triangle = |k: usize| (k % (2 * period)).abs_diff(period) as f64 / period as f64;
        let square = |k: usize| if (k / period).is_multiple_of(2) { 1.0 } else { 0.0 };
        let position = |k: usize| (0.5 * (0.004 * k as f64).sin() / 0.01).round();
        let rate = |k: usize| position(k + 1) - position(k);
        let shapes: [(&dyn Fn(usize) -> f64, f64); 4] =
            [(&triangle, std), (&square, std.max(1e-6)), (&rate, 0.0), (&position, 0.0)];
        for (i, (shape, std)) in shapes.into_iter().enumerate() {
            let x: Vec<f64> = noise(random, N, std).into_iter().enumerate().map(|(k, n)| shape(k) + n).collect();
            let record = read(x, wave(N));
            assert!(lost(&record).is_empty(), "seed {seed}, shape {i}: {:?}", said(&record));
        }
        // A filter without memory shows impulses of the input for one sample.
        let u: Vec<f64> = (0..N).map(|k| if k % (5 * period) == 9 { 5.0 } else { 0.0 }).collect();
        let x: Vec<f64> = u.iter().zip(noise(random, N, std)).map(|(u, n)| 0.3 * u + n).collect();
        let record = read(x, u);
        assert!(lost(&record).is_empty(), "seed {seed}: {:?}", said(&record));
    }
}

#[test]
fn too_many_are_kept_and_stated() {
    let random = &mut StdRng::seed_from_u64(7);
    let (mut x, _) = motion(random, 1000);
    (10..990).step_by(8).for_each(|k| x[k] += 20.0);
    let record = read(x.clone(), wave(1000));
    assert_eq!(lost(&record), Vec::<usize>::new());
    assert!(
        matches!(said(&record), Some(Warning::Outliers { left_out: false, count: 123, .. })),
        "{:?}",
        said(&record)
    );
}
