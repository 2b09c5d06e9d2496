//! `steer` at the command line: report, files that `simulate` replays, exit codes.

use crate::common::{bracketry, code, file, json, scratch, text};

const UNICYCLE: &str = "name = 'unicycle'\nstates = ['x', 'y', 'th']\ninputs = ['s', 'w']\n\
     [dynamics]\nx = 's*cos(th)'\ny = 's*sin(th)'\nth = 'w'\n";

#[test]
fn the_written_scenario_replays_the_motion() {
    let dir = scratch("steer");
    let model = file(&dir, "unicycle.toml", UNICYCLE);
    let out = dir.join("out");
    let o =
        bracketry(&["steer", &model, "--from", "x=1,y=0", "--to", "x=1,y=1,th=pi/2", "--out", out.to_str().unwrap()]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    assert!(text(&o.stdout).contains("reached: the simulated motion ends within"), "{}", text(&o.stdout));
    for name in ["steering.txt", "steering.json", "inputs.csv", "trajectory.csv", "steering.png", "path.svg"] {
        assert!(out.join(name).exists(), "{name}");
    }
    let again = json(&["simulate", &model, "--scenario", out.join("scenario.toml").to_str().unwrap(), "--json"]);
    let end = &again["x_final"];
    for (name, value) in [("x", 1.0), ("y", 1.0), ("th", std::f64::consts::FRAC_PI_2)] {
        assert!((end[name].as_f64().unwrap() - value).abs() < 1e-6, "{again}");
    }
}

#[test]
fn the_exit_code_tells_a_motion_from_none_and_from_bad_input() {
    let dir = scratch("steer_codes");
    let stuck = file(&dir, "stuck.toml", "states = ['x', 'y']\ninputs = ['u']\n[dynamics]\nx = 'u'\ny = '0'\n");
    let o = bracketry(&["steer", &stuck, "--to", "y=1", "--json"]);
    assert_eq!(code(&o), 1);
    let v: serde_json::Value = serde_json::from_slice(&o.stdout).unwrap();
    assert_ne!(v["status"], "reached");
    assert_eq!(v["attempts"].as_array().unwrap().len(), 4, "{v}");
    let model = file(&dir, "unicycle.toml", UNICYCLE);
    for (arguments, says) in [
        (&["steer", &model, "--to", "q=1"][..], "neither a state nor an input"),
        (&["steer", &model, "--to", "x=1/0"], "the final state x=1/0"),
        (&["steer", &model, "--to", "x=1", "--duration", "-1"], "give a positive number"),
        (&["steer", &model, "--to", "x=1", "--time-limit", "0"], "--time-limit"),
        (&["steer", &model], "--to"),
    ] {
        let o = bracketry(arguments);
        assert!(code(&o) == 2 && text(&o.stderr).contains(says), "{arguments:?}: {}", text(&o.stderr));
    }
}
