//! Closed loops as text.

use bracketry_mpc::{ControlProblem, Controlled, control};
use bracketry_system::System;

const CART: &str = r#"
states = ["x", "v"]
inputs = ["u"]
dynamics = { x = "v", v = "u" }
"#;

const PROBLEM: &str = r#"
model = "cart.toml"
[horizon]
steps = 20
dt = 0.1
[cost]
stage = "(x - 1)^2 + 0.1*v^2 + 0.01*u^2"
[run]
steps = 2
"#;

#[test]
fn figures_of_any_size_stay_short() {
    let problem = ControlProblem::parse("p.toml", PROBLEM, |file| System::parse(file, CART).map_err(Box::new)).unwrap();
    let mut report = control(&problem).unwrap().run.report;
    (report.period_ms, report.closed_loop_cost) = (1e-297, 1.234_567_89e12);
    let said = bracketry_report::control::text(&report);
    assert!(said.contains("sampling period 1e-297 ms") && said.contains("1.234568e12 in closed loop"), "{said}");
}

fn controlled(rest: &str) -> (ControlProblem, Controlled) {
    let text = format!(
        "model = \"cart.toml\"\nhorizon = {{ steps = 20, dt = 0.1 }}\nsolve = {{ method = \"rti\" }}\n\
         run = {{ x0 = {{ x = 1, v = 0.5 }}, steps = 30 }}\n{rest}"
    );
    let problem = ControlProblem::parse("p.toml", &text, |file| System::parse(file, CART).map_err(Box::new)).unwrap();
    let controlled = control(&problem).unwrap();
    (problem, controlled)
}

/// References and constraints stand in the table with the values that their definitions give at the states and inputs beside them.
#[test]
fn references_and_constraints_are_columns() {
    let (problem, controlled) = controlled(
        r#"
        references = { r = "sin(t)" }
        cost = { stage = "(x - r)^2 + (v - der(r))^2 + 0.01*u^2" }
        [constraints]
        reach = { expression = "x + 2*v", max = 3 }
        gap = { expression = "x", max = "1.5 + 0.1*t" }
        u = { min = -5, max = 5, rate = { min = -40, max = 40 } }
        pull = { norm = ["u", "v"], max = "6 + x" }
        "#,
    );
    let (header, rows) = bracketry_report::control::table(&problem, &controlled);
    assert_eq!(header, ["t", "x", "v", "u", "r", "der(r)", "reach", "gap - max", "rate(u)", "pull", "pull max"]);
    assert_eq!(rows.len(), 31);
    let mut before = 0.0;
    for row in &rows {
        let [t, x, v, u, found @ ..] = &row[..] else { panic!() };
        let expected = [t.sin(), t.cos(), x + 2.0 * v, x - 1.5 - 0.1 * t, (u - before) / 0.1, u.hypot(*v), 6.0 + x];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "t = {t}: {found} {expected}");
        }
        before = *u;
    }
    // The states follow the reference and its derivative; the figure has them, and a panel for each constraint.
    let followed: Vec<Option<&str>> = problem.references.iter().map(|r| r.tracked_by.as_deref()).collect();
    assert_eq!(followed, [Some("x"), Some("v")]);
    let drawing = bracketry_report::control::figure(&problem, &controlled).unwrap();
    let svg = drawing.svg();
    for label in ["r", "der(r)", "reach", "gap - max", "pull"] {
        assert!(svg.lines().any(|line| line == label), "{label}");
    }
}

/// What a cost draws to a reference is told apart from what merely occurs beside it.
#[test]
fn a_state_follows_a_reference_where_the_cost_vanishes_at_it() {
    let followed = |stage: &str| {
        let (problem, _) = controlled(&format!("references = {{ r = 0.5 }}\ncost = {{ stage = \"{stage}\" }}"));
        problem.references[0].tracked_by.clone()
    };
    for (stage, by) in [
        ("3*(x - r)^2 + v^2 + u^2", Some("x")),
        ("(r - v)^2 + x^2 + u^2", Some("v")),
        ("1 - cos(x - r) + x^2*v^2 + u^2", Some("x")),
        ("(x + v - r)^2 + u^2", None),
        ("r*x^2 + u^2", None),
    ] {
        assert_eq!(followed(stage).as_deref(), by, "{stage}");
    }
}

/// The largest violation is printed with its bound and its time.
#[test]
fn the_text_names_the_bound_that_is_violated() {
    let (_, controlled) =
        controlled("cost = { stage = \"x^2 + u^2\" }\nconstraints = { x = { max = 0.9 }, u = { min = -1, max = 1 } }");
    let report = &controlled.run.report;
    let at = report.constraint_violation_at.as_ref().unwrap();
    let said = bracketry_report::control::text(report);
    assert!(said.contains(&format!(": `x` above its max at sample {}", at.sample)), "{said}");
}
