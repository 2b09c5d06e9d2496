//! Steering in the chained form.

use crate::common::{Numbers, model, reached, system};
use bracketry_steer::{Plan, SteerMethod, SteerNote, SteerOptions, SteerReason, SteerStatus, steer};
use bracketry_system::System;

#[test]
fn a_unicycle_goes_to_random_poses() {
    let (unicycle, mut numbers) = (model("unicycle"), Numbers(1));
    for _ in 0..5 {
        let (from, to) = (numbers.list(3), numbers.list(3));
        let scaled = |x: Vec<f64>| vec![3.0 * x[0], 3.0 * x[1], 4.0 * x[2]];
        let found = reached(&unicycle, &SteerOptions::between(&scaled(from), &scaled(to)));
        assert_eq!(found.method(), Some(SteerMethod::Chained));
    }
}

/// z1' = v1, z2' = v2, z3' = z2 v1, …, with random lengths and goals.
#[test]
fn chains_of_random_length_go_to_random_goals() {
    let mut numbers = Numbers(2);
    for n in [3, 4, 5, 6] {
        let names: Vec<String> = (1..=n).map(|k| format!("z{k}")).collect();
        let states: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut rates = vec!["v1".to_owned(), "v2".to_owned()];
        rates.extend((3..=n).map(|k| format!("z{}*v1", k - 1)));
        let rates: Vec<&str> = rates.iter().map(String::as_str).collect();
        let chain = system(&states, &["v1", "v2"], &rates);
        let found = reached(&chain, &SteerOptions::between(&numbers.list(n), &numbers.list(n)));
        assert_eq!(found.method(), Some(SteerMethod::Chained), "{n}");
    }
}

#[test]
fn a_car_parks_sideways_and_turns_around() {
    let car = model("kinematic_car");
    let found = reached(&car, &SteerOptions::between(&[0.0; 4], &[0.0, 2.0, 0.0, 0.0]));
    assert_eq!(found.method(), Some(SteerMethod::Chained));
    // No chained form of the car is regular along a half turn with straight wheels at both ends: two legs.
    let found = reached(&car, &SteerOptions::between(&[0.0; 4], &[1.0, 3.0, std::f64::consts::PI, 0.0]));
    let Some(Plan::Chained { coordinates, way_points }) = &found.plan else { panic!("{:?}", found.plan) };
    assert!(coordinates.len() == 2 && way_points.len() == 1);
}

#[test]
fn a_tractor_with_two_trailers_moves_sideways() {
    let trailers = model("car_with_trailers");
    let mut options = SteerOptions::between(&[0.0; 5], &[0.0, 1.0, 0.0, 0.0, 0.0]);
    options.method = Some(SteerMethod::Chained);
    reached(&trailers, &options);
}

fn limited() -> System {
    let text = "states = ['x', 'y', 'th']\ninputs = ['s', 'w']\ndynamics = { x = 's*cos(th)', y = 's*sin(th)', th = 'w' }\n\
                ranges = { s = { min = -0.5, max = 0.5 }, w = { min = -0.2, max = 0.3 } }";
    System::parse("limited.toml", text).unwrap()
}

#[test]
fn ranges_are_obeyed_by_taking_longer() {
    let mut options = SteerOptions::between(&[0.0; 3], &[0.0, 1.0, 0.0]);
    options.duration = Some(1.0);
    let found = reached(&limited(), &options);
    assert_eq!(found.notes, [SteerNote::Longer { asked: 1.0 }]);
    for row in &found.signals.as_ref().unwrap().values {
        assert!(row[0].abs() <= 0.5 && (-0.2..=0.3).contains(&row[1]), "{row:?}");
    }
    options.duration = Some(500.0);
    let found = reached(&limited(), &options);
    assert!(found.notes.is_empty() && (found.signals.unwrap().duration() - 500.0).abs() < 1e-9);
}

#[test]
fn a_car_that_only_drives_forward_does_not_back_up() {
    let text = "states = ['x', 'y', 'th']\ninputs = ['s', 'w']\ndynamics = { x = 's*cos(th)', y = 's*sin(th)', th = 'w' }\n\
                ranges = { s = { min = 0, max = 1 } }";
    let forward = System::parse("forward.toml", text).unwrap();
    let found = reached(&forward, &SteerOptions::between(&[0.0; 3], &[4.0, 1.0, 0.0]));
    assert!(found.signals.unwrap().values.iter().all(|row| row[0] >= -1e-12));
}

#[test]
fn growth_2_3_5_has_no_chained_form_and_says_so() {
    let cartan = system(&["x", "y", "z", "a", "b"], &["u", "v"], &["u", "v", "x*v", "x^2*v", "x*y*v"]);
    let mut options = SteerOptions::between(&[0.0; 5], &[0.0, 0.0, 0.0, 0.0, 1.0]);
    options.method = Some(SteerMethod::Chained);
    let found = steer(&cartan, &options).unwrap();
    assert_eq!(found.status, SteerStatus::NotFound);
    assert!(matches!(found.attempts[0].reason, SteerReason::NoChainedForm(_)));
    assert!(found.signals.is_none() && found.end_error.is_infinite());
}
