//! Forces that depend on the way.

use std::cell::RefCell;

use crate::actuators::{changing, verdict};
use bracketry_diagnose::{Cause, Report, Verdict};

/// The verdict on the spring under hysteresis by Bouc and Wen: largest force, distance, share of the loop. With a distance of zero the
/// friction is that of Coulomb.
fn hysteresis(seed: u64, force: f64, distance: f64, share: f64) -> Report {
    // Last time, and the state of the hysteresis, which follows by steps of Euler.
    let state = RefCell::new([0.0, 0.0]);
    let acting = |t: f64, z: &[f64; 2], u: f64| {
        let mut state = state.borrow_mut();
        let [last, way] = *state;
        if t > last {
            let [v, step] = [z[1], t - last];
            let rate = (v - share * v.abs() * way - (1.0 - share) * v * way.abs()) / distance.max(1e-12);
            *state = [t, if distance > 0.0 { way + step * rate } else { v.signum() }];
        }
        u - 20.0 * z[0] - 0.5 * z[1] - force * way
    };
    verdict(changing(seed, acting, |_, x| x))
}

#[test]
fn hysteresis_is_named_with_its_force_and_distance() {
    for (seed, force, distance, share) in [(41, 1.5, 0.05, 1.0), (42, 2.0, 0.08, 0.6)] {
        let report = hysteresis(seed, force, distance, share);
        let [cause] = &report.causes[..] else { panic!("{:?} {:?}", report.verdict, report.excess) };
        assert_eq!((report.verdict, cause.name), (Verdict::CauseFound, Cause::Hysteresis));
        for ((name, value), truth) in cause.parameters.iter().zip([force, distance]) {
            let off = (value.value - truth).abs();
            assert!(off < 0.1 * truth, "{name}: {value:?} instead of {truth}");
        }
    }
}

#[test]
fn friction_of_coulomb_is_no_hysteresis() {
    let report = hysteresis(43, 1.5, 0.0, 1.0);
    assert!(report.causes.iter().all(|c| c.name != Cause::Hysteresis), "{:?}", report.verdict);
}
