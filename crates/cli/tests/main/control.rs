//! The control command on files as users write them.

use std::fs;

use crate::common::{bracketry, code, file, json, scratch};
use serde_json::Value;

#[test]
fn the_ten_lines_of_the_guide_swing_a_pendulum_up() {
    let guide = fs::read_to_string(crate::common::root().join("docs/mpc.md")).unwrap();
    let blocks: Vec<&str> = guide.split("```toml\n").skip(1).map(|b| b.split("```").next().unwrap()).collect();
    assert!(blocks[0].lines().count() + blocks[1].lines().count() <= 10);
    let dir = scratch("control_ten_lines");
    file(&dir, "pendulum.toml", blocks[0]);
    let problem = file(&dir, "problem.toml", blocks[1]);
    let v = json(&["control", &problem, "--json"]);
    assert_eq!(v["succeeded"], true, "{v}");
    assert!(v["x_final"]["th"].as_f64().unwrap().abs() < 1e-3, "{v}");
}

#[test]
fn a_loop_survives_faults_noise_and_delay_and_counts_them() {
    let dir = scratch("control_faults");
    file(&dir, "cart.toml", "states = ['p', 'v']\ninputs = ['u']\n[dynamics]\np = 'v'\nv = 'u'\n");
    let text = "model = 'cart.toml'\nhorizon = { steps = 20, dt = 0.1 }\ncost = { stage = 'p^2 + 0.1*v^2 + 0.01*u^2' }\n\
                constraints = { u = { min = -1, max = 1 } }\n[solve]\npolicy = 'brake'\n\
                brake = { u = { velocity = 'v', rate = 2 } }\n[run]\nx0 = { p = 1 }\nsteps = 80\nseed = 3\ndelay = 1\n\
                noise = { p = 1e-4 }\nfaults = [{ at = 5, until = 7, lost = true }, { at = 12, nan = ['v'] },\n\
                { at = 20, disturbance = { v = 0.5 } }, { at = 30, solver_limit = 1 }]\n";
    let run = || {
        let o = bracketry(&["control", &file(&dir, "problem.toml", text), "--json"]);
        // Inputs of the failure policy are a negative answer.
        assert_eq!(code(&o), 1, "{}", String::from_utf8_lossy(&o.stderr));
        serde_json::from_slice::<Value>(&o.stdout).unwrap()
    };
    let v = run();
    let status = &v["status"];
    assert_eq!((&status["reasons"]["lost_sample"], &status["reasons"]["measurement"]), (&3.into(), &1.into()), "{v}");
    assert_eq!(status["reasons"]["qp_limit"], 1, "{v}");
    assert_eq!(status["sources"]["brake"], 5, "{v}");
    assert!(v["x_final"]["p"].as_f64().unwrap().abs() < 5e-3, "{v}");
    assert_eq!(v["closed_loop_cost"], run()["closed_loop_cost"], "the same seed gives the same run");
}

#[test]
fn the_seed_of_the_command_line_replaces_that_of_the_file() {
    let dir = scratch("control_seed");
    file(&dir, "cart.toml", "states = ['p', 'v']\ninputs = ['u']\n[dynamics]\np = 'v'\nv = 'u'\n");
    let text = "model = 'cart.toml'\nhorizon = { steps = 10, dt = 0.1 }\ncost = { stage = 'p^2 + 0.1*v^2 + 0.01*u^2' }\n\
                run = { x0 = { p = 1 }, steps = 10, seed = 3, noise = { p = 1e-2 } }\n";
    let problem = file(&dir, "problem.toml", text);
    let cost =
        |options: &[&str]| json(&[&["control", &problem, "--json"], options].concat())["closed_loop_cost"].clone();
    assert_eq!(cost(&[]), cost(&["--seed", "3"]));
    assert_eq!(cost(&["--seed", "5"]), cost(&["--seed", "5"]));
    assert_ne!(cost(&["--seed", "5"]), cost(&[]));
}

#[test]
fn the_figures_of_a_run_have_the_agreed_names() {
    let dir = scratch("control_keys");
    file(&dir, "cart.toml", "states = ['p', 'v']\ninputs = ['u']\n[dynamics]\np = 'v'\nv = 'u'\n");
    let text = "model = 'cart.toml'\nhorizon = { steps = 10, dt = 0.1 }\ncost = { stage = 'log(p - 5) + u^2' }\nrun = { x0 = { p = 1 } }\n";
    let o = bracketry(&["control", &file(&dir, "problem.toml", text), "--json"]);
    assert_eq!(code(&o), 1, "a cost that is not a number is a negative answer");
    let v: Value = serde_json::from_slice(&o.stdout).unwrap();
    for key in
        ["closed_loop_cost", "open_loop_cost", "x_final", "steps", "status", "solve_ms", "constraint_violation_max"]
    {
        assert!(v.get(key).is_some(), "{key} is missing: {v}");
    }
    for (table, keys) in [("status", ["solved", "inaccurate", "fallback"]), ("solve_ms", ["median", "p99", "max"])] {
        assert!(keys.iter().all(|k| v[table].get(k).is_some()), "{v}");
    }
    assert_eq!(v["status"]["reasons"]["cost"], 10, "{v}");
    assert!(v["notes"][0].as_str().unwrap().contains("the stage cost is not finite at sample 0"), "{v}");
}

#[test]
fn a_loop_that_breaks_down_says_where_and_names_what_it_wrote() {
    let dir = scratch("control_breakdown");
    let problem = |plant: &str, x0: f64| {
        file(&dir, "model.toml", "states = ['x']\ninputs = ['u']\ndynamics = { x = 'x + u' }\n");
        file(&dir, "plant.toml", &format!("states = ['x']\ninputs = ['u']\ndynamics = {{ x = '{plant}' }}\n"));
        let text = format!(
            "model = 'model.toml'\nplant = 'plant.toml'\nhorizon = {{ steps = 10, dt = 0.1 }}\ncost = {{ stage = 'x^2 + u^2' }}\n\
             constraints = {{ u = {{ min = -1, max = 1 }} }}\nrun = {{ x0 = {{ x = {x0} }}, steps = 20 }}\n"
        );
        let out = dir.join("out");
        let _ = fs::remove_dir_all(&out);
        let o = bracketry(&["control", &file(&dir, "problem.toml", &text), "--out", out.to_str().unwrap()]);
        assert_eq!(code(&o), 1);
        let said = [o.stdout, o.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
        (said, out)
    };
    // The state grows beyond all numbers: the figure ends there.
    let (said, out) = problem("x^2 + u", 5.0);
    assert!(said.contains("is not finite") && said.contains("closed_loop.png"), "{said}");
    assert!(out.join("closed_loop.png").exists(), "{said}");
    // A plant with dry friction ends where its equation has no value.
    let (said, _) = problem("u/x - 0.1*sign(x)", 0.0);
    assert!(said.contains("in the equation of `x`"), "{said}");
}
