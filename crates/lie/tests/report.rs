//! The report says of which model it speaks, what it did not check, and nothing that it did not find.
#![allow(clippy::unwrap_used)]

mod common;

use bracketry_lie::{Answer, Options, PointReport, Report, Subject, Verdict, analyse};
use common::{ellipse, ratio, system};
use serde_json::{Value, json};

fn json_of(r: &Report) -> Value {
    serde_json::to_value(r).unwrap()
}

fn at_point(r: &Report) -> &PointReport {
    r.at_point.as_ref().and_then(Answer::known).unwrap()
}

/// Two masses with dry friction and a weak spring between them; the input acts on the first.
fn masses(point: &[(&str, &str)]) -> Report {
    let model = system(
        &["x1", "x2", "v1", "v2"],
        &["u"],
        &[("k", ratio(1, 100)), ("c", ratio(5, 1))],
        &["v1", "v2", "u - k*(x1 - x2) - c*sign(v1)", "k*(x1 - x2) - c*sign(v2)"],
        &["x1"],
        Some(point),
    );
    analyse(&model, &Options::default()).unwrap()
}

#[test]
fn at_rest_with_dry_friction_the_statements_are_of_the_smoothed_model() {
    let r = masses(&[]);
    let p = at_point(&r);
    assert_eq!((p.of, p.epsilon, p.vanishing.join(", ")), (Subject::Smoothed, Some(0.01), "v1, v2".to_owned()));
    assert_eq!(p.stlc.verdict, Verdict::Yes);
    for reason in [&p.stlc.reason, p.stabilizable_reason.as_ref().unwrap()] {
        assert!(reason.starts_with("of the smoothed model: the linearisation is controllable"), "{reason}");
        assert!(
            reason.ends_with("exact dry friction may hold the state where the inputs do not overcome it"),
            "{reason}"
        );
    }
    let json = json_of(&r);
    assert_eq!(json["at_point"]["of"], "smoothed");
    assert_eq!(json["at_point"]["epsilon"], 0.01);
    assert_eq!(json["at_point"]["vanishing"], json!(["v1", "v2"]));
    let text = r.to_string();
    assert!(text.contains("\nat the point of the model, smoothed with width 0.01 (v1, v2 vanish there)\n"), "{text}");
}

#[test]
fn where_one_switching_function_vanishes_it_alone_is_named() {
    let r = masses(&[("v2", "1")]);
    assert_eq!(at_point(&r).vanishing, ["v1"]);
    assert!(r.to_string().contains("(v1 vanishes there)"));
}

#[test]
fn away_from_switching_the_statements_are_of_the_model() {
    let r = masses(&[("v1", "1"), ("v2", "-1")]);
    assert_eq!(at_point(&r).of, Subject::Model);
    assert!(!at_point(&r).stlc.reason.contains("smoothed"));
    let json = json_of(&r);
    assert_eq!(json["at_point"]["of"], "model");
    assert_eq!(json["at_point"].get("epsilon"), None);
    assert!(r.to_string().contains("\nat the point of the model\n"));
}

#[test]
fn global_statements_of_a_switched_model_are_labelled() {
    let r = masses(&[]);
    assert_eq!(json_of(&r)["global_statements_of"], "smoothed");
    let text = r.to_string();
    for line in [
        "input fields involutive: yes",
        "linearizable by static feedback near a generic point: ",
        "observability rank: 4",
    ] {
        assert!(text.contains(&format!("\nsmoothed model: {line}")), "{line} in {text}");
    }
    let smooth = analyse(&system(&["x", "v"], &["u"], &[], &["v", "u"], &[], None), &Options::default()).unwrap();
    assert_eq!(json_of(&smooth).get("global_statements_of"), None);
    assert!(!smooth.to_string().contains("smoothed"));
}

#[test]
fn what_cannot_be_evaluated_leaves_everything_undecided() {
    // The denominator is zero everywhere.
    let rhs = ["u/(sin(x)^2 + cos(x)^2 - 1)", "1/(sin(x)^2 + cos(x)^2 - 1)"];
    let r = analyse(&system(&["x", "y"], &["u"], &[], &rhs, &[], Some(&[("x", "1")])), &Options::default()).unwrap();
    assert_eq!(r.modes[0].dimensions.accessible_dimension.known(), None);
    assert!(!r.decided());
    let text = r.to_string();
    assert!(!text.contains("growth") && !text.contains("error probability") && !text.contains("points"), "{text}");
    assert_eq!(json_of(&r)["certificate"].get("error_probability"), None);
    assert!(masses(&[]).decided());
}

#[test]
fn one_other_mode_is_singular() {
    let one = analyse(&system(&["v"], &["u"], &[], &["u - sign(v)"], &[], None), &Options::default()).unwrap();
    let text = one.to_string();
    assert!(text.contains("the same in 1 other mode\n"), "{text}");
    assert!(!text.contains("whether each occurs"), "{text}");
}

#[test]
fn combinations_of_signs_are_not_claimed_to_occur() {
    let text = analyse(&ellipse(None), &Options::default()).unwrap().to_string();
    assert!(text.starts_with("modes are combinations of signs; whether each occurs is not checked\n"), "{text}");
    assert!(text.contains("the same in 3 other modes\n"), "{text}");
}

/// Some dimensions are decided, those of the mode in which a denominator vanishes everywhere are not.
#[test]
fn all_dimensions_have_to_be_decided_for_all_to_count() {
    let divided = "u/(sin(x)^2 + cos(x)^2 - sign(x))";
    let r = analyse(&system(&["x"], &["u"], &[], &[divided], &[], None), &Options::default()).unwrap();
    let known: Vec<bool> = r.modes.iter().map(|m| m.dimensions.accessible_dimension.known().is_some()).collect();
    assert!(known.contains(&true) && known.contains(&false), "{r}");
    assert!(r.decided() && !r.dimensions_decided() && !r.point_decided());
}
