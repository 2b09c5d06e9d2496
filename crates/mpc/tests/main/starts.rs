//! Plans start from the guess at rest and from its motion, and the better one counts.

use crate::common::noise::Noise;
use crate::common::reports::run;
use bracketry_mpc::problem::Note;

/// A car overtakes two slower ones, to the left or to the right of either.
#[test]
fn a_loop_finds_what_a_plan_finds() {
    let car = "states = [\"x\", \"y\", \"th\", \"v\"]\ninputs = [\"a\", \"d\"]\n\
               dynamics = { x = \"v*cos(th)\", y = \"v*sin(th)\", th = \"v*tan(d)/2.5\", v = \"a\" }";
    let mut noise = Noise::new(8);
    for _ in 0..4 {
        let (first, second) = (0.3 + 0.4 * noise.uniform(), -0.3 - 0.4 * noise.uniform());
        let (near, far) = (18.0 + 6.0 * noise.uniform(), 48.0 + 8.0 * noise.uniform());
        let of = |method: &str| {
            let text = format!(
                "horizon = {{ steps = 40, dt = 0.2 }}\n\
                 cost = {{ stage = \"0.1*(v - 10)^2 + 0.05*y^2 + 0.1*a^2 + 5*d^2 + th^2\" }}\n\
                 solve = {{ {method} }}\nrun = {{ x0 = {{ v = 10 }}, steps = 40 }}\n[constraints]\n\
                 a = {{ min = -5, max = 3 }}\nd = {{ min = -0.3, max = 0.3 }}\ny = {{ min = -4, max = 4 }}\n\
                 one = {{ expression = \"((x - {near:?} - 4*t)/6)^2 + ((y - {first:?})/2)^2\", min = 1 }}\n\
                 two = {{ expression = \"((x - {far:?} - 4*t)/6)^2 + ((y - {second:?})/2)^2\", min = 1 }}"
            );
            run(car, &text)
        };
        let (chosen, plan) = (of(""), of("method = \"plan\", margin = 0"));
        assert!(chosen.succeeded && plan.succeeded, "{chosen:?} {plan:?}");
        let (a, b) = (chosen.open_loop_cost, plan.open_loop_cost);
        assert!((a - b).abs() < 0.015 * a.max(b), "{a} {b}");
        assert!(chosen.closed_loop_cost < 1.1 * a, "{chosen:?}");
    }
}

/// Poles on carts, swung up from angles at which the guess leads to either side: a run never ends with a plan that another start outdoes.
#[test]
fn no_run_is_outdone_by_a_plan_from_another_start() {
    let mut noise = Noise::new(21);
    for _ in 0..6 {
        let (angle, push) = (2.0 + 1.1 * noise.uniform(), 6.0 * noise.uniform() - 3.0);
        let model = "states = [\"x\", \"th\", \"v\", \"w\"]\ninputs = [\"u\"]\nparameters = { m = 0.2, l = 0.5, g = 9.81 }\n\
                     definitions = { a = \"(u + m*sin(th)*(l*w^2 - g*cos(th)))/(1 + m*sin(th)^2)\" }\n\
                     dynamics = { x = \"v\", th = \"w\", v = \"a\", w = \"(g*sin(th) - a*cos(th))/l\" }";
        let of = |guess: &str| {
            run(
                model,
                &format!(
                    "horizon = {{ steps = 50, dt = 0.03 }}\n{guess}\n\
                     cost = {{ stage = \"x^2 + 10*(1 - cos(th)) + 0.01*(v^2 + w^2) + 0.001*u^2\", terminal = \"50*(1 - cos(th)) + w^2\" }}\n\
                     constraints = {{ u = {{ min = -20, max = 20 }} }}\nrun = {{ x0 = {{ th = {angle:?} }}, steps = 60 }}"
                ),
            )
        };
        let (plain, guessed) = (of(""), of(&format!("guess = {{ u = {push:?} }}")));
        for report in [&plain, &guessed] {
            assert!(!report.notes.iter().any(|n| matches!(n, Note::BetterElsewhere { .. })), "{:?}", report.notes);
            assert!(report.x_final.get("th").is_some_and(|th| th.cos() > 0.95), "{report:?}");
        }
        // Inputs at rest are among the starts of every guess.
        assert!(guessed.open_loop_cost < 1.011 * plain.open_loop_cost, "{angle} {push}: {guessed:?} {plain:?}");
    }
}
