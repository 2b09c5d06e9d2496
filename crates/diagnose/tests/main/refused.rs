//! What is never named: causes that may as well have no effect, and friction that drives.

use std::collections::BTreeMap;

use crate::tier::cases;
use bracketry_diagnose::{Cause, DiagnosisSettings, NamedCause, Record, RecordSettings, diagnose};
use bracketry_system::System;
use bracketry_trials::{Choice, SliderSensors, SliderTrial};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

/// Whether all numbers of a cause have an interval that contains zero, where all its effects vanish.
fn may_be_nothing(cause: &NamedCause) -> bool {
    cause.parameters.iter().all(|(_, v)| v.interval.is_some_and(|[low, high]| low <= 0.0 && 0.0 <= high))
}

#[test]
fn no_cause_is_named_whose_interval_contains_no_effect() {
    for seed in 1..=cases(2, 4) {
        // Hidden effects of hardly more than what the noise hides.
        let mut trial = SliderTrial::draw(Choice::Pair, SliderSensors::PositionAndVelocity, 0.01, false, seed);
        trial.slider.rate = 200.0;
        let (report, _) = trial.run(&DiagnosisSettings { max_causes: 4, ..DiagnosisSettings::default() }).unwrap();
        for cause in report.causes.iter().filter(|c| c.name != Cause::ParameterError) {
            assert!(!may_be_nothing(cause), "seed {seed}: {cause:?}");
        }
    }
}

/// A mass with dry friction, and a force `push` times the velocity that drives it; measured with noise.
fn driven(system: &System, (mass, friction, push): (f64, f64, f64), seed: u64) -> Record {
    let random = &mut StdRng::seed_from_u64(seed);
    let (dt, h) = (0.01, 1e-4);
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut times = Vec::new();
    for k in 0..1500 {
        let t = f64::from(k) * dt;
        let u = 2.0 * ((1.3 * t).sin() + 0.8 * (3.1 * t + 0.5).sin());
        times.push(t);
        for (name, value, noise) in [("x", x, 1e-3), ("v", v, 2e-3), ("u", u, 0.0)] {
            let kick: f64 = StandardNormal.sample(random);
            columns.entry(name.to_owned()).or_default().push(value + noise * kick);
        }
        // Steps far below all times of the motion, with friction that stops the mass but does not turn it.
        for _ in 0..(dt / h).round() as usize {
            let free = v + h * (u + push * v - 4.0 * x) / mass;
            let stop = h * friction / mass;
            v = if free.abs() <= stop { 0.0 } else { free - stop * free.signum() };
            x += h * v;
        }
    }
    Record::from_columns("run", times, columns, system, &RecordSettings::default()).unwrap()
}

#[test]
fn friction_that_drives_is_not_named() {
    let text = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 1.0, F = 0.5, k = 4.0 }\n\
                [dynamics]\nx = 'v'\nv = '(u - F*sign(v) - k*x)/m'";
    let system = System::parse("mass.toml", text).unwrap();
    let dissipations = [Cause::ViscousFriction, Cause::QuadraticDrag, Cause::CoulombFriction, Cause::YawFriction];
    let mut random = StdRng::seed_from_u64(11);
    for seed in 0..cases(1, 3) {
        let truth = (random.random_range(0.9..1.1), random.random_range(0.45..0.55), random.random_range(0.1..0.3));
        let record = driven(&system, truth, seed);
        let report = diagnose(&system, &[record], &[], &DiagnosisSettings::default(), &mut |_| ()).unwrap();
        for cause in &report.causes {
            let drives = cause.parameters.iter().any(|(_, v)| v.value < 0.0);
            assert!(!(dissipations.contains(&cause.name) && drives), "{truth:?}: {cause:?}");
            assert!(!cause.flags.iter().any(|f| matches!(f, bracketry_diagnose::Flag::Unphysical { .. })), "{cause:?}");
        }
    }
}
