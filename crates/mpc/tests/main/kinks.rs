//! Limits written into the equations with `min`, `max`, and `abs`: plans obey them, and cost what the same limits cost as constraints.

use crate::common::reports::run;

/// A saturated actuator, as part of the model and as bounds of the input.
#[test]
fn a_saturation_in_the_model_is_a_bound_of_the_input() {
    for (start, steps, limit) in [(3.0, 20, 1.0), (0.5, 15, 1.0), (-2.0, 25, 0.4), (8.0, 10, 3.0)] {
        let problem = |bound: f64| {
            format!(
                "horizon = {{ steps = {steps}, dt = 0.1 }}\ncost = {{ stage = \"x^2 + 0.01*u^2\" }}\n\
                 constraints = {{ u = {{ min = -{bound:?}, max = {bound:?} }} }}\n\
                 run = {{ x0 = {{ x = {start:?} }}, steps = {steps} }}"
            )
        };
        let plain = "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\" }";
        let saturated =
            format!("states = [\"x\"]\ninputs = [\"u\"]\ndynamics = {{ x = \"max(-{limit:?}, min({limit:?}, u))\" }}");
        let (bounded, inside) = (run(plain, &problem(limit)), run(&saturated, &problem(5.0 * limit)));
        assert!(bounded.succeeded && inside.succeeded, "{start} {limit}: {:?}", inside.notes);
        for (a, b) in
            [(bounded.closed_loop_cost, inside.closed_loop_cost), (bounded.open_loop_cost, inside.open_loop_cost)]
        {
            assert!((a - b).abs() < 5e-3 * a, "{start} {limit}: {a} {b}");
        }
    }
}

/// Quadratic drag, which has a kink in its second derivative alone, and one side of a hard stop.
#[test]
fn drag_with_abs_is_planned_against() {
    let model = "states = [\"x\", \"v\"]\ninputs = [\"u\"]\ndynamics = { x = \"v\", v = \"u - 0.5*v*abs(v)\" }";
    let report = run(
        model,
        "horizon = { steps = 30, dt = 0.1 }\ncost = { stage = \"10*(x - 1)^2 + v^2 + 0.1*u^2\" }\n\
         constraints = { u = { min = -4, max = 4 } }\nrun = { steps = 60 }",
    );
    assert!(report.succeeded && report.notes.is_empty(), "{:?}", report.notes);
    assert!(report.x_final.get("x").is_some_and(|x| (x - 1.0).abs() < 1e-3));
}

/// Loops whose input may go beyond saturation come to the goal as those whose input may not, but for a detour of an interval.
#[test]
fn a_loop_does_not_stay_where_an_actuator_saturates() {
    let model = "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"max(-1, min(1, u))\" }";
    for (start, weight) in [(3.0, 1e-3), (-2.0, 1e-2), (1.0, 1e-3)] {
        let costs = [1.1, 2.0, 5.0].map(|bound| {
            let report = run(
                model,
                &format!(
                    "horizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = \"x^2 + {weight:?}*u^2\" }}\n\
                     constraints = {{ u = {{ min = -{bound:?}, max = {bound:?} }} }}\nrun = {{ x0 = {{ x = {start:?} }}, steps = 40 }}"
                ),
            );
            assert!(report.x_final.get("x").is_some_and(|x| x.abs() < 1e-3), "{start} {bound}: {report:?}");
            report.closed_loop_cost
        });
        assert!(costs.iter().all(|cost| (cost - costs[0]).abs() < 2e-2 * costs[0]), "{start}: {costs:?}");
    }
}
