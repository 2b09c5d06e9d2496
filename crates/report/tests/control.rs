//! Closed loops as text.
#![allow(clippy::unwrap_used)]

use bracketry_mpc::{ControlProblem, control};
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
