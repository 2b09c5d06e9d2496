//! Systems with answers known from the literature, read from the shared folder.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod common;

use std::collections::BTreeMap;

use bracketry_lie::{Answer, Evidence, Field, Limits, Options, VectorFields, Verdict, analyse, bracket};
use bracketry_symbolic::{Bindings, Expr, Pool, ZeroTest};
use bracketry_system::System;
use common::{fields, ratio, system};
use serde_json::Value;

/// The cases, or none if the folder is absent.
fn cases() -> Vec<Value> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let shared = std::env::var("BRACKETRY_SHARED").unwrap_or_else(|_| "../shared".into());
    let path = std::path::Path::new(root).join(shared).join("cases/systems.json");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("ignored: {} is absent", path.display());
        return Vec::new();
    };
    let all: Value = serde_json::from_str(&text).unwrap();
    all["cases"].as_array().unwrap().clone()
}

fn strings(v: &Value) -> Vec<String> {
    v.as_array().map(|l| l.iter().map(|s| s.as_str().unwrap().to_owned()).collect()).unwrap_or_default()
}

fn numbers(v: &Value) -> Vec<usize> {
    v.as_array().unwrap().iter().map(|k| usize::try_from(k.as_u64().unwrap()).unwrap()).collect()
}

fn borrowed(v: &[String]) -> Vec<&str> {
    v.iter().map(String::as_str).collect()
}

fn point(v: &Value) -> Vec<(String, String)> {
    v.as_object().unwrap().iter().map(|(k, s)| (k.clone(), s.as_str().unwrap().to_owned())).collect()
}

/// x' = f + Σ g u with generic-looking values for the parameters.
fn model(case: &Value, at: Option<&Value>) -> System {
    let states = strings(&case["states"]);
    let inputs = strings(&case["inputs"]);
    let g: Vec<Vec<String>> = case["g"].as_array().unwrap().iter().map(strings).collect();
    let dynamics: Vec<String> = strings(&case["f"])
        .iter()
        .enumerate()
        .map(|(i, f)| {
            let with_inputs = g.iter().zip(&inputs).map(|(g, u)| format!(" + ({})*{u}", g[i]));
            format!("{f}{}", with_inputs.collect::<String>())
        })
        .collect();
    let names = strings(&case["params"]);
    let parameters: Vec<_> =
        names.iter().enumerate().map(|(i, n)| (n.as_str(), ratio(13 + 10 * i as i64, 7 + 4 * i as i64))).collect();
    let outputs = strings(&case["h"]);
    let at = at.filter(|p| p.is_object()).map(point);
    let at: Option<Vec<(&str, &str)>> = at.as_ref().map(|l| l.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect());
    system(
        &borrowed(&states),
        &borrowed(&inputs),
        &parameters,
        &borrowed(&dynamics),
        &borrowed(&outputs),
        at.as_deref(),
    )
}

/// A bracket such as "[g1,[f,g1]]".
fn read_bracket(pool: &mut Pool, v: &VectorFields, text: &str) -> Field {
    match text.strip_prefix('[').and_then(|t| t.strip_suffix(']')) {
        Some(inner) => {
            let mut depth = 0;
            let comma = inner.find(|c| {
                depth += i32::from(c == '[') - i32::from(c == ']');
                c == ',' && depth == 0
            });
            let (a, b) = inner.split_at(comma.unwrap());
            let (a, b) = (read_bracket(pool, v, a), read_bracket(pool, v, &b[1..]));
            bracket(pool, &v.states, &a, &b)
        }
        None if text == "f" => v.drift.clone(),
        None => v.controls[text[1..].parse::<usize>().unwrap() - 1].clone(),
    }
}

fn equal(pool: &mut Pool, a: Expr, b: Expr) -> bool {
    let d = pool.sub(a, b);
    matches!(pool.zero_test(d, &Bindings::new()), ZeroTest::Zero(_))
}

