//! The command line as other programs see it: exit codes, JSON, files.

use std::fs;
use std::process::Command;

use crate::common::{bracketry, code, file, json, model, scratch};
use serde_json::Value;

const SLIDER: &str = "states = ['x', 'v']\ninputs = ['a']\n[parameters]\nmu = 0.3\ng = 9.81\n\
                      [dynamics]\nx = 'v'\nv = 'a - mu*g*sign(v)'\n";

#[test]
fn analyze_gives_the_documented_object() {
    let v = json(&["analyze", &model("plate_published.toml"), "--json"]);
    assert_eq!((v["states"].as_u64(), v["inputs"].as_u64(), v["affine"].as_bool()), (Some(10), Some(2), Some(false)));
    assert_eq!(v["affinization"]["method"], "input_augmentation");
    assert_eq!(v["affinization"]["integrators"]["theta"], 2);
    assert_eq!(v["modes"].as_array().unwrap().len(), 4);
    assert_eq!(v["modes"][0]["accessible_dimension"], 9);
    assert_eq!(v["modes"][0]["autonomous"][0], "x + X");
    assert_eq!(v["switched"]["accessible_dimension"], 10);
    assert_eq!(v["smoothed"]["epsilon"], 0.01);
    assert_eq!(v["at_point"]["equilibrium"], true);
    assert_eq!(v["certificate"]["prime"], "2^61-1");
    assert!(v["seconds"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_affinized_model_is_a_model_file_that_needs_nothing_more() {
    let dir = scratch("affinize");
    let o = bracketry(&["affinize", &model("plate_published.toml")]);
    assert_eq!(code(&o), 0);
    let path = file(&dir, "affine.toml", &String::from_utf8(o.stdout).unwrap());
    let v = json(&["analyze", &path, "--json"]);
    assert_eq!((v["affine"].as_bool(), v["affinization"]["method"].as_str()), (Some(true), Some("none")));
    assert_eq!(v["switched"]["accessible_dimension"], 10);
}

#[test]
fn simulate_writes_trajectory_events_and_plots() {
    let dir = scratch("simulate");
    let slider = file(&dir, "slider.toml", SLIDER);
    let scenario = file(&dir, "s.toml", "duration = 1.0\nsample = 0.1\n[x0]\nv = 1.0\n");
    let out = dir.join("out");
    let v = json(&["simulate", &slider, "--scenario", &scenario, "--json", "--out", out.to_str().unwrap()]);
    let stop = 1.0 / (0.3 * 9.81);
    assert!((v["events"][0]["t"].as_f64().unwrap() - stop).abs() < 1e-9);
    assert_eq!(v["events"][0]["to"], "stick");
    assert!((v["x_final"]["x"].as_f64().unwrap() - 0.5 * stop).abs() < 1e-9);
    let table = fs::read_to_string(out.join("trajectory.csv")).unwrap();
    assert_eq!((table.lines().next(), table.lines().count()), (Some("t,x,v,a"), 12));
    for name in ["events.csv", "trajectory.svg", "trajectory.png"] {
        assert!(fs::metadata(out.join(name)).unwrap().len() > 0, "{name}");
    }
}

#[test]
fn sampled_inputs_hold_until_the_next_sample() {
    let dir = scratch("samples");
    let slider = file(&dir, "slider.toml", SLIDER);
    // 5 m/s² for half a second, then nothing; `note` is no input.
    let table = file(&dir, "u.csv", "t,a,note\n0,5,1\n0.5,0,2\n3,0,3\n");
    let v = json(&["simulate", &slider, "--inputs", &table, "--json"]);
    let (up, down) = (5.0 - 2.943, 2.943);
    let peak = 0.5 * up;
    let way = 0.5 * up * 0.25 + 0.5 * peak * peak / down;
    assert!((v["x_final"]["x"].as_f64().unwrap() - way).abs() < 1e-9, "{v}");
    assert_eq!(v["ignored_columns"][0], "note");
}

#[test]
fn the_cart_pole_problem_costs_what_is_published() {
    let v = json(&["control", &model("cart_pole_swing_up.toml"), "--json"]);
    let cost = v["closed_loop_cost"].as_f64().unwrap();
    assert!((cost / 2047.463 - 1.0).abs() < 1e-3, "{cost}");
    assert_eq!(v["status"]["solved"], 100);
    assert!(v["solve_ms"]["median"].as_f64().unwrap() > 0.0);
}

#[test]
fn bad_input_ends_with_code_2_and_names_the_place() {
    let dir = scratch("bad");
    let slider = file(&dir, "slider.toml", SLIDER);
    let typo = file(&dir, "typo.toml", &SLIDER.replace("sign(v)", "sign(w)"));
    let nan_row = file(&dir, "nan.csv", "t,a\n0,1\n1,nan\n");
    let unordered = file(&dir, "unordered.csv", "t,a\n0,1\n1,1\n0.5,2\n");
    let no_time = file(&dir, "no_time.csv", "a\n1\n");
    let ragged = file(&dir, "ragged.csv", "t,a\n0,1\n1\n");
    let scenario = file(&dir, "s.toml", "duration = 1.0\n[inputs]\na = \"sin(t\"\n");
    let negative = file(&dir, "n.toml", "duration = -1.0\n");
    let problem = file(&dir, "p.toml", "model = \"slider.toml\"\n[horizon]\nsteps = 10\n");
    let cases: [(&[&str], &str); 11] = [
        (&["analyze", &typo], "typo.toml:8:"),
        (&["analyze", "missing.toml"], "missing.toml"),
        (&["affinize", &typo], "unknown name `w`"),
        (&["simulate", &slider, "--inputs", &nan_row], "line 3"),
        (&["simulate", &slider, "--inputs", &unordered], "line 4"),
        (&["simulate", &slider, "--inputs", &no_time], "column `t`"),
        (&["simulate", &slider, "--inputs", &ragged], "line 3 has 1 entry"),
        (&["simulate", &slider, "--scenario", &scenario], "s.toml:3:"),
        (&["simulate", &slider, "--scenario", &negative], "must be positive"),
        (&["control", &problem], "p.toml"),
        (&["simulate", &slider], "--scenario"),
    ];
    for (arguments, part) in cases {
        let o = bracketry(arguments);
        let message = String::from_utf8_lossy(&o.stderr);
        assert_eq!(code(&o), 2, "{arguments:?}: {message}");
        assert!(message.contains(part), "`{part}` in: {message}");
    }
}

#[test]
fn a_solution_that_blows_up_ends_with_code_1_and_its_time() {
    let dir = scratch("blow_up");
    let path = file(&dir, "m.toml", "states = ['x']\n[dynamics]\nx = 'x^2'\n");
    let scenario = file(&dir, "s.toml", "duration = 2.0\n[x0]\nx = 1.0\n");
    let o = bracketry(&["simulate", &path, "--scenario", &scenario]);
    assert_eq!(code(&o), 1);
    let said = String::from_utf8_lossy(&o.stdout);
    assert!(said.contains("stopped at t = 1 s: `x` diverges there"), "{said}");
}

#[test]
fn a_problem_that_cannot_be_solved_ends_with_code_1_and_a_status() {
    let dir = scratch("infeasible");
    file(&dir, "cart.toml", "states = ['p', 'v']\ninputs = ['u']\n[dynamics]\np = 'v'\nv = 'u'\n");
    file(&dir, "root.toml", "states = ['p', 'v']\ninputs = ['u']\n[dynamics]\np = 'v'\nv = 'u + sqrt(v - 1)'\n");
    let problem = |model: &str, constraint: &str| {
        format!(
            "model = '{model}'\n[horizon]\nsteps = 20\ndt = 0.05\n[cost]\nstage = 'p^2 + 0.1*u^2'\n\
             [constraints]\nu = {{ min = -1, max = 1 }}\n{constraint}\n[run]\nx0 = {{ p = 0 }}\nsteps = 10\n"
        )
    };
    // From p = 0 a hard 2 ≤ p cannot be kept; the root of a negative number is not a number.
    for (name, text, status) in [
        ("bound.toml", problem("cart.toml", "p = { min = 2, hard = true }"), "infeasible"),
        ("nan.toml", problem("root.toml", ""), "fallback"),
    ] {
        let path = file(&dir, name, &text);
        let o = bracketry(&["control", &path, "--json"]);
        assert_eq!(code(&o), 1, "{name}: {}", String::from_utf8_lossy(&o.stderr));
        let v: Value = serde_json::from_slice(&o.stdout).unwrap();
        assert_eq!(v["status"][status], 10, "{name}: {v}");
    }
}

#[test]
fn a_missed_target_or_a_plant_that_ends_is_code_1() {
    let dir = scratch("missed");
    file(&dir, "cart.toml", "states = ['p', 'v']\ninputs = ['u']\n[dynamics]\np = 'v'\nv = 'u'\n");
    file(&dir, "cubic.toml", "states = ['x']\ninputs = ['u']\n[dynamics]\nx = 'x^3 + u - 0.1*sign(x)'\n");
    let far = "model = 'cart.toml'\n[horizon]\nsteps = 10\ndt = 0.1\n[cost]\nstage = '0.1*u^2'\n[constraints]\n\
               u = { min = -1, max = 1 }\n[target]\np = { value = VALUE, tolerance = 0.05 }\n[solve]\nmethod = 'plan'\n\
               [run]\nsteps = 10\n";
    let near = json(&["control", &file(&dir, "near.toml", &far.replace("VALUE", "0.2")), "--json"]);
    assert_eq!(near["succeeded"], true, "{near}");
    assert_eq!(code(&bracketry(&["control", &file(&dir, "far.toml", &far.replace("VALUE", "9"))])), 1);
    let blow_up = "model = 'cubic.toml'\n[horizon]\nsteps = 10\ndt = 0.1\n[cost]\nstage = 'x^2 + u^2'\n[constraints]\n\
                   u = { min = -1, max = 1 }\n[run]\nx0 = { x = 3 }\nsteps = 10\n";
    let o = bracketry(&["control", &file(&dir, "blow_up.toml", blow_up)]);
    assert_eq!(code(&o), 1);
    assert!(String::from_utf8_lossy(&o.stderr).contains("the plant stopped"));
}

#[test]
fn every_file_that_help_and_readme_name_exists() {
    let mut texts = vec![fs::read_to_string(crate::common::root().join("README.md")).unwrap()];
    for command in ["analyze", "affinize", "simulate", "control", "diagnose", "plate"] {
        texts.push(String::from_utf8(bracketry(&[command, "--help"]).stdout).unwrap());
    }
    let mut named = 0;
    for text in texts {
        for word in text.split(|c: char| c.is_whitespace() || "`()[]".contains(c)) {
            if word.starts_with("models/") || word.starts_with("docs/") {
                assert!(crate::common::root().join(word).exists(), "{word}");
                named += 1;
            }
        }
    }
    assert!(named >= 4);
}

#[test]
fn a_reader_that_goes_away_or_a_full_disk_is_no_panic() {
    use std::process::Stdio;
    let full = fs::OpenOptions::new().write(true).open("/dev/full");
    if let Ok(full) = full {
        let o = Command::new(env!("CARGO_BIN_EXE_bracketry"))
            .args(["affinize", &model("plate_published.toml")])
            .stdout(full)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        assert_eq!(code(&o), 2, "{}", String::from_utf8_lossy(&o.stderr));
    }
    let mut child = Command::new(env!("CARGO_BIN_EXE_bracketry"))
        .args(["analyze", &model("plate_published.toml"), "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let o = child.wait_with_output().unwrap();
    assert_eq!(code(&o), 0, "{}", String::from_utf8_lossy(&o.stderr));
}

#[test]
fn the_same_input_gives_the_same_output() {
    let run = || {
        let mut v = json(&["analyze", &model("plate_published.toml"), "--json"]);
        v["seconds"] = Value::Null;
        v
    };
    assert_eq!(run(), run());
}
