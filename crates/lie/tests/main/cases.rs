//! Systems with answers known from the literature, read from the shared folder.
#![allow(clippy::print_stderr)]

#[path = "../../../../tests/main/common/case_file.rs"]
#[allow(dead_code)]
mod case_file;
#[path = "../../../../tests/main/common/known_answers.rs"]
mod known_answers;

use std::collections::BTreeMap;

use crate::common::{fields, system};
use bracketry_lie::{AnalysisOptions, Evidence, Field, Limits, VectorFields, analyze_affine, bracket};
use bracketry_symbolic::{Bindings, Expr, Pool, ZeroTest};
use bracketry_system::System;
use case_file::model_file;
use serde_json::Value;

fn cases() -> Vec<Value> {
    known_answers::cases(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
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

fn model(case: &Value, at: &Value) -> System {
    System::parse("case.toml", &model_file(case, at, &[]).unwrap()).unwrap()
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
    let mut differences = Vec::new();
    for mut case in cases() {
        // How a system becomes affine is no matter of this crate.
        case["expected"].as_object_mut().unwrap().remove("original");
        differences.extend(known_answers::differences(&case, &mut |model, brackets, determined| {
            let system = System::parse("case.toml", model).unwrap();
            let options = AnalysisOptions {
                brackets: brackets.to_vec(),
                determined: determined.to_vec(),
                ..AnalysisOptions::default()
            };
            serde_json::to_value(analyze_affine(&system, &options).unwrap()).unwrap()
        }));
    }
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}

#[test]
fn brackets_have_the_agreed_sign() {
    for case in cases().iter().filter(|c| c["expected"]["bracket"].is_object()) {
        let mut s = model(case, &Value::Null);
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
        let mut s = model(case, at);
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
