//! What `simulate` reads, refuses, says and writes.

use std::fs;

use crate::common::{bracketry, code, file, json, model, scratch, text};

const SLIDER: &str = "states = ['x', 'v']\ninputs = ['a']\n[parameters]\nmu = 0.3\ng = 9.81\n\
                      [dynamics]\nx = 'v'\nv = 'a - mu*g*sign(v)'\n";

const SHAKEN: &str = "states = ['x', 'v']\ninputs = ['X', 'F']\n[dynamics]\nx = 'v'\n\
                      v = '-der(X,2) - 2.943*sign(v) + 0.1*der(X) + F'\n";

#[test]
fn columns_of_derivatives_alone_drive_the_model() {
    let dir = scratch("derivatives");
    let shaken = file(&dir, "shaken.toml", SHAKEN);
    // v' = 5 − 2.943 for a second, then −2.943; commas within parentheses separate nothing, quoted or not.
    let rows = "0,-5,0,9\n1,0,0,9\n4,0,0,9\n";
    let (up, down) = (5.0 - 2.943, 2.943);
    let way = 0.5 * up + 0.5 * up * up / down;
    for header in [
        "t,der(X,2),der(X,1),der(X,3)",
        "t,\"der(X,2)\", \"der(X,1)\",\"der(X,3)\"",
        "\u{feff}t, der(X, 2),der(X),der(X,3)",
    ] {
        let table = file(&dir, "u.csv", &format!("{header}\n{rows}"));
        let out = dir.join("out");
        let v = json(&["simulate", &shaken, "--inputs", &table, "--json", "--out", out.to_str().unwrap()]);
        assert!((v["x_final"]["x"].as_f64().unwrap() - way).abs() < 1e-9, "{header}: {v}");
        assert_eq!(v["ignored_columns"].as_array().unwrap().len(), 1);
        assert_eq!(v["ignored_columns"][0], "der(X,3)");
        assert_eq!(v["inputs_at_zero"], serde_json::json!(["F"]));
        // X itself is not known.
        assert_eq!(fs::read_to_string(out.join("trajectory.csv")).unwrap().lines().next(), Some("t,x,v,F"));
    }
    let table = file(&dir, "u.csv", "t,der(X,2)\n0,-5\n1,0\n");
    let o = bracketry(&["simulate", &shaken, "--inputs", &table]);
    assert_eq!(code(&o), 2);
    assert!(String::from_utf8_lossy(&o.stderr).contains("add a column der(X,1)"));
    let table = file(&dir, "u.csv", "t,der(X,1),\"der(X, 1)\"\n0,-5,1\n1,0,1\n");
    assert!(
        String::from_utf8_lossy(&bracketry(&["simulate", &shaken, "--inputs", &table]).stderr).contains("two columns")
    );
}

#[test]
fn a_table_may_be_longer_than_a_model_file() {
    let dir = scratch("large");
    let slider = file(&dir, "slider.toml", SLIDER);
    let table = file(&dir, "u.csv", &format!("#{}\nt,a\n0,5\n1,0\n", " ".repeat(17 << 20)));
    assert_eq!(json(&["simulate", &slider, "--inputs", &table, "--json"])["t_final"], 1.0);
    fs::OpenOptions::new().write(true).open(&table).unwrap().set_len(513 << 20).unwrap();
    let o = bracketry(&["simulate", &slider, "--inputs", &table]);
    let message = String::from_utf8_lossy(&o.stderr);
    assert!(code(&o) == 2 && message.contains("512 MiB") && message.contains("fewer samples"), "{message}");
    fs::remove_file(&table).unwrap();
}

#[test]
fn what_a_simulation_leaves_out_is_said() {
    let dir = scratch("left_out");
    let shaken = file(&dir, "shaken.toml", SHAKEN);
    let scenario = file(&dir, "s.toml", "duration = 1.0\n[inputs]\nX = '0.1*sign(sin(3*t - 1))'\n");
    let v = json(&["simulate", &shaken, "--scenario", &scenario, "--json"]);
    assert_eq!(v["impulses_left_out"], serde_json::json!(["der(X,1)", "der(X,2)"]));
    let text = String::from_utf8(bracketry(&["simulate", &shaken, "--scenario", &scenario]).stdout).unwrap();
    assert!(text.contains("impulses of der(X,2) are neglected"), "{text}");
    assert!(text.contains("the input `F` is not driven"), "{text}");
}

