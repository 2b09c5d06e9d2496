//! Inputs of finite sets: sum-up rounding keeps its bound, and nothing but the values is applied.

use crate::common::reports::read;
use bracketry_mpc::control;
use bracketry_mpc::controller::SumUpRounding;
use bracketry_mpc::problem::Note;
use proptest::prelude::*;

/// The temperature of a heated room.
const ROOM: &str = r#"
    states = ["x"]
    inputs = ["u"]
    parameters = { k = 1 }
    dynamics = { x = "k*u - x" }
"#;
/// A mass.
const MASS: &str = r#"
    states = ["x", "v"]
    inputs = ["u", "w"]
    dynamics = { x = "v", v = "u + w" }
"#;

/// The room, to be held at 0.7, with a period, a method, and more lines.
fn room(dt: f64, method: &str, lines: &str) -> String {
    let steps = (3.0 / dt).round();
    format!(
        r#"
        model = "model.toml"
        horizon = {{ steps = {steps}, dt = {dt} }}
        cost = {{ stage = "(x - 0.7)^2" }}
        constraints = {{ u = {{ values = [1, 0] }} }}
        solve = {{ method = "{method}" }}
        run = {{ steps = {steps} }}
        {lines}
        "#
    )
}

proptest! {
    #[test]
    fn sum_up_rounding_keeps_the_bound_of_sager(relaxed in prop::collection::vec(0.0..=1.0_f64, 1..200), h in 0.01..1.0_f64) {
        let mut rounding = SumUpRounding::new(&[0.0, 1.0]).unwrap();
        let (mut integral, mut on) = (0.0, 0.0);
        for u in relaxed {
            // Sum-up rounding (Sager, Bock, and Diehl 2012): on where at least half an interval of what was asked is missing.
            integral += h * u;
            let missing = integral - on;
            let value = rounding.round(u, h);
            if (missing - h / 2.0).abs() > 1e-9 {
                prop_assert_eq!(value, f64::from(u8::from(missing >= h / 2.0)));
            }
            on += h * value;
            prop_assert!((integral - on).abs() <= h / 2.0 + 1e-9);
            prop_assert!((rounding.error() - (integral - on)).abs() < 1e-9);
        }
    }

    #[test]
    fn several_values_keep_half_the_largest_gap(
        steps in prop::collection::vec(0.1..2.0_f64, 1..5),
        relaxed in prop::collection::vec(0.0..=1.0_f64, 1..200),
        lengths in prop::collection::vec(0.1..1.0_f64, 200),
    ) {
        let mut values = vec![-1.0];
        for s in &steps {
            values.push(values[values.len() - 1] + s);
        }
        let (first, last) = (values[0], values[values.len() - 1]);
        let gap = steps.iter().fold(0.0_f64, |g, s| g.max(*s));
        let (mut equal, mut other) = (SumUpRounding::new(&values).unwrap(), SumUpRounding::new(&values).unwrap());
        for (r, h) in relaxed.iter().zip(&lengths) {
            let u = first + r * (last - first);
            prop_assert!(values.contains(&equal.round(u, 0.3)));
            prop_assert!(equal.error().abs() <= 0.3 * gap / 2.0 + 1e-9);
            other.round(u, *h);
            prop_assert!(other.error().abs() <= gap + 1e-9, "the longest interval is 1");
        }
    }
}

#[test]
fn every_method_applies_values_alone_and_states_the_gap() {
    for method in ["rti", "sqp", "plan"] {
        let run = control(&read(ROOM, &room(0.1, method, "")).unwrap()).unwrap().run;
        assert!(run.closed_loop.u.iter().all(|u| u[0] == 0.0 || u[0] == 1.0), "{method}");
        let rounding = run.report.rounding.as_ref().unwrap();
        assert_eq!(rounding.inputs.get("u"), Some(&vec![0.0, 1.0]));
        assert!(rounding.gap > 0.0, "{method}: the relaxed optimum is a lower bound: {rounding:?}");
        assert!((rounding.rounded_cost - rounding.relaxed_cost - rounding.gap).abs() < 1e-12);
        assert!(rounding.accumulated_error <= 0.05 + 1e-9, "{method}: {rounding:?}");
        assert!((run.report.x_final.get("x").unwrap() - 0.7).abs() < 0.06, "{method}");
        assert!(run.report.succeeded, "{:?}", run.report.notes);
    }
    let free =
        control(&read(ROOM, &room(0.1, "rti", "").replace("values = [1, 0]", "min = 0, max = 1")).unwrap()).unwrap();
    assert!(free.run.report.rounding.is_none());
}

#[test]
fn the_gap_vanishes_with_the_period() {
    let gap = |dt: f64| control(&read(ROOM, &room(dt, "sqp", "")).unwrap()).unwrap().run.report.rounding.unwrap().gap;
    let (coarse, fine) = (gap(0.2), gap(0.05));
    assert!(fine < coarse / 2.0, "{coarse} and {fine}");
}

