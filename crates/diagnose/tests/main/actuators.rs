//! Inputs and sensors that do not show what they are taken for: dead zones, saturations, drifts, filters.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::caveats::{STEP, spring};
use bracketry_diagnose::{Cause, DiagnosisSettings, Record, RecordSettings, Report, Verdict, diagnose};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

/// Ten seconds of the spring under a force that is held between samples; `arriving` is what acts of it, and `shown` what the sensor shows
/// of the position, called with the time since the call before.
fn record(seed: u64, arriving: impl Fn(f64) -> f64, shown: impl FnMut(f64, f64) -> f64) -> Record {
    changing(seed, |_, z, force| arriving(force) - 20.0 * z[0] - 0.5 * z[1], shown)
}

/// The same with any force on the mass at a time, by position and velocity and by the force that is logged.
pub(crate) fn changing(
    seed: u64,
    acting: impl Fn(f64, &[f64; 2], f64) -> f64,
    mut shown: impl FnMut(f64, f64) -> f64,
) -> Record {
    let mut random = StdRng::seed_from_u64(seed);
    let lines: Vec<(f64, f64)> =
        (0..12).map(|_| (random.random_range(0.2..2.5), random.random_range(0.0..TAU))).collect();
    let force = |t: f64| lines.iter().map(|(f, p)| (TAU * f * t + p).sin()).sum::<f64>() * 1.6;
    let [mut times, mut forces, mut positions, mut velocities] = [const { Vec::new() }; 4];
    let mut z = [0.1, 0.0];
    let mut read = shown(0.0, z[0]);
    for k in 0..1000 {
        let t = f64::from(k) * STEP;
        times.push(t);
        forces.push(force(t));
        positions.push(read);
        velocities.push(z[1]);
        let held = force(t);
        for i in 0..20 {
            let now = t + f64::from(i) * STEP / 20.0;
            z = crate::integrate::step(|z: &[f64; 2], _| [z[1], acting(now, z, held)], &z, STEP / 20.0);
            read = shown(STEP / 20.0, z[0]);
        }
    }
    for values in [&mut positions, &mut velocities] {
        let size = (values.iter().map(|v| v * v).sum::<f64>() / 1000.0).sqrt();
        let noise = Normal::new(0.0, 0.01 * size).unwrap();
        for v in values.iter_mut() {
            *v += noise.sample(&mut random);
        }
    }
    let columns = BTreeMap::from([("F", forces), ("x", positions), ("v", velocities)].map(|(n, v)| (n.to_owned(), v)));
    let system = spring();
    Record::from_columns("run.csv", times, columns, &system, &RecordSettings::default()).unwrap()
}

pub(crate) fn verdict(record: Record) -> Report {
    let system = spring();
    diagnose(&system, &[record], &[], &DiagnosisSettings::default(), &mut |_| {}).unwrap()
}

/// What the report names alone, with its one value.
fn named(report: &Report) -> (Cause, f64) {
    let terms: Vec<&str> = report.causes.iter().map(|c| c.term.text()).collect();
    assert_eq!((report.verdict, terms.len()), (Verdict::CauseFound, 1), "{terms:?}: {:?}", report.excess);
    (report.causes[0].name, report.causes[0].parameters[0].1.value)
}

#[test]
fn a_dead_zone_is_named_with_its_width() {
    for (seed, width) in [(1, 0.5), (2, 1.5)] {
        let report = verdict(record(seed, |u| u.signum() * (u.abs() - width).max(0.0), |_, x| x));
        let (cause, value) = named(&report);
        assert!(cause == Cause::DeadZone && (value - width).abs() < 0.1, "{width}: {report:?}");
    }
}

#[test]
fn a_saturation_is_named_with_its_limit_and_its_side() {
    for (seed, low, high) in [(3, -4.0, 4.0), (4, f64::NEG_INFINITY, 3.0), (5, -3.0, f64::INFINITY), (6, -2.5, 2.5)] {
        let report = verdict(record(seed, |u| u.clamp(low, high), |_, x| x));
        let (cause, value) = named(&report);
        let limit = if high.is_finite() { high } else { low };
        assert!(cause == Cause::Saturation && (value - limit).abs() < 0.2, "{low} {high}: {report:?}");
        let term = report.causes[0].term.text();
        assert_eq!(term.contains("max") && term.contains("min"), low.is_finite() && high.is_finite(), "{term}");
    }
}

#[test]
fn a_sensor_that_drifts_is_named_with_its_rate() {
    for (seed, rate) in [(7, 0.01), (8, -0.03)] {
        let mut time = 0.0;
        let drifting = |step: f64, x: f64| {
            time += step;
            x + rate * time
        };
        let report = verdict(record(seed, |u| u, drifting));
        let (cause, value) = named(&report);
        assert!(cause == Cause::SensorDrift && (value - rate).abs() < 0.1 * rate.abs(), "{rate}: {report:?}");
        // The extended model reads the same: its output grows with the time, which is a state.
        let model = &report.evidence.model.as_ref().unwrap().system;
        assert!(model.state_names().contains(&"time".to_owned()) && model.outputs.len() == 1, "{report:?}");
    }
}

#[test]
fn a_filter_of_a_sensor_is_named_with_its_time_constant() {
    for (seed, lag, digital) in [(10, 0.03, false), (11, 0.08, false), (12, 0.05, true), (13, 0.09, true)] {
        let (mut y, mut time, mut next) = (0.1, 0.0, STEP);
        let filter = |step: f64, x: f64| {
            time += step;
            if !digital {
                y += (x - y) * (1.0 - (-step / lag).exp());
            } else if time > next - 0.5 * step {
                // A program sees samples alone.
                y += (x - y) * (1.0 - (-STEP / lag).exp());
                next += STEP;
            }
            y
        };
        let report = verdict(record(seed, |u| u, filter));
        let (cause, value) = named(&report);
        assert!(cause == Cause::SensorLag && (value - lag).abs() < 0.05 * lag, "{lag}: {report:?}");
        // The extended model shows the state of the filter.
        let model = &report.evidence.model.as_ref().unwrap().system;
        assert_eq!(model.state_names().last().unwrap(), "x_filtered");
        let shown = &model.outputs[0];
        assert_eq!((shown.0.as_str(), model.pool.text(shown.1)), ("x_measured", "x_filtered".to_owned()));
    }
}

/// What hardly any sample reaches is no saturation, whatever it takes away.
#[test]
fn a_limit_that_one_sample_exceeds_is_not_named() {
    let peak = record(9, |u| u, |_, x| x).inputs[0].values.iter().copied().fold(0.0, f64::max);
    let report = verdict(record(9, |u| u.min(0.98 * peak), |_, x| x));
    assert!(report.causes.iter().all(|c| c.name != Cause::Saturation), "{report:?}");
}
