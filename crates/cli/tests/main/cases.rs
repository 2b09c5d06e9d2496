//! Systems with answers known from the literature, read from the shared folder: through the library and through the
//! command.
#![allow(clippy::print_stderr)]

use std::fs;

use crate::common::{
    ROOT, bracketry,
    case_file::{BadCase, generic_value, model_file},
    code,
    known_answers::{cases, differences},
    scratch,
};
use bracketry::lie::AnalysisOptions;
use bracketry::system::System;
use serde_json::{Value, json};

fn expect_no_differences(analyze: &mut crate::common::known_answers::Analyze<'_>) {
    let differences: Vec<String> = cases(ROOT).iter().flat_map(|case| differences(case, analyze)).collect();
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}

#[test]
fn the_library_gives_the_answers_of_the_literature() {
    expect_no_differences(&mut |model, brackets, determined| {
        let system = System::parse("case.toml", model).unwrap();
        let options = AnalysisOptions {
            brackets: brackets.to_vec(),
            determined: determined.to_vec(),
            ..AnalysisOptions::default()
        };
        serde_json::to_value(bracketry::report::analysis::json(&bracketry::analyze(&system, &options).unwrap()))
            .unwrap()
    });
}

#[test]
fn the_command_gives_the_answers_of_the_literature() {
    let path = scratch("cases").join("case.toml");
    expect_no_differences(&mut |model, brackets, determined| {
        fs::write(&path, model).unwrap();
        let mut arguments = vec!["analyze", path.to_str().unwrap(), "--json"];
        for b in brackets {
            arguments.extend(["--bracket", b]);
        }
        for e in determined {
            arguments.extend(["--determines", e]);
        }
        let o = bracketry(&arguments);
        assert_eq!(code(&o), 0, "{}\n{model}", String::from_utf8_lossy(&o.stderr));
        serde_json::from_slice(&o.stdout).unwrap()
    });
}

/// x' = -k x + b u, as a case.
fn small_case() -> Value {
    json!({"name": "decay", "states": ["x"], "inputs": ["u"], "params": ["k", "h1"], "f": ["-k*x"], "g": [["h1"]],
           "h": ["x**2"], "x0": {"x": "0"}, "expected": {"accessibility_rank": 1, "growth": [1]}})
}

#[test]
fn a_case_becomes_a_model_file_that_says_the_same() {
    let case = small_case();
    let text = model_file(&case, &case["x0"], &[("k".into(), "2.5".into())]).unwrap();
    let mut system = System::parse("decay.toml", &text).unwrap();
    let expected = system.pool.parse("-k*x + h1*u").unwrap();
    assert_eq!(system.dynamics, [expected]);
    // The output gets a name that the parameter h1 leaves free.
    assert_eq!(system.outputs[0].0, "h1_");
    let values: Vec<f64> = system.parameters.iter().map(|p| p.value.to_f64().value()).collect();
    assert_eq!(values, [2.5, generic_value(1).parse().unwrap()]);
    assert!(system.point.is_some());
    assert!(System::parse("m", &model_file(&case, &Value::Null, &[]).unwrap()).unwrap().point.is_none());
}

#[test]
fn made_up_values_are_distinct() {
    let mut values: Vec<String> = (0..60).map(generic_value).collect();
    values.sort();
    values.dedup();
    assert_eq!(values.len(), 60);
}

#[test]
fn lists_that_do_not_fit_are_refused() {
    let broken = |key: &str, value: Value| {
        let mut case = small_case();
        case[key] = value;
        model_file(&case, &Value::Null, &[]).unwrap_err()
    };
    assert_eq!(broken("f", json!(["0", "0"])), BadCase("an input field with 1 components for 2 states".into()));
    assert_eq!(broken("g", json!([["1"], ["1"]])), BadCase("2 input fields for 1 inputs".into()));
    assert_eq!(broken("states", json!("x")), BadCase("`states` must be a list of texts".into()));
}

#[test]
fn a_wrong_answer_and_an_unknown_key_are_seen() {
    let mut analyze = |model: &str, _: &[String], _: &[String]| {
        let system = System::parse("case.toml", model).unwrap();
        serde_json::to_value(bracketry::report::analysis::json(
            &bracketry::analyze(&system, &AnalysisOptions::default()).unwrap(),
        ))
        .unwrap()
    };
    assert_eq!(differences(&small_case(), &mut analyze), [""; 0]);
    let mut wrong = small_case();
    wrong["expected"] = json!({"accessibility_rank": 2, "brand_new": 1});
    let found = differences(&wrong, &mut analyze);
    assert_eq!(found.len(), 2);
    assert!(found[0].contains("accessibility_rank: 1 instead of 2"), "{}", found[0]);
    assert!(found[1].contains("brand_new"), "{}", found[1]);
}
