//! Sentences about the stiffness of robots.

use bracketry_report::stiffness::text;
use bracketry_stiffness::{Advice, Attenuation, CartesianEstimator, LostMotion, LostMotionReport, Method, Springs};

#[test]
fn lost_motion_is_told_by_joint() {
    let lost = LostMotion { joint: 1, gap: 2.9e-4, engaged: 30.0, reversals: 2, share: 0.9 };
    let springs = Springs::linear(&[1e6]);
    let report = LostMotionReport { residual: 2e-4, linear: 1e-4, nonlinear: 1e-5, lost_motion: vec![lost], springs };
    let text = text::lost_motion(&report);
    assert!(text.contains("joint 1: lost motion") && text.contains("not explained by a linear model"), "{text}");
}

#[test]
fn advice_names_the_bias_of_the_published_estimator_and_overstated_noise() {
    let attenuation = Attenuation { worst: 0.5, error: 0.2 };
    let advice = Advice::Attenuated { estimator: CartesianEstimator::WrenchOnDisplacement, attenuation };
    let words = text::advice(&advice);
    assert!(words.contains("the noise of ΔX makes K too small"), "{words}");
    assert!(text::advice(&Advice::NoiseOverstated { residual: 0.2 }).contains("times the stated noise"));
}

#[test]
fn the_best_of_methods_that_miss_something_is_not_to_be_trusted() {
    let advice = |explains| text::advice(&Advice::Trust { method: Method::JointSprings, held_out: 13.4, explains });
    assert!(advice(true).starts_with("trust joint springs"), "{}", advice(true));
    let words = advice(false);
    assert!(words.contains("no method explains") && !words.contains("trust"), "{words}");
}
