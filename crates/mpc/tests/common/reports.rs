//! Problems of two texts, and what their runs report.

use bracketry_mpc::{ClosedLoopReport, ControlProblem, control};
use bracketry_system::System;

pub const SPRING_MASS: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    parameters = { m = 1, k = 0.8, c = 0.5, F = 0.2 }
    dynamics = { x = "v", v = "(-k*x - c*v + u - F*sign(v))/m" }
"#;

pub const TO_TARGET: &str = r#"
    horizon = { steps = 20, dt = 0.15 }
    cost = { stage = "(x - 2)^2 + v^2 + 0.1*(u - 1.8)^2" }
    constraints = { u = { min = -2, max = 2 } }
"#;

pub const PENDULUM: &str = r#"
    states = ["th", "w"]
    inputs = ["u"]
    dynamics = { th = "w", w = "9.81*sin(th) - 0.1*w + u" }
"#;

pub fn problem(model: &str, text: &str) -> ControlProblem {
    let text = format!("model = \"model.toml\"\n{text}");
    ControlProblem::parse("problem.toml", &text, |file| System::parse(file, model).map_err(Box::new))
        .unwrap_or_else(|e| panic!("{e}"))
}

pub fn run(model: &str, text: &str) -> ClosedLoopReport {
    control(&problem(model, text)).unwrap_or_else(|e| panic!("{e}")).run.report
}
