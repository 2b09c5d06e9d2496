//! Steering by Philip Hall coordinates.

use crate::common::{Numbers, model, reached, system};
use bracketry_lie::algebra::HallBasis;
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

/// The system whose states are the coordinates of a series in the elements of a Hall basis, exponentials of which it is a product of
/// (Sussmann 1986, A product expansion for the Chen series): where H = ad_A^q B, c_H' = c_A^q/q! c_B'. It is free but for brackets
/// longer than the degree.
fn free_nilpotent(letters: usize, degree: usize) -> System {
    let basis = HallBasis::new(letters, degree).unwrap();
    let mut rates: Vec<String> = Vec::new();
    for element in basis.elements() {
        let Some((a, mut b)) = element.factors else {
            rates.push(format!("u{}", rates.len()));
            continue;
        };
        let mut q = 1;
        while let Some((_, inner)) = basis.elements()[b].factors.filter(|f| f.0 == a) {
            (q, b) = (q + 1, inner);
        }
        rates.push(format!("c{a}^{q}/{}*{}", (1..=q).product::<usize>(), rates[b]));
    }
    let names = |letter: &str, n: usize| (0..n).map(|i| format!("{letter}{i}")).collect::<Vec<_>>();
    let (states, inputs) = (names("c", rates.len()), names("u", letters));
    let texts = |list: &[String]| list.iter().map(|s| format!("'{s}'")).collect::<Vec<_>>().join(", ");
    let lines: Vec<String> = states.iter().zip(&rates).map(|(s, r)| format!("{s} = '{r}'")).collect();
    let head = format!("states = [{}]\ninputs = [{}]\n[dynamics]\n", texts(&states), texts(&inputs));
    System::parse("free.toml", &(head + &lines.join("\n"))).unwrap()
}

/// Flows of single letters multiply to the series that they are made for: in the free systems nothing else would reach the end, there
/// and back, as the inverse of a product of flows is that of the backward flows.
#[test]
fn free_nilpotent_systems_are_steered_exactly_there_and_back() {
    for (letters, degree, dimension) in [(2, 2, 3), (2, 5, 14), (3, 3, 14)] {
        let free = free_nilpotent(letters, degree);
        assert_eq!(free.states.len(), dimension);
        let to: Vec<f64> = (0..dimension).map(|i| 0.3 + 0.2 * ((i * 7) % 5) as f64 - 0.5 * (i % 3) as f64).collect();
        let start = vec![0.0; dimension];
        for (from, to) in [(&start, &to), (&to, &start)] {
            let found = reached(&free, &by_brackets(from, to));
            assert!(found.end_error < 1e-9, "{letters} letters, degree {degree}: {}", found.end_error);
            let Some(Plan::Nilpotent { is_nilpotent, rounds, degree: longest, .. }) = found.plan else {
                panic!("{:?}", found.plan)
            };
            assert!(is_nilpotent && rounds == 1 && longest == degree, "{rounds} rounds, degree {longest}");
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
