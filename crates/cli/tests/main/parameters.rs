//! `analyze --parameters`, `--map`, and `--identifiability` at the command line.

use crate::common::{bracketry, code, file, scratch, text};
use serde_json::Value;

const TANKS: &str = "states = ['x', 'y']\ninputs = ['u']\nparameters = { a = 1, b = 2 }\n\
    dynamics = { x = 'u - a*x', y = 'u - b*y' }\n";

#[test]
fn cases_are_printed_as_text_and_json() {
    let dir = scratch("parameter_cases");
    let model = file(&dir, "tanks.toml", TANKS);
    let o = bracketry(&["analyze", &model, "--parameters", "symbolic"]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    assert!(text(&o.stdout).contains("a - b = 0: 1 of 2   (confirmed at a = "), "{}", text(&o.stdout));
    assert!(text(&o.stdout).contains("these are all the cases (proven)"));
    let o = bracketry(&["analyze", &model, "--parameters", "a", "--json"]);
    let value: Value = serde_json::from_slice(&o.stdout).unwrap();
    let strong = value["aspects"].as_array().unwrap().iter().find(|a| a["aspect"] == "strong_accessibility").unwrap();
    assert_eq!(strong["cases"][0]["conditions"][0], "a - 2");
    assert_eq!((&strong["cases"][0]["value"]["dimension"], &value["fixed"]["b"]), (&Value::from(1), &Value::from("2")));
    assert_eq!((&strong["complete"], &value["complete"]), (&Value::from(true), &Value::from(true)));
}

#[test]
fn a_map_is_drawn() {
    let dir = scratch("parameter_map");
    let model = file(&dir, "tanks.toml", TANKS);
    let out = dir.join("out");
    let o = bracketry(&["analyze", &model, "--map", "a=-1..2,b=-1..2", "--cells", "6", "--out", out.to_str().unwrap()]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    let svg = std::fs::read_to_string(out.join("parameter_map.svg")).unwrap();
    assert!(svg.contains("a - b = 0") && svg.contains("stable"), "{svg}");
    assert!(out.join("parameter_map.json").exists() && out.join("parameter_map.txt").exists());
}

#[test]
fn bad_names_and_ranges_exit_with_2() {
    let dir = scratch("parameter_mistakes");
    let model = file(&dir, "tanks.toml", TANKS);
    for (arguments, expected) in [
        (vec!["--parameters", "c"], "no parameter `c`"),
        (vec!["--map", "a=0..1"], "such as a=0..2,b=-1..1"),
        (vec!["--parameters", "a", "--conditions", "0"], "at least 1"),
    ] {
        let o = bracketry(&[&["analyze", &model], &arguments[..]].concat());
        assert_eq!(code(&o), 2, "{arguments:?}");
        assert!(text(&o.stderr).contains(expected), "{}", text(&o.stderr));
    }
}

const CHAIN: &str = "states = ['a', 'b']\ninputs = ['u']\nparameters = { k1 = 1, k2 = 2, c = 3 }\n\
    dynamics = { a = '-k1*a + u', b = 'c*k1*a - k2*b' }\noutputs = { y = 'b' }\n";

#[test]
fn identifiability_is_printed_as_text_and_json() {
    let dir = scratch("identifiability");
    let model = file(&dir, "chain.toml", CHAIN);
    let o = bracketry(&["analyze", &model, "--identifiability"]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    assert!(text(&o.stdout).contains("not globally: 2 values"), "{}", text(&o.stdout));
    let o = bracketry(&[
        "analyze",
        &model,
        "--identifiability",
        "--unknown-input",
        "u",
        "--known-initial",
        "a,b",
        "--json",
    ]);
    let value: Value = serde_json::from_slice(&o.stdout).unwrap();
    assert_eq!(
        (&value["unknown_inputs"][0], &value["parameters"]["k2"]["local"]),
        (&Value::from("u"), &Value::from(false))
    );
    for (arguments, expected) in [
        (vec!["--identifiability", "--known-initial", "q"], "the model has no state `q`"),
        (vec!["--identifiability", "--unknown-input", "v"], "the model has no input `v`"),
        (vec!["--known-initial", "a"], "--identifiability"),
    ] {
        let o = bracketry(&[&["analyze", &model], &arguments[..]].concat());
        assert_eq!(code(&o), 2, "{arguments:?}");
        assert!(text(&o.stderr).contains(expected), "{}", text(&o.stderr));
    }
}
