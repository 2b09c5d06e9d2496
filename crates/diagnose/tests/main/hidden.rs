//! Masses that no column shows.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::actuators::verdict;
use crate::caveats::{STEP, spring};
use bracketry_diagnose::{Cause, Record, RecordSettings, Verdict};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

/// Ten seconds of the spring with an inertia that hangs on its mass, by natural frequency in Hz and damping ratio.
fn record(seed: u64, inertia: f64, frequency: f64, damping: f64) -> Record {
    let mut random = StdRng::seed_from_u64(seed);
    let lines: Vec<(f64, f64)> =
        (0..12).map(|_| (random.random_range(0.2..4.0), random.random_range(0.0..TAU))).collect();
    let force = |t: f64| lines.iter().map(|(f, p)| (TAU * f * t + p).sin()).sum::<f64>() * 1.6;
    let [mut times, mut forces, mut positions, mut velocities] = [const { Vec::new() }; 4];
    let mut z = [0.1, 0.0, 0.1, 0.0];
    let rate = TAU * frequency;
    for k in 0..1000 {
        let t = f64::from(k) * STEP;
        times.push(t);
        forces.push(force(t));
        positions.push(z[0]);
        velocities.push(z[1]);
        let held = force(t);
        let of = |z: &[f64; 4], _: f64| {
            let pull = rate * rate * (z[2] - z[0]) + 2.0 * damping * rate * (z[3] - z[1]);
            [z[1], held - 20.0 * z[0] - 0.5 * z[1] + inertia * pull, z[3], -pull]
        };
        (0..10).for_each(|_| z = crate::integrate::step(of, &z, STEP / 10.0));
    }
    for values in [&mut positions, &mut velocities] {
        let size = (values.iter().map(|v| v * v).sum::<f64>() / 1000.0).sqrt();
        let noise = Normal::new(0.0, 0.01 * size).unwrap();
        for v in values.iter_mut() {
            *v += noise.sample(&mut random);
        }
    }
    let columns = BTreeMap::from([("F", forces), ("x", positions), ("v", velocities)].map(|(n, v)| (n.to_owned(), v)));
    Record::from_columns("run.csv", times, columns, &spring(), &RecordSettings::default()).unwrap()
}

#[test]
fn an_elastic_joint_is_named_with_its_inertia_frequency_and_damping() {
    for (seed, truth) in [(31, [0.3, 3.0, 0.04]), (32, [0.5, 4.0, 0.02]), (33, [0.2, 2.5, 0.1])] {
        let [inertia, frequency, damping] = truth;
        let report = verdict(record(seed, inertia, frequency, damping));
        let [cause] = &report.causes[..] else { panic!("{:?} {:?}", report.verdict, report.excess) };
        assert_eq!((report.verdict, cause.name), (Verdict::CauseFound, Cause::ElasticJoint));
        for ((name, value), truth) in cause.parameters.iter().zip(truth) {
            let off = (value.value - truth).abs();
            assert!(off < 4.0 * value.std && value.std < 0.02 * (truth + 1.0), "{name}: {value:?} instead of {truth}");
        }
        // The extended model has the states of the mass.
        let model = &report.evidence.model.as_ref().unwrap().system;
        assert_eq!(model.state_names()[2..], ["hidden_gap_v", "hidden_speed_v"]);
    }
}
