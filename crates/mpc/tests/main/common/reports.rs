//! Problems of two texts, and what their runs report.

use bracketry_mpc::problem::{ClosedLoopReport, ControlRun, FoundValues, ProblemError};
use bracketry_mpc::{ControlProblem, control};
use bracketry_system::System;

pub(crate) const SPRING_MASS: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    parameters = { m = 1, k = 0.8, c = 0.5, F = 0.2 }
    dynamics = { x = "v", v = "(-k*x - c*v + u - F*sign(v))/m" }
"#;

pub(crate) const TO_TARGET: &str = r#"
    horizon = { steps = 20, dt = 0.15 }
    cost = { stage = "(x - 2)^2 + v^2 + 0.1*(u - 1.8)^2" }
    constraints = { u = { min = -2, max = 2 } }
"#;

pub(crate) const PENDULUM: &str = r#"
    states = ["th", "w"]
    inputs = ["u"]
    dynamics = { th = "w", w = "9.81*sin(th) - 0.1*w + u" }
"#;

/// A problem whose text names a model file, whichever it is.
pub(crate) fn read(model: &str, text: &str) -> Result<ControlProblem, ProblemError> {
    ControlProblem::parse("problem.toml", text, |file| System::parse(file, model).map_err(Box::new))
}

/// A problem whose text names no model file.
pub(crate) fn read_with_model(model: &str, text: &str) -> Result<ControlProblem, ProblemError> {
    read(model, &format!("model = \"model.toml\"\n{text}"))
}

pub(crate) fn problem(model: &str, text: &str) -> ControlProblem {
    read_with_model(model, text).unwrap_or_else(|e| panic!("{e}"))
}

pub(crate) fn run(model: &str, text: &str) -> ClosedLoopReport {
    control(&problem(model, text)).unwrap_or_else(|e| panic!("{e}")).run.report
}

/// What a problem leaves free, found, and the run with it.
pub(crate) fn run_with_found(model: &str, text: &str) -> (FoundValues, ControlRun) {
    let run = control(&read_with_model(model, text).unwrap()).unwrap().run;
    let found = run.report.found.clone().unwrap();
    assert!(found.converged, "{found:?}");
    (found, run)
}

/// Equal up to a tolerance, relative to numbers beyond 1.
pub(crate) fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{a} is not {b}");
}
