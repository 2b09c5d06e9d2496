//! Steering by flat outputs and by shooting, and what is bad input.

use crate::common::{Numbers, model, reached, system};
use bracketry_steer::{SteerError, SteerMethod, SteerOptions, SteerReason, SteerStatus, steer};
use bracketry_system::System;

fn by(method: SteerMethod, from: &[f64], to: &[f64]) -> SteerOptions {
    SteerOptions { method: Some(method), ..SteerOptions::between(from, to) }
}

#[test]
fn flat_models_follow_polynomials() {
    let mut numbers = Numbers(5);
    for name in ["double_integrator", "flexible_joint", "two_link_arm"] {
        let s = model(name);
        let n = s.states.len();
        let scaled = |x: Vec<f64>| x.iter().map(|v| 0.5 * v).collect::<Vec<f64>>();
        reached(&s, &by(SteerMethod::Flat, &scaled(numbers.list(n)), &scaled(numbers.list(n))));
    }
    // From rest to rest, with thrust that carries the weight at both ends.
    let found = reached(&model("pvtol"), &by(SteerMethod::Flat, &[0.0; 6], &[1.0, 0.5, 0.0, 0.0, 0.0, 0.0]));
    assert_eq!(found.method(), Some(SteerMethod::Flat));
}

/// The double integrator from rest to rest over T: the cubic has x'' = 6/T² at its start.
#[test]
fn the_cubic_of_the_double_integrator_is_found() {
    let mut options = by(SteerMethod::Flat, &[0.0, 0.0], &[1.0, 0.0]);
    options.duration = Some(2.0);
    let found = reached(&model("double_integrator"), &options);
    let signals = found.signals.unwrap();
    assert!((signals.duration() - 2.0).abs() < 1e-12);
    assert!((signals.values[0][0] - 6.0 / 4.0).abs() < 1e-9);
}

/// The triple integrator between states that do not rest: the input is the third derivative of the one polynomial of degree 5 that has
/// the derivatives of both ends.
#[test]
fn the_polynomial_has_the_derivatives_of_both_ends() {
    let ([x, v, a], [to_x, to_v, to_a], t) = ([0.3, -1.0, 2.0], [1.5, 0.2, -0.7], 1.7);
    let triple = system(&["x", "v", "a"], &["u"], &["v", "a", "u"]);
    let mut options = by(SteerMethod::Flat, &[x, v, a], &[to_x, to_v, to_a]);
    options.duration = Some(t);
    let signals = reached(&triple, &options).signals.unwrap();
    // Its coefficients of degree 3, 4, and 5 times 3!, 4!, and 5!/2.
    let by = to_x - x;
    let p = (60.0 * by - (24.0 * to_v + 36.0 * v) * t + (3.0 * to_a - 9.0 * a) * t * t) / t.powi(3);
    let q = (-360.0 * by + (168.0 * to_v + 192.0 * v) * t + (36.0 * a - 24.0 * to_a) * t * t) / t.powi(4);
    let r = (360.0 * by - 180.0 * (to_v + v) * t + 30.0 * (to_a - a) * t * t) / t.powi(5);
    let last = signals.times.len() - 1;
    for (k, (s, u)) in signals.times.iter().zip(&signals.values).enumerate() {
        // Between the ends, a correction makes up for the interpolation of the input along straight lines.
        let tolerance = if k == 0 || k == last { 1e-11 } else { 1e-4 };
        assert!((u[0] - (p + q * s + r * s * s)).abs() < tolerance, "{s}: {} {}", u[0], p + q * s + r * s * s);
    }
}

#[test]
fn dry_friction_and_pendulums_are_steered_by_shooting() {
    let slider = system(&["x", "v"], &["u"], &["v", "u - 2*sign(v)"]);
    let found = reached(&slider, &SteerOptions::between(&[0.0, 0.0], &[0.5, 0.0]));
    assert_eq!(found.method(), Some(SteerMethod::Shooting));
    let reasons: Vec<&SteerReason> = found.attempts.iter().map(|a| &a.reason).collect();
    assert!(reasons.iter().all(|r| **r == SteerReason::Switches), "{reasons:?}");
    reached(&model("cart_pole"), &SteerOptions::between(&[0.0; 4], &[0.5, 0.0, 0.0, 0.0]));
}

#[test]
fn what_no_input_moves_is_not_reached() {
    let fixed = system(&["x", "y"], &["u"], &["u", "-y"]);
    let found = steer(&fixed, &SteerOptions::between(&[0.0, 1.0], &[0.0, 2.0])).unwrap();
    assert_ne!(found.status, SteerStatus::Reached);
    assert!(found.end_error > 1.0);
    assert_eq!(found.attempts.len(), 4);
}

#[test]
fn bad_input_is_refused_with_its_place() {
    let unicycle = model("unicycle");
    let length = steer(&unicycle, &SteerOptions::between(&[0.0; 2], &[0.0; 3])).unwrap_err();
    assert_eq!(length, SteerError::Length { what: "the initial state", expected: 3, found: 2 });
    let nan = steer(&unicycle, &SteerOptions::between(&[0.0; 3], &[f64::NAN, 0.0, 0.0])).unwrap_err();
    assert_eq!(nan, SteerError::NotFinite { what: "the state at the end" });
    let options = SteerOptions { duration: Some(-1.0), ..SteerOptions::between(&[0.0; 3], &[0.0; 3]) };
    assert_eq!(steer(&unicycle, &options).unwrap_err(), SteerError::NotPositive { what: "duration", value: -1.0 });
    let none = System::parse("free.toml", "states = ['x']\ninputs = []\ndynamics = { x = '-x' }").unwrap();
    let nothing = steer(&none, &SteerOptions::between(&[0.0], &[1.0])).unwrap_err();
    assert_eq!(nothing, SteerError::Nothing { what: "inputs" });
}

#[test]
fn a_stop_ends_the_search_at_once() {
    let options = SteerOptions::between(&[0.0; 4], &[0.0, 1.0, 0.0, 0.0]);
    options.stop.raise();
    let found = steer(&model("kinematic_car"), &options).unwrap();
    assert_eq!(found.status, SteerStatus::NotFound);
    assert_eq!(found.attempts[0].reason, SteerReason::Stopped);
}