#[test]
fn outputs_of_the_model_are_columns() {
    let dir = scratch("outputs");
    let model = file(&dir, "m.toml", &format!("{SLIDER}[outputs]\nx = 'x'\nv = '2*v'\nenergy = 'v^2/2'\n"));
    let scenario = file(&dir, "s.toml", "duration = 1.0\nsample = 0.5\n[x0]\nv = 2.943\n");
    let out = dir.join("out");
    json(&["simulate", &model, "--scenario", &scenario, "--json", "--out", out.to_str().unwrap()]);
    let table = fs::read_to_string(out.join("trajectory.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("t,x,v,a,output v,energy"));
    let middle: Vec<f64> = lines.nth(1).unwrap().split(',').map(|f| f.parse().unwrap()).collect();
    let v = 2.943 / 2.0;
    assert!((middle[4] - 2.0 * v).abs() < 1e-9 && (middle[5] - v * v / 2.0).abs() < 1e-9, "{middle:?}");
    assert!(fs::read_to_string(out.join("trajectory.svg")).unwrap().contains("energy"));
}

#[test]
fn an_input_beyond_its_range_is_said() {
    let dir = scratch("ranges");
    let model = file(&dir, "m.toml", &format!("{SLIDER}[ranges]\na = {{ min = 0, max = 2 }}\n"));
    let said = |a: &str| {
        let scenario = file(&dir, "s.toml", &format!("duration = 1.0\nsample = 0.01\n[inputs]\na = '{a}'\n"));
        text(&bracketry(&["simulate", &model, "--scenario", &scenario]).stdout)
    };
    let rope = said("3*t - 1");
    assert!(rope.contains("`a` goes to -1, below the 0 of its range"), "{rope}");
    assert!(!rope.contains("above"), "{rope}");
    assert!(said("3*t").contains("`a` goes to 3, above the 2 of its range"));
    assert!(!said("2*t").contains("warning"));
}

#[test]
fn an_output_that_is_a_state_shares_its_panel() {
    let dir = scratch("shared_panels");
    let scenario = file(&dir, "s.toml", "duration = 1.0\n[x0]\nv = 2.943\n");
    // Both labels end in the output's name; only the one that is no state has it to itself.
    for (output, label) in [("'x'", "x = camera"), ("'2*x'", "camera")] {
        let model = file(&dir, "m.toml", &format!("{SLIDER}[outputs]\ncamera = {output}\n"));
        let out = dir.join("out");
        json(&["simulate", &model, "--scenario", &scenario, "--json", "--out", out.to_str().unwrap()]);
        let figure = fs::read_to_string(out.join("trajectory.svg")).unwrap();
        let labels: Vec<&str> = figure.lines().map(str::trim).filter(|l| l.ends_with("camera")).collect();
        assert_eq!(labels, [label], "{output}");
    }
}

#[test]
fn the_scenario_of_the_second_experiment_moves_the_object_to_its_target() {
    let v =
        json(&["simulate", &model("plate_published.toml"), "--scenario", &model("plate_experiment_2.toml"), "--json"]);
    assert_eq!((v["finished"].as_bool(), v["t_final"].as_f64()), (Some(true), Some(4.0)));
    let x = v["x_final"]["x"].as_f64().unwrap();
    assert!(x > 0.54 && x < 0.56, "{v}");
    assert_eq!(v["x_final"]["y"], -0.03);
}

#[test]
fn numbers_and_counts_are_readable() {
    let dir = scratch("readable");
    let slider = file(&dir, "slider.toml", SLIDER);
    let still = file(&dir, "m.toml", "states = ['x']\n[dynamics]\nx = '0'\n");
    let long = file(&dir, "long.toml", "duration = 1e300\n");
    let once = file(&dir, "once.toml", "duration = 1.0\n[x0]\nv = 1.0\n");
    let said = |model: &str, scenario: &str| {
        String::from_utf8(bracketry(&["simulate", model, "--scenario", scenario]).stdout).unwrap()
    };
    assert!(said(&still, &long).contains(" 1e300 s simulated"), "{}", said(&still, &long));
    assert!(said(&slider, &once).contains(", 1 mode change\n"), "{}", said(&slider, &once));
}

#[test]
fn an_input_that_is_no_number_is_named() {
    let dir = scratch("rate");
    let slider = file(&dir, "slider.toml", SLIDER);
    let scenario = file(&dir, "s.toml", "duration = 1.0\n[inputs]\na = 'log(t - 3)'\n");
    let o = bracketry(&["simulate", &slider, "--scenario", &scenario]);
    let text = String::from_utf8_lossy(&o.stdout);
    assert_eq!(code(&o), 1);
    assert!(text.contains("stopped at t = 0 s: the input `a` has no finite value"), "{text}");
}

#[test]
fn bad_scenarios_and_tables_are_refused_with_place_and_remedy() {
    let dir = scratch("bad_scenarios");
    let slider = file(&dir, "slider.toml", SLIDER);
    let rough = file(&dir, "rough.toml", "duration = 1.0\n[parameters]\nmu = 5\n");
    let letter = file(&dir, "letter.toml", "duration = 1.0\n[inputs]\nX = 'x'\n");
    let unordered = file(&dir, "unordered.csv", "# made by hand\n\nt,a\n0,1\n1,1\n0.5,2\n");
    let plate = model("plate_published.toml");
    let clock = file(&dir, "clock.toml", "states = ['t']\ninputs = ['u']\n[dynamics]\nt = 'u'\n");
    let short = file(&dir, "short.toml", "duration = 1.0\n");
    let cases: [(&[&str], &str); 5] = [
        (&["simulate", &clock, "--scenario", &short], "calls a state `t`, which is time here"),
        (&["simulate", &plate, "--scenario", &rough], "rough.toml:3:6: parameter `mu` lies outside"),
        (&["simulate", &plate, "--scenario", &letter], "unknown name `x`"),
        (
            &["simulate", &slider, "--inputs", dir.to_str().unwrap()],
            "is a directory\n   = name a table of samples in it: unordered.csv",
        ),
        (&["simulate", &slider, "--inputs", &unordered], "line 6"),
    ];
    for (arguments, part) in cases {
        let o = bracketry(arguments);
        let message = String::from_utf8_lossy(&o.stderr);
        assert_eq!(code(&o), 2, "{arguments:?}: {message}");
        assert!(message.contains(part), "`{part}` in: {message}");
        assert!(!message.contains("did you mean `g`"), "{message}");
    }
}
