//! The report as JSON and as text.

use std::path::Path;

use bracketry_diagnose::{
    Candidate, Cause, Closeness, Effort, Evidence, Excess, Formula, Gain, NamedCause, Note, Outcome, Place,
    RefittedParameter, Regime, Report, Rival, Value, Verdict, VerdictReason, Windows,
};
use bracketry_report::{DiagnosisJson, diagnosis_text};
use bracketry_symbolic::Pool;
use bracketry_system::Quantities;
use serde_json::{Value as Json, json, to_value};

fn formula(text: &str) -> Formula {
    let mut pool = Pool::new();
    let e = pool.parse(text).unwrap();
    Formula::new(text, pool.notation(e))
}

fn report() -> Report {
    let c = Value { value: 0.52, std: 0.01, interval: Some([0.5, 0.54]), unit: "kg/s".into() };
    let sliding = Regime::Motion { name: "v".into(), sliding: true, positive: true };
    Report {
        model: "slider".into(),
        quantities: Quantities::default(),
        verdict: Verdict::CauseFound,
        reason: VerdictReason { outcome: Outcome::Explained, caveats: Vec::new() },
        causes: vec![NamedCause {
            name: Cause::ViscousFriction,
            equation: "v".into(),
            term: formula("-c*v"),
            parameters: bracketry_symbolic::Named(vec![("c".into(), c)]),
            p_value: Some(1e-6),
            confusable_with: vec![Cause::QuadraticDrag],
            separating_experiment: "drive faster".into(),
            rivals: vec![Rival {
                name: Cause::QuadraticDrag,
                equation: "v".into(),
                term: formula("-c*v*abs(v)"),
                closeness: Closeness::Equal,
            }],
            share: Some(0.93),
            flags: Vec::new(),
            combination: None,
        }],
        places: vec![Place { equation: "v".into(), regime: sliding, share: 0.8, time: Some(0.4) }],
        regimes: Vec::new(),
        residual_acceleration: Vec::new(),
        gain: Some(Gain {
            metric: "multi-step NRMSE".into(),
            horizons_s: vec![0.1, 0.5, 1.0],
            before: vec![0.02, 0.05, 0.2],
            after: vec![0.01, 0.012, 0.02],
            as_given: vec![0.03, 0.06, 0.3],
            held_out: true,
            predictions: vec![40, 38, 20],
            equation_error_before: Some(0.0595),
            equation_error_after: Some(0.029),
            equation_error_as_given: None,
            equation_bandwidth_hz: Some(100.0),
        }),
        parameters: vec![RefittedParameter {
            name: "mu".into(),
            before: 0.3,
            after: 0.27,
            std: 0.004,
            interval: None,
            unit: String::new(),
        }],
        excess: Some(Excess { refitted: 2.5, extended: Some(1.01), p_value: 1e-20 }),
        candidates: vec![Candidate {
            name: Cause::ViscousFriction,
            equation: "v".into(),
            term: formula("-c*v"),
            share: Some(0.93),
            interval: Some([0.9, 0.95]),
            p_value: 1e-6,
            chosen: true,
        }],
        windows: Some(Windows { count: 16, seconds: 0.5 }),
        data: Vec::new(),
        notes: vec![Note::OnlyParameters],
        seconds: 3.1,
        effort: Effort::default(),
        evidence: Evidence::default(),
    }
}

/// Every key of `expected` is in `found` with its value; objects may have more.
fn assert_contains(found: &Json, expected: &Json, path: &str) {
    match (found, expected) {
        (Json::Object(found), Json::Object(expected)) => {
            for (key, value) in expected {
                let found = found.get(key).unwrap_or_else(|| panic!("{path}/{key} is missing"));
                assert_contains(found, value, &format!("{path}/{key}"));
            }
        }
        (Json::Array(found), Json::Array(expected)) => {
            assert_eq!(found.len(), expected.len(), "{path}");
            for (k, (f, e)) in found.iter().zip(expected).enumerate() {
                assert_contains(f, e, &format!("{path}/{k}"));
            }
        }
        _ => assert_eq!(found, expected, "{path}"),
    }
}

#[test]
fn json_has_the_documented_form() {
    let expected = json!({
        "verdict": "cause_found",
        "causes": [{"name": "viscous_friction", "equation": "v", "term": "-c*v",
                    "parameters": {"c": {"value": 0.52, "std": 0.01}}, "p_value": 1e-6,
                    "confusable_with": ["quadratic_drag"], "separating_experiment": "drive faster"}],
        "where": [{"equation": "v", "regime": "sliding, v > 0", "share": 0.8}],
        "gain": {"metric": "multi-step NRMSE", "horizons_s": [0.1, 0.5, 1.0], "before": [0.02, 0.05, 0.2],
                 "after": [0.01, 0.012, 0.02], "held_out": true,
                 "equation_error_before": 0.0595, "equation_error_after": 0.029},
        "parameters": {"mu": {"before": 0.3, "after": 0.27, "std": 0.004}},
        "extended_model": "out/extended.toml",
        "seconds": 3.1
    });
    assert_contains(
        &to_value(DiagnosisJson::of(&report(), Some(Path::new("out/extended.toml")))).unwrap(),
        &expected,
        "",
    );
}

#[test]
fn what_was_not_found_out_is_absent_from_json() {
    let nothing = Report { verdict: Verdict::NothingFound, causes: Vec::new(), gain: None, ..report() };
    let found = to_value(DiagnosisJson::of(&nothing, None)).unwrap();
    assert_eq!(found["verdict"], "nothing_found");
    assert_eq!(found["causes"], json!([]));
    assert!(found.get("gain").is_none() && found.get("extended_model").is_none());
}

#[test]
fn text_names_the_cause_its_value_its_rival_and_the_gain() {
    let text = diagnosis_text(&report(), Some(Path::new("out/extended.toml")));
    for part in [
        "slider: cause found",
        "viscous_friction in v: -c*v",
        "c = 0.520 ± 0.010 kg/s (95 %: 0.500 … 0.540)",
        "cannot distinguish it from: quadratic_drag",
        "to distinguish them: drive faster",
        "v         sliding, v > 0  80.0 %",
        "0.5 s    6.00 %    5.00 %    1.20 %    4.17 ×",
        "5.95 % refitted, 2.90 % extended (derivatives up to 100 Hz)",
        "mu         0.3     0.2700  0.0040",
        "Extended model: out/extended.toml",
        "Fitted in 16 windows of 0.5",
    ] {
        assert!(text.contains(part), "`{part}` is not in\n{text}");
    }
}
