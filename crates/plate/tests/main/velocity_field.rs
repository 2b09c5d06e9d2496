//! Mean velocities under periodic plate motions: symmetry, invariance, sticking.

use bracketry_plate::experiment::{Establishing, MeanVelocity, mean_velocity, velocity_field};
use bracketry_plate::{Harmonic, ModelObject, PeriodicMotion, Shape, published};
use bracketry_sim::SimulationSettings;
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn plant() -> ModelObject {
    let system = published(&Shape::REFERENCE_ELLIPSE, 0.3).unwrap();
    ModelObject::new(&system, [0.0; 6], &SimulationSettings::default()).unwrap()
}

fn harmonics(list: &[(f64, f64)]) -> Vec<Harmonic> {
    list.iter().map(|&(amplitude, phase)| Harmonic { amplitude, phase }).collect()
}

/// Displacement and tilt with a first and a second harmonic.
fn motion(displacement: &[(f64, f64)], tilt: &[(f64, f64)]) -> PeriodicMotion {
    PeriodicMotion { frequency: 3.0, displacement: harmonics(displacement), tilt: harmonics(tilt), mean_tilt: 0.0 }
}

fn mean(motion: &PeriodicMotion, place: [f64; 3]) -> MeanVelocity {
    mean_velocity(&mut plant(), motion, place, Establishing::default()).unwrap()
}

#[test]
fn a_motion_equal_to_its_own_half_turn_gives_no_mean_velocity() {
    // X(t + T/2) = −X(t): the second half of the period mirrors the first.
    let sine = mean(&motion(&[(0.02, 0.0)], &[]), [0.1, 0.0, 0.0]);
    assert!(sine.established && sine.mean[0].abs() < 1e-6, "{sine:?}");
    assert_eq!(sine.mean[1..], [0.0, 0.0]);
}

#[test]
fn a_second_harmonic_drives_the_object_the_way_its_phase_says() {
    // With cos ωt + ¼ cos 2ωt the plate reverses sharply at one end: opposite phases give opposite ways.
    let there = mean(&motion(&[(0.015, 0.5 * PI), (0.00375, 0.5 * PI)], &[]), [0.0; 3]);
    let back = mean(&motion(&[(-0.015, 0.5 * PI), (-0.00375, 0.5 * PI)], &[]), [0.0; 3]);
    assert!(there.established && there.mean[0].abs() > 1e-3, "{there:?}");
    assert!((there.mean[0] + back.mean[0]).abs() < 1e-9);
}

#[test]
fn without_tilt_the_drift_is_the_same_at_every_place() {
    let biased = motion(&[(0.015, 0.5 * PI), (0.004, 0.3)], &[]);
    let places = [[0.0, 0.0, 0.0], [0.3, -0.1, 0.7], [-0.2, 0.2, 2.0]];
    let field = velocity_field(&plant(), &biased, &places, Establishing::default(), |_| ControlFlow::Continue(()));
    let means: Vec<[f64; 3]> = field.into_iter().map(|m| m.unwrap().unwrap().mean).collect();
    assert!(means[0][0].abs() > 1e-3);
    for other in &means[1..] {
        assert!((other[0] - means[0][0]).abs() < 1e-9 && other[1] == 0.0, "{means:?}");
    }
}

#[test]
fn a_tilt_to_the_other_side_mirrors_the_field_in_the_axis() {
    // (y, theta) → (−y, −theta) leaves the equations as they are.
    let tilt = motion(&[], &[(0.3, 0.0), (0.12, 1.0)]);
    let other = motion(&[], &[(-0.3, 0.0), (-0.12, 1.0)]);
    for y in [-0.06, 0.02, 0.08] {
        let (a, b) = (mean(&tilt, [0.1, y, 0.0]), mean(&other, [0.1, -y, 0.0]));
        assert!(a.established && a.mean[1].abs() > 1e-4, "{a:?}");
        assert!((a.mean[1] + b.mean[1]).abs() < 1e-9 && a.mean[0] == b.mean[0]);
    }
}

#[test]
fn what_never_slips_has_no_mean_velocity_at_all() {
    // |X''| < μ g on a plate that is tilted by less than the friction angle.
    let gentle = PeriodicMotion { mean_tilt: 0.2, ..motion(&[(0.005, 0.4), (0.0005, 0.1)], &[]) };
    let still = mean(&gentle, [0.2, 0.05, 0.3]);
    assert_eq!((still.mean, still.periods, still.established), ([0.0; 3], 1, true));
}

#[test]
fn a_spin_that_nothing_brakes_is_not_called_established() {
    // The published model has no yaw friction: a torque with a mean spins the object ever faster.
    let turning = motion(&[(0.025, 0.0)], &[(-0.26, 0.0)]);
    let limits = Establishing { periods: 20, ..Establishing::default() };
    let spin = mean_velocity(&mut plant(), &turning, [0.0; 3], limits).unwrap();
    assert!(!spin.established && spin.periods == 20 && spin.mean[2].abs() > 1.0);
}

#[test]
fn numbers_without_meaning_are_refused() {
    for frequency in [0.0, -1.0, f64::NAN] {
        let bad = PeriodicMotion { frequency, ..motion(&[], &[]) };
        assert!(bad.drive().is_err());
    }
    assert!(motion(&[(f64::INFINITY, 0.0)], &[]).drive().is_err());
}