#[test]
fn every_answer_of_the_literature_is_found() {
    for case in cases().iter().filter(|c| c["kind"] == "control_affine") {
        let name = case["name"].as_str().unwrap();
        let expected = case["expected"].as_object().unwrap();
        let report = analyse(&model(case, Some(&case["x0"])), &Options::default()).unwrap();
        let mode = &report.modes[0];
        let at = report.at_point.as_ref().and_then(Answer::known);
        let dimension = |k: &Value| Answer::Known(usize::try_from(k.as_u64().unwrap()).unwrap());
        for (key, value) in expected {
            match key.as_str() {
                "growth" => assert_eq!(mode.dimensions.growth, numbers(value), "{name}: growth"),
                "accessibility_rank" => {
                    assert_eq!(mode.dimensions.accessible_dimension, dimension(value), "{name}: accessible");
                }
                "strong_accessibility_rank" => {
                    let found = &mode.dimensions.strongly_accessible_dimension;
                    assert_eq!(*found, dimension(value), "{name}: strongly accessible");
                }
                "accessibility_rank_at_x0" => {
                    assert_eq!(at.unwrap().dimensions.accessible_dimension, dimension(value), "{name}: at x0");
                }
                "strong_accessibility_rank_at_x0" => {
                    let found = &at.unwrap().dimensions.strongly_accessible_dimension;
                    assert_eq!(*found, dimension(value), "{name}: strong at x0");
                }
                "static_feedback_linearizable" => {
                    let expected = Answer::Known(value.as_bool().unwrap());
                    assert_eq!(report.static_feedback_linearizable, expected, "{name}: linearizable");
                }
                "involutive" => {
                    assert_eq!(report.involutive, Answer::Known(value.as_bool().unwrap()), "{name}: involutive");
                }
                "linearization_controllable" => {
                    let full = at.unwrap().linear_controllability_rank == Some(mode_states(case));
                    assert_eq!(full, value.as_bool().unwrap(), "{name}: linearisation");
                }
                "observability_rank" => {
                    let found = &report.observability.as_ref().unwrap().rank;
                    assert_eq!(*found, dimension(value), "{name}: observability");
                }
                "stlc" => {
                    let stlc = &at.unwrap().stlc;
                    let found = serde_json::to_value(stlc.verdict).unwrap();
                    // Small-time controllable by a result that no condition used here covers.
                    if name == "kawski_4_1_increasing_switchings" {
                        assert_eq!(stlc.verdict, Verdict::Inconclusive, "{name}");
                    } else {
                        assert_eq!(found, *value, "{name}: {}", stlc.reason);
                    }
                }
                "gsc_weights" => {
                    let weights = serde_json::to_value(at.unwrap().stlc.weights).unwrap();
                    assert_eq!(weights, *value, "{name}: weights");
                }
                _ => {}
            }
        }
    }
}

fn mode_states(case: &Value) -> usize {
    case["states"].as_array().unwrap().len()
}

#[test]
fn brackets_have_the_agreed_sign() {
    for case in cases().iter().filter(|c| c["expected"]["bracket"].is_object()) {
        let mut s = model(case, None);
        let v = fields(&mut s);
        for (word, components) in case["expected"]["bracket"].as_object().unwrap() {
            let found = read_bracket(&mut s.pool, &v, word);
            for (e, text) in found.into_iter().zip(strings(components)) {
                let wanted = s.pool.parse(&text).unwrap();
                assert!(equal(&mut s.pool, e, wanted), "{}: {word}: {} is not {text}", case["name"], s.pool.text(e));
            }
        }
    }
}

#[test]
fn growth_at_singular_points_stands_still_and_goes_on() {
    for case in cases().iter().filter(|c| c["expected"]["growth_singular"].is_array()) {
        let at = &case["expected"]["singular_point"];
        let mut s = model(case, Some(at));
        let v = fields(&mut s);
        let p = s.point.clone().unwrap();
        let found =
            v.at_point(&mut s.pool, &p.states, &p.inputs, &Limits::default(), &mut Evidence::default()).unwrap();
        assert_eq!(found.growth, numbers(&case["expected"]["growth_singular"]), "{}", case["name"]);
    }
}

#[test]
fn what_the_outputs_determine() {
    for case in cases().iter().filter(|c| c["kind"] == "identifiability") {
        let name = case["name"].as_str().unwrap();
        let states = strings(&case["states"]);
        let inputs = strings(&case["inputs"]);
        let dynamics = strings(&case["f"]);
        let mut s = system(
            &borrowed(&states),
            &borrowed(&inputs),
            &[],
            &borrowed(&dynamics),
            &borrowed(&strings(&case["h"])),
            None,
        );
        let v = fields(&mut s);
        let outputs: Vec<Expr> = s.outputs.iter().map(|o| o.1).collect();
        let parameters: Vec<_> = strings(&case["params"]).iter().map(|n| s.pool.symbol(n)).collect();
        let mut evidence = Evidence::default();
        let o = v.observability(&mut s.pool, &outputs, &parameters, &mut evidence).unwrap();
        assert_eq!(o.rank() as u64, case["expected"]["oic_rank"].as_u64().unwrap(), "{name}");
        let answers: BTreeMap<String, bool> =
            serde_json::from_value(case["expected"]["locally_identifiable"].clone()).unwrap();
        for (function, expected) in answers {
            let e = s.pool.parse(&function).unwrap();
            assert_eq!(o.determines(&mut s.pool, e, &mut evidence).unwrap(), expected, "{name}: {function}");
        }
    }
}
