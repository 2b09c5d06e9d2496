//! The control command on files as users write them.
#![allow(clippy::unwrap_used)]

mod common;

use std::fs;
use std::path::Path;

use common::{bracketry, code, file, json, scratch};
use serde_json::Value;

#[test]
fn the_ten_lines_of_the_guide_swing_a_pendulum_up() {
    let guide = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/mpc.md")).unwrap();
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