#[test]
fn much_that_rounding_costs_is_a_note_and_no_failure() {
    // One switch per second is far too slow.
    let text = room(1.0, "sqp", "").replace("run = { steps = 3", "run = { x0 = { x = 0.7 }, steps = 3");
    let report = control(&read(ROOM, &text).unwrap()).unwrap().run.report;
    assert!(
        report.notes.iter().any(|n| matches!(n, Note::RoundingCosts { relaxed, rounded } if rounded > relaxed)),
        "{report:?}"
    );
    assert!(report.succeeded);
}

#[test]
fn delays_trees_and_other_inputs_go_with_values() {
    let text = r#"
        model = "model.toml"
        horizon = { steps = 20, dt = 0.1 }
        cost = { stage = "x^2 + v^2 + 0.01*u^2 + 0.01*w^2" }
        constraints = { u = { values = [-1, 0.5, 1] }, w = { min = -0.1, max = 0.1 } }
        run = { x0 = { x = 1 }, steps = 60, delay = 2, u0 = { u = 0.5 } }
    "#;
    let run = control(&read(MASS, text).unwrap()).unwrap().run;
    assert!(run.closed_loop.u.iter().all(|u| [-1.0, 0.5, 1.0].contains(&u[0])));
    assert_eq!(run.closed_loop.u[..2].iter().map(|u| u[0]).collect::<Vec<_>>(), [0.5, 0.5]);
    assert!(run.closed_loop.u.iter().any(|u| u[1].abs() > 1e-3 && u[1].abs() < 0.1), "this input is not rounded");
    assert!(run.report.x_final.get("x").unwrap().abs() < 0.3);
    // Without u0, the value closest to zero is at rest.
    let run = control(&read(MASS, &text.replace(", u0 = { u = 0.5 }", "")).unwrap()).unwrap().run;
    assert_eq!(run.closed_loop.u[0], [0.5, 0.0]);

    let tree = room(0.1, "sqp", "uncertainty = { parameters = { k = [0.8, 1, 1.2] } }");
    let problem = read(ROOM, &tree).unwrap();
    let run = control(&problem).unwrap().run;
    assert!(run.closed_loop.u.iter().all(|u| u[0] == 0.0 || u[0] == 1.0));
    assert!(run.report.rounding.is_some() && run.report.scenarios.is_some());
    let mut live = problem.controller().unwrap();
    for (x, u) in run.closed_loop.x.iter().zip(&run.closed_loop.u) {
        assert_eq!(live.step(x).unwrap().step.u, *u);
    }
}

#[test]
fn a_lost_measurement_is_answered_by_a_value() {
    let text = room(0.1, "rti", "").replace("run = {", "run = { faults = [{ at = 3, until = 12, lost = true }],");
    let run = control(&read(ROOM, &text).unwrap()).unwrap().run;
    assert!(run.report.status.fallback > 0);
    assert!(run.closed_loop.u.iter().all(|u| u[0] == 0.0 || u[0] == 1.0));
}

#[test]
fn mistakes_are_said_with_their_place_and_remedy() {
    let model = ROOM.replace("parameters", "ranges = { u = { min = 0, max = 2 } }\n    parameters");
    let mistakes = [
        ("u = { values = 1 }", "must be a list"),
        ("u = { values = [1] }", "fewer than two values"),
        ("u = { values = [] }", "fewer than two values"),
        ("u = { values = [0, 1, 1] }", "occurs twice"),
        ("u = { values = [0, 3] }", "outside its range 0 to 2"),
        ("u = { values = [0, 1], max = 1 }", "cannot be combined with `max`"),
        ("u = { values = [0, 1], rate = { max = 1 } }", "cannot be combined with `rate`"),
        ("x = { values = [0, 1] }", "applies to an input"),
        ("u = { values = [0, \"q\"] }", "q"),
    ];
    for (entry, said) in mistakes {
        let text = room(0.1, "sqp", "").replace("u = { values = [1, 0] }", entry);
        let error = read(&model, &text).err().unwrap().to_string();
        assert!(error.contains(said) && error.contains("problem.toml:"), "{entry}: {error}");
    }
    for (from, to) in [("run = {", "run = { u0 = { u = 0.5 },"), ("solve = {", "solve = { rest = { u = 0.5 },")] {
        let error = read(&model, &room(0.1, "sqp", "").replace(from, to)).err().unwrap().to_string();
        assert!(error.contains("does not take the value 0.5") && error.contains("choose one of 0, 1"), "{error}");
    }
}

#[test]
fn the_heater_of_the_guide_holds_its_temperature() {
    let guide =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/mpc_finite_inputs.md")).unwrap();
    let blocks: Vec<&str> = guide.split("```toml\n").skip(1).map(|b| b.split("```").next().unwrap()).collect();
    let run = control(&read(blocks[0], blocks[1]).unwrap()).unwrap().run;
    assert!(run.report.succeeded && run.closed_loop.u.iter().all(|u| u[0] == 0.0 || u[0] == 1.0));
    assert!((run.report.x_final.get("x").unwrap() - 0.7).abs() < 0.05);
}
