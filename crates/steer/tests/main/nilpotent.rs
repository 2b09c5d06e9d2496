//! Steering by Philip Hall coordinates.

use crate::common::{Numbers, model, reached, system};
use bracketry_steer::{Plan, SteerMethod, SteerOptions, SteerReason, SteerStatus, steer};
use bracketry_system::System;

fn by_brackets(from: &[f64], to: &[f64]) -> SteerOptions {
    SteerOptions { method: Some(SteerMethod::Nilpotent), ..SteerOptions::between(from, to) }
}

/// Lafferriere and Sussmann 1991: exact for nilpotent systems, in one round and without any correction.
#[test]
fn nilpotent_systems_are_steered_exactly_in_one_round() {
    let cartan = system(&["x", "y", "z", "a", "b"], &["u", "v"], &["u", "v", "x*v", "x^2*v", "x*y*v"]);
    let three =
        system(&["x", "y", "z", "a", "b", "c"], &["u", "v", "w"], &["u", "v", "w", "x*v - y*u", "x*w", "y*w - z*v"]);
    let long = system(&["p", "q", "r", "s", "t"], &["u", "v"], &["u", "v", "p*v", "p^2*v", "p^3*v"]);
    let mut numbers = Numbers(3);
    for nilpotent in [cartan, three, long, model("brockett_integrator")] {
        let n = nilpotent.states.len();
        for _ in 0..2 {
            let found = reached(&nilpotent, &by_brackets(&numbers.list(n), &numbers.list(n)));
            let Some(Plan::Nilpotent { is_nilpotent, rounds, .. }) = found.plan else { panic!("{:?}", found.plan) };
            assert!(is_nilpotent && rounds == 1, "{rounds} rounds");
            // One input at a time.
            let moving = |row: &Vec<f64>| row.iter().filter(|u| **u != 0.0).count();
            assert!(found.signals.unwrap().values.iter().all(|row| moving(row) <= 1));
        }
    }
}

/// The kinematic snakeboard (Lewis, Ostrowski, Murray and Burdick 1994; Bullo and Lewis 2003): its growth at generic points is
/// 2, 3, 5, and at straight wheels longer brackets are needed for sideways.
fn snakeboard() -> System {
    system(
        &["x", "y", "th", "psi", "phi"],
        &["u1", "u2"],
        &["-0.5*sin(phi)*cos(phi)*cos(th)*u1", "-0.5*sin(phi)*cos(phi)*sin(th)*u1", "-0.5*sin(phi)^2*u1", "u1", "u2"],
    )
}

#[test]
fn the_snakeboard_turns_advances_and_moves_sideways() {
    for to in [[0.0, 0.0, 0.3, 0.0, 0.0], [0.2, 0.0, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0, 0.0]] {
        let found = reached(&snakeboard(), &by_brackets(&[0.0; 5], &to));
        assert!(matches!(found.plan, Some(Plan::Nilpotent { is_nilpotent: false, .. })));
    }
    let mut numbers = Numbers(4);
    for _ in 0..2 {
        let scaled = |x: Vec<f64>| x.iter().map(|v| 0.4 * v).collect::<Vec<f64>>();
        reached(&snakeboard(), &by_brackets(&scaled(numbers.list(5)), &scaled(numbers.list(5))));
    }
}

#[test]
fn vehicles_are_steered_by_rounds_of_brackets_too() {
    reached(&model("unicycle"), &by_brackets(&[0.0; 3], &[0.3, 1.0, -0.5]));
    reached(&model("rolling_disk"), &by_brackets(&[0.0; 4], &[0.0, 0.0, 0.0, 1.0]));
}

#[test]
fn brackets_that_span_too_little_are_named() {
    // x and y move together: x − y never changes.
    let stuck = system(&["x", "y", "z"], &["u", "v"], &["u", "u", "v"]);
    let found = steer(&stuck, &by_brackets(&[0.0; 3], &[1.0, 0.0, 0.0])).unwrap();
    assert_eq!(found.status, SteerStatus::NotFound);
    assert!(
        matches!(found.attempts[0].reason, SteerReason::Brackets { dimension: 2, states: 3, .. }),
        "{:?}",
        found.attempts
    );
}

#[test]
fn a_state_is_steered_to_itself() {
    reached(&snakeboard(), &by_brackets(&[0.1; 5], &[0.1; 5]));
}
