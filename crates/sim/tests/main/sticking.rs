//! Signs that stick, by what they hold: states that add up each of them tell its value.

use bracketry_sim::{Inputs, Model, SimulationSettings, simulate};
use bracketry_system::System;

/// Entries of a matrix by rows, from a linear congruence: nothing special about them.
fn entries(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let next = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
    };
    std::iter::repeat_with(next).take(count).collect()
}

/// The state after a second from rest, the states of the given names with their rates.
fn after_a_second(rates: &[(String, String)]) -> Vec<f64> {
    let names: Vec<String> = rates.iter().map(|(name, _)| format!("'{name}'")).collect();
    let lines: Vec<String> = rates.iter().map(|(name, rate)| format!("{name} = '{rate}'")).collect();
    let text = format!("states = [{}]\n[dynamics]\n{}\n", names.join(", "), lines.join("\n"));
    let model = Model::new(&System::parse("sticking.toml", &text).unwrap(), &Inputs::new()).unwrap();
    let run = simulate(model, 0.0, &vec![0.0; rates.len()], 1.0, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run.trajectory.final_state().to_vec()
}

/// Bodies at rest, pushed by what A times some signs between −1 and 1 resists: those are the signs that hold them.
#[test]
fn the_signs_that_hold_bodies_are_those_that_resist_the_push() {
    for m in 1..6 {
        let mut a = entries(m * m, 7 + m as u64);
        // Each body feels its own friction the most.
        (0..m).for_each(|i| a[i * m + i] += m as f64);
        for signs in entries(3 * m, 70 + m as u64).chunks(m) {
            let mut rates = Vec::new();
            for i in 0..m {
                let push: f64 = (0..m).map(|j| a[i * m + j] * 0.9 * signs[j]).sum();
                let friction: Vec<String> = (0..m).map(|j| format!("({:.17e})*sign(v{j})", a[i * m + j])).collect();
                rates.push((format!("v{i}"), format!("{push:.17e} - ({})", friction.join(" + "))));
            }
            rates.extend((0..m).map(|i| (format!("z{i}"), format!("sign(v{i})"))));
            let end = after_a_second(&rates);
            assert!(end[..m].iter().all(|v| *v == 0.0), "{end:?}");
            assert!(end[m..].iter().zip(signs).all(|(z, s)| (z - 0.9 * s).abs() < 1e-9), "{m}: {end:?} {signs:?}");
        }
    }
}

/// Directions of which the equations use one component only; the other one moves in proportion, but for `more`.
fn directions(more: &str) -> Vec<f64> {
    // Pushed by what the signs 0.3 and −0.7 resist.
    let first = "(2*0.3 - 0.7 - 2*unit(p, w) - unit(q, y))";
    let second = "(-0.3 - 3*0.7 + unit(p, w) - 3*unit(q, y))";
    let rate = |name: &str, rate: String| (name.to_owned(), rate);
    after_a_second(&[
        rate("p", first.to_owned()),
        rate("w", format!("0.5*{first}")),
        rate("q", second.to_owned()),
        rate("y", format!("-2*{second}{more}")),
        rate("a", "unit(p, w)".to_owned()),
        rate("b", "unit(q, y)".to_owned()),
    ])
}

/// The equations of the components that move nothing repeat those of the others; where they contradict them, nothing sticks.
#[test]
fn components_that_move_nothing_stick_with_those_that_they_repeat() {
    let end = directions("");
    assert!(end[..4].iter().all(|v| v.abs() < 1e-12), "{end:?}");
    assert!((end[4] - 0.3).abs() < 1e-9 && (end[5] + 0.7).abs() < 1e-9, "{end:?}");
    let moved = directions(" + 0.1");
    assert!(moved[3].abs() > 0.01, "{moved:?}");
}
