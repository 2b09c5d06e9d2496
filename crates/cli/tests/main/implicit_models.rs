//! Models with mass matrices, algebraic variables, and discrete time, in every command: treated, or refused with exit code 2.

use crate::common::{code, file, json, scratch, text, within};

const DISCRETE: &str =
    "time = 'discrete'\nperiod = 0.1\nstates = ['x']\ninputs = ['u']\ndynamics = { x = 'x + 0.1*u' }\n";
const CURVED: &str = "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u - 1 - z' }\n[algebraic]\nz = { equation = 'z^2 - x', guess = 1 }\n";
const MASS: &str = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 2 }\n\
                    mass = { states = ['v'], matrix = [['m + x^2']] }\ndynamics = { x = 'v', v = 'u - z' }\nalgebraic = { z = 'z + 3*x - v' }\n";

#[test]
fn what_a_command_cannot_treat_is_refused_with_its_place() {
    let dir = scratch("implicit_refused");
    file(&dir, "discrete.toml", DISCRETE);
    file(&dir, "curved.toml", CURVED);
    for (model, place, reason) in
        [("discrete.toml", "discrete.toml:1:8", "discrete in time"), ("curved.toml", "curved.toml:5:18", "not linear")]
    {
        let commands =
            ["analyze", "affinize", "linearize", "trim", "certify", "transform --to kalman", "export --language c"];
        for command in commands {
            let arguments: Vec<&str> = command.split(' ').chain([model]).collect();
            let o = within(&dir, &arguments);
            let said = text(&o.stderr);
            assert_eq!(code(&o), 2, "{command}: {said}");
            assert!(o.stdout.is_empty() && said.contains(place) && said.contains(reason), "{command}: {said}");
            assert!(said.contains("`control`"), "{command}: {said}");
        }
    }
}

#[test]
fn what_is_eliminated_is_treated_by_every_command_and_told() {
    let dir = scratch("implicit_eliminated");
    file(&dir, "mass.toml", MASS);
    file(&dir, "scenario.toml", "duration = 1\nx0 = { x = 1 }\n");
    file(
        &dir,
        "problem.toml",
        "model = 'mass.toml'\nhorizon = { steps = 10, dt = 0.1 }\ncost = { stage = 'x^2 + z^2 + u^2' }\nrun = { x0 = { x = 1 } }\n",
    );
    let commands: [&[&str]; 3] = [
        &["analyze", "mass.toml"],
        &["simulate", "mass.toml", "--scenario", "scenario.toml"],
        &["control", "problem.toml"],
    ];
    for arguments in commands {
        let o = within(&dir, arguments);
        assert_eq!(code(&o), 0, "{arguments:?}: {}", text(&o.stderr));
        let said = text(&o.stdout);
        assert!(said.contains("the mass matrix is eliminated") && said.contains("`z` is eliminated"), "{said}");
    }
}

#[test]
fn a_run_into_a_fold_is_a_negative_answer_that_names_equation_and_time() {
    let dir = scratch("implicit_fold");
    file(&dir, "curved.toml", CURVED);
    file(&dir, "integrator.toml", "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u' }\n");
    file(&dir, "scenario.toml", "duration = 5\nx0 = { x = 4 }\n");
    let o = within(&dir, &["simulate", "curved.toml", "--scenario", "scenario.toml"]);
    let said = text(&o.stdout);
    assert_eq!(code(&o), 1, "{said}");
    // 2 (2 − ln 3) s.
    assert!(
        said.contains("stopped at t = 1.80") && said.contains("equation of `z`") && said.contains("residual"),
        "{said}"
    );
    let problem = "model = 'integrator.toml'\nplant = 'curved.toml'\nhorizon = { steps = 5, dt = 0.1 }\n\
                   cost = { stage = 'u^2 + 1e-6*x^2' }\nsolve = { method = 'rti' }\nrun = { x0 = { x = 1 }, steps = 30 }\n";
    file(&dir, "problem.toml", problem);
    let o = within(&dir, &["control", "problem.toml"]);
    let said = text(&o.stderr);
    assert_eq!(code(&o), 1, "{said}");
    assert!(said.contains("the plant stopped") && said.contains("equation of `z`"), "{said}");
}

#[test]
fn a_model_in_discrete_time_is_simulated_and_controlled() {
    let dir = scratch("implicit_discrete");
    file(&dir, "discrete.toml", DISCRETE);
    let scenario = file(&dir, "scenario.toml", "duration = 2\ninputs = { u = 't' }\n");
    let v = json(&["simulate", dir.join("discrete.toml").to_str().unwrap(), "--scenario", &scenario, "--json"]);
    // 0.1·Σ 0.1 k over k < 20.
    assert!((v["x_final"]["x"].as_f64().unwrap() - 1.9).abs() < 1e-12 && v["steps"] == 20, "{v}");
    let problem = "model = 'discrete.toml'\nhorizon = { steps = 10, dt = 0.1 }\ncost = { stage = 'x^2 + 0.1*u^2' }\nrun = { x0 = { x = 1 }, steps = 60 }\n";
    let v = json(&["control", &file(&dir, "problem.toml", problem), "--json"]);
    assert!(v["succeeded"] == true && v["x_final"]["x"].as_f64().unwrap().abs() < 1e-3, "{v}");
}
