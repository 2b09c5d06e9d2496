//! Problem files: what they say is what runs, and what is wrong in them is named.

use bracketry_mpc::closed_loop::RungeKuttaPlant;
use bracketry_mpc::ocp::Softness;
use bracketry_mpc::problem::Method;
use bracketry_mpc::{ControlProblem, SymbolicDynamics};
use std::f64::consts::PI;

const CART_POLE: &str = include_str!("../../../../models/cart_pole_swing_up.toml");

fn read(text: &str) -> Result<ControlProblem, String> {
    ControlProblem::parse("problem.toml", text, |_| Ok(crate::common::cart_pole())).map_err(|e| e.to_string())
}

#[test]
fn a_problem_file_reproduces_the_reference_cost() {
    let problem = read(CART_POLE).unwrap();
    let dynamics = SymbolicDynamics::new(&problem.plant).unwrap();
    let mut plant = RungeKuttaPlant::new(Box::new(dynamics), problem.plant_substeps);
    let report = problem.run(&mut plant).unwrap().report;
    assert!((report.closed_loop_cost / 2047.463 - 1.0).abs() < 1e-3, "{}", report.closed_loop_cost);
    assert_eq!((report.steps, report.status.solved), (100, 100));
    assert!(report.constraint_violation_max <= 0.0);
    assert!(report.x_final.get("th").unwrap().abs() < 1e-2);
}

#[test]
fn every_section_reaches_the_problem() {
    let text = CART_POLE.replace("[solve]", "[target]\np = { value = \"l/2\", tolerance = 0.1 }\n[trust]\nw = 3\n[guess]\nu = \"sin(pi*t)\"\n[references]\ngoal = \"2*t\"\n[solve]\nmargin = 0.1")
        .replace("\"rti\"", "\"plan\"")
        .replace("u = { min", "v = { max = 2, soft = [1, 7] }\nw = { min = -9, hard = true }\nu = { min")
        .replace("1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2 + 1e-2*u^2", "(p - goal)^2");
    let mut problem = read(&text).unwrap();
    assert!(matches!(problem.method, Method::Plan { margin, .. } if margin == 0.1));
    assert_eq!(problem.x0, [0.0, PI, 0.0, 0.0]);
    let t = problem.ocp.targets[0];
    assert_eq!((t.state, t.value, t.linear, t.quadratic), (0, 0.4, 10.0, 0.5 / 0.1 / 0.1));
    assert_eq!(problem.ocp.state_trust[3], 3.0);
    assert_eq!(problem.ocp.input_trust, [80.0]);
    assert!((problem.guess[2][0] - (PI * 0.05).sin()).abs() < 1e-15);
    assert_eq!(problem.ocp.state_bounds[2].softness, Softness::Soft { linear: 1.0, quadratic: 7.0 });
    assert_eq!(problem.ocp.state_bounds[3].softness, Softness::Hard);
    assert_eq!(problem.ocp.references[10], [0.4]);
    let stage = problem.ocp.stage.as_mut().unwrap();
    assert_eq!(stage.value(&[1.0, 0.0, 0.0, 0.0], &[0.0], 0.0, &[0.4]), 0.36);
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    for (from, to, message, place) in [
        ("integrator", "integrater", "unknown key `integrater` in [horizon]", "problem.toml:7:1"),
        ("\"rk4\"", "\"euler\"", "there is no integrator `euler`", "problem.toml:7:14"),
        ("\"rti\"", "\"magic\"", "there is no method `magic`", "problem.toml:18:10"),
        ("u = { min = -80", "q = { min = -80", "`q` is not a state or input", "problem.toml:15:1"),
        ("min = -80", "min = 90", "`u` cannot be both above 90 and below 80", "problem.toml:15:5"),
        ("max = 80", "max = 80, soft = [1, 1]", "bounds on inputs are hard", "problem.toml:15:35"),
        ("x0 = { th", "x0 = { ht", "`ht` is not a state", "problem.toml:23:8"),
        ("steps = 40", "steps = 2.5", "whole number", "problem.toml:5:9"),
        ("dt = 0.02", "dt = -0.02", "`dt` must be positive", "problem.toml:6:6"),
        ("1e-2*w^2\"", "1e-2*z^2\"", "`z`", "problem.toml:12:"),
        ("1e-2*w^2\"", "1e-2*u^2\"", "`u`", "problem.toml:12:"),
        ("[run]", "[walk]", "unknown key `walk`", "problem.toml:22:2"),
    ] {
        let error = read(&CART_POLE.replacen(from, to, 1)).err().unwrap();
        assert!(error.contains(message) && error.contains(place), "{to}: {error}");
    }
    assert!(read("[horizon]\nsteps = 1").err().unwrap().contains("no model is named"));
    assert!(read(&CART_POLE.replace("[horizon]", "[run.x]")).is_err());
}
