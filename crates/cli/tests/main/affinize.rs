//! `affinize`: the list of ways to an affine form, and the choice among them.

use crate::common::{bracketry, code, file, json, model, scratch, stdout};
use bracketry::system::System;
use serde_json::Value;

const SQUARE: &str = "states = ['x']\ninputs = ['u']\n[dynamics]\nx = '-x + x*u^2'\n";

#[test]
fn every_way_is_listed_and_each_accepted_one_can_be_taken() {
    let path = file(&scratch("affinize_candidates"), "square.toml", SQUARE);
    let report = json(&["affinize", &path, "--json"]);
    let candidates = report["candidates"].as_array().unwrap();
    assert!(candidates.len() >= 2, "{report}");
    let text = stdout(&["affinize", &path]);
    for k in 1..=candidates.len() {
        assert!(text.contains(&format!("\n# {k}. ")), "{text}");
    }
    for (k, candidate) in candidates.iter().enumerate() {
        let number = (k + 1).to_string();
        let arguments = ["affinize", path.as_str(), "--candidate", &number];
        if candidate["accepted"] == true {
            let system = System::parse("affine.toml", &stdout(&arguments)).unwrap();
            assert_eq!(serde_json::to_value(system.state_names()).unwrap(), candidate["states"]);
            assert_eq!(system.affinize().unwrap().method, bracketry::system::Method::None);
            let v = json(&[&arguments[..], &["--json"]].concat());
            assert_eq!(v["candidate"]["method"], candidate["method"]);
            assert_eq!(v["model"]["inputs"], candidate["inputs"]);
        } else {
            let o = bracketry(&arguments);
            assert_eq!(code(&o), 2);
            assert!(String::from_utf8_lossy(&o.stderr).contains("was rejected: "));
        }
    }
}

/// The comments above the model are about that model: whichever candidate is printed is the one that is called selected.
#[test]
fn the_candidate_that_is_printed_is_called_selected() {
    let path = model("plate_published.toml");
    let candidates = json(&["affinize", &path, "--json"])["candidates"].as_array().unwrap().clone();
    for (k, candidate) in candidates.iter().enumerate().filter(|(_, c)| c["accepted"] == true) {
        let number = (k + 1).to_string();
        let text = stdout(&["affinize", &path, "--candidate", &number]);
        let comments: Vec<&str> = text.lines().take_while(|line| line.starts_with("# ")).collect();
        let selected: Vec<&&str> = comments.iter().filter(|line| line.contains(": selected")).collect();
        assert_eq!(selected.len(), 1, "{text}");
        assert!(selected[0].starts_with(&format!("# {number}. ")), "{text}");
        let added = System::parse("affine.toml", &text).unwrap().states.len();
        assert_eq!(Value::from(added), candidate["states"].as_array().unwrap().len());
        assert_eq!(comments[0].trim_start_matches("# "), candidate["why"].as_str().unwrap(), "{text}");
    }
}

#[test]
fn a_candidate_that_does_not_exist_is_refused() {
    for (k, part) in [("0", "numbered from 1"), ("99", "--candidate 99: there are"), ("x", "invalid")] {
        let o = bracketry(&["affinize", &model("plate_published.toml"), "--candidate", k]);
        let message = String::from_utf8_lossy(&o.stderr);
        assert_eq!(code(&o), 2);
        assert!(message.contains(part), "{message}");
    }
    let o = bracketry(&["affinize", &model("cart_pole.toml"), "--candidate", "2"]);
    assert!(String::from_utf8_lossy(&o.stderr).contains("there is 1 candidate"));
}

#[test]
fn a_new_input_is_told_with_its_range() {
    let path = file(&scratch("affinize_range"), "square.toml", SQUARE);
    assert!(stdout(&["affinize", &path]).contains("# new input v1 = u^2, limited to v1 ≥ 0\n"));
    assert!(stdout(&["analyze", &path]).contains("  new input v1 = u^2, limited to v1 ≥ 0\n"));
}

#[test]
fn without_an_affine_form_the_exit_code_is_1() {
    let inputs: Vec<String> = (1..=17).map(|k| format!("u{k}")).collect();
    let text = format!("states = ['x']\ninputs = {inputs:?}\n[dynamics]\nx = '{}'\n", inputs.join("*"));
    let model = file(&scratch("affinize_none"), "many.toml", &text);
    for command in ["affinize", "analyze"] {
        let o = bracketry(&[command, &model]);
        let message = String::from_utf8_lossy(&o.stderr);
        assert!(code(&o) == 1 && o.stdout.is_empty() && message.contains("17 inputs multiply each other"), "{message}");
    }
}
