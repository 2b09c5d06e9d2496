//! Parameters that change during a run.

use crate::actuators::{changing, verdict};
use bracketry_diagnose::{Cause, Flag, Report, Verdict};

/// The verdict on a spring whose stiffness of 20 N/m changes by this share at a time.
fn stiffness(seed: u64, change: impl Fn(f64) -> f64) -> Report {
    let force = |t: f64, z: &[f64; 2], u: f64| u - 20.0 * (1.0 + change(t)) * z[0] - 0.5 * z[1];
    verdict(changing(seed, force, |_, x| x))
}

#[test]
fn a_parameter_that_jumps_is_named_with_its_values_and_the_time() {
    for (seed, share, at) in [(21, 0.3, 4.321), (22, -0.25, 6.787), (23, 0.5, 3.1)] {
        let report = stiffness(seed, |t| if t < at { 0.0 } else { share });
        let [cause] = &report.causes[..] else { panic!("{:?}", report.verdict) };
        assert_eq!((report.verdict, cause.name), (Verdict::CauseFound, Cause::ParameterJump), "{:?}", cause.term);
        let Some(Flag::Jumped { name, from, to, at: found }) = cause.flags.first() else { panic!("{:?}", cause.flags) };
        let off = [from - 20.0, to - 20.0 * (1.0 + share)].map(f64::abs);
        assert!(name == "k" && off.iter().all(|off| *off < 0.2), "{name}: {from} to {to} instead of {share}");
        assert!((found - at).abs() < 0.01, "at {found} instead of {at}");
        let [low, high] = cause.parameters[1].1.interval.unwrap();
        assert!(low < at && at < high && high - low < 0.05, "{low} to {high} instead of {at}");
        // The extended model has the same change, by a time that is a state.
        let model = &report.evidence.model.as_ref().unwrap().system;
        assert!(model.state_names().contains(&"time".to_owned()), "{:?}", model.state_names());
    }
}

#[test]
fn a_parameter_that_changes_slowly_or_not_at_all_is_no_jump() {
    for (seed, slowly) in [(24_u32, true), (25, true), (26, false)] {
        let report = stiffness(u64::from(seed), |t| {
            if slowly { 0.5 * (1.0 - (-t / (2.0 * f64::from(seed - 23))).exp()) } else { 0.2 }
        });
        assert!(report.causes.iter().all(|c| c.name != Cause::ParameterJump), "{seed}: {:?}", report.verdict);
        assert_eq!(report.verdict == Verdict::CauseFound, !slowly, "{seed}");
    }
}
