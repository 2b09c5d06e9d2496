//! The report says of which model it speaks, what it did not check, and nothing that it did not find.

#[path = "../../../lie/tests/main/common/mod.rs"]
#[allow(dead_code)]
mod common;

use bracketry_lie::controllability::{PointReport, Subject, Verdict};
use bracketry_lie::{AnalysisOptions, Answer, Report, analyze_affine};
use bracketry_report::analysis::report_text;
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
    analyze_affine(&model, &AnalysisOptions::default()).unwrap()
}

#[test]
fn at_rest_with_dry_friction_only_dimensions_and_linear_statements_are_of_the_smoothed_model() {
    let r = masses(&[]);
    let p = at_point(&r);
    assert_eq!(
        (p.of, p.epsilon, p.vanishing.iter().map(ToString::to_string).collect::<Vec<_>>()),
        (Subject::Smoothed, Some(0.01), vec!["v1".to_owned(), "v2".to_owned()])
    );
    // The smoothed model can be steered; dry friction holds the second mass until the first is far away.
    let smoothed = p.smoothed_stlc.as_ref().unwrap();
    assert_eq!(smoothed.verdict, Verdict::Yes);
    assert_eq!(smoothed.reason.to_string(), "the linearization is controllable");
    assert_eq!((p.stlc.verdict, p.stlc.with_bounded_inputs()), (Verdict::Inconclusive, Verdict::No));
    let why = p.stlc.bounded.as_ref().unwrap().reason.to_string();
    assert!(why.contains("the motion stays on v2 = 0"), "{why}");
    // Near the point the spring does not overcome the friction of the second mass.
    assert_eq!(p.stabilizable.as_ref().unwrap().known(), Some(&false));
    let json = json_of(&r);
    assert_eq!(json["at_point"]["of"], "smoothed");
    assert_eq!(json["at_point"]["epsilon"], 0.01);
    assert_eq!(json["at_point"]["vanishing"], json!(["v1", "v2"]));
    assert_eq!(json["at_point"]["smoothed_stlc"]["verdict"], "yes");
    let text = report_text(&r);
    let heading = "\nat the point of the model (v1, v2 vanish there); dimensions and linear statements smoothed with width 0.01\n";
    assert!(text.contains(heading), "{text}");
}

#[test]
fn where_one_switching_function_vanishes_it_alone_is_named() {
    let r = masses(&[("v2", "1")]);
    assert_eq!(at_point(&r).vanishing.iter().map(ToString::to_string).collect::<Vec<_>>(), ["v1"]);
    assert!(report_text(&r).contains("(v1 vanishes there)"));
}

#[test]
fn away_from_switching_the_statements_are_of_the_model() {
    let r = masses(&[("v1", "1"), ("v2", "-1")]);
    assert_eq!(at_point(&r).of, Subject::Model);
    assert!(!at_point(&r).stlc.reason.to_string().contains("smoothed"));
    let json = json_of(&r);
    assert_eq!(json["at_point"]["of"], "model");
    assert_eq!(json["at_point"].get("epsilon"), None);
    assert!(report_text(&r).contains("\nat the point of the model\n"));
}

#[test]
fn global_statements_of_a_switched_model_are_labeled() {
    let r = masses(&[]);
    assert_eq!(json_of(&r)["global_statements_of"], "smoothed");
    let text = report_text(&r);
    for line in [
        "input fields involutive: yes",
        "linearizable by static feedback near a generic point: ",
        "observability rank: 4",
    ] {
        assert!(text.contains(&format!("\nsmoothed model: {line}")), "{line} in {text}");
    }
    let smooth =
        analyze_affine(&system(&["x", "v"], &["u"], &[], &["v", "u"], &[], None), &AnalysisOptions::default()).unwrap();
    assert_eq!(json_of(&smooth).get("global_statements_of"), None);
    assert!(!report_text(&smooth).contains("smoothed"));
}

#[test]
fn what_cannot_be_evaluated_leaves_everything_undecided() {
    // The denominator is zero everywhere.
    let rhs = ["u/(sin(x)^2 + cos(x)^2 - 1)", "1/(sin(x)^2 + cos(x)^2 - 1)"];
    let r =
        analyze_affine(&system(&["x", "y"], &["u"], &[], &rhs, &[], Some(&[("x", "1")])), &AnalysisOptions::default())
            .unwrap();
    assert_eq!(r.modes[0].dimensions.accessible_dimension.known(), None);
    assert!(!r.decided());
    let text = report_text(&r);
    assert!(!text.contains("growth") && !text.contains("error probability") && !text.contains("points"), "{text}");
    assert_eq!(json_of(&r)["certificate"].get("error_probability"), None);
    assert!(masses(&[]).decided());
}

#[test]
fn one_other_mode_is_singular() {
    let one =
        analyze_affine(&system(&["v"], &["u"], &[], &["u - sign(v)"], &[], None), &AnalysisOptions::default()).unwrap();
    let text = report_text(&one);
    assert!(text.contains("the same in 1 other mode\n"), "{text}");
    assert!(!text.contains("whether each occurs"), "{text}");
}

#[test]
fn combinations_of_signs_are_not_claimed_to_occur() {
    let text = report_text(&analyze_affine(&ellipse(None), &AnalysisOptions::default()).unwrap());
    assert!(text.starts_with("modes are combinations of signs; whether each occurs is not checked\n"), "{text}");
    assert!(text.contains("the same in 3 other modes\n"), "{text}");
}

/// Some dimensions are decided, those of the mode in which a denominator vanishes everywhere are not.
#[test]
fn all_dimensions_have_to_be_decided_for_all_to_count() {
    let divided = "u/(sin(x)^2 + cos(x)^2 - sign(x))";
    let r = analyze_affine(&system(&["x"], &["u"], &[], &[divided], &[], None), &AnalysisOptions::default()).unwrap();
    let known: Vec<bool> = r.modes.iter().map(|m| m.dimensions.accessible_dimension.known().is_some()).collect();
    assert!(known.contains(&true) && known.contains(&false), "{}", report_text(&r));
    assert!(r.decided() && !r.dimensions_decided() && !r.point_decided());
}

#[test]
fn the_text_names_symmetries_and_remedies() {
    let s = system(&["x", "v"], &[], &[("k", ratio(3, 2)), ("m", ratio(5, 3))], &["v", "-k/m*x"], &["x"], None);
    let text = report_text(&analyze_affine(&s, &AnalysisOptions::default()).unwrap());
    for line in [
        "  parameter k: not identifiable\n",
        "  while parameters are unknown, no output changes along k ∂k + m ∂m (scaling of k by s and m by s)\n",
        "  to make all parameters locally identifiable, it suffices to know: k\n",
    ] {
        assert!(text.contains(line), "{line} in {text}");
    }
}

#[test]
fn the_text_names_the_brackets_that_span_and_what_only_switching_reaches() {
    let car = system(
        &["x", "y", "th", "phi"],
        &["drive", "steer"],
        &[],
        &["drive*cos(th)", "drive*sin(th)", "drive*tan(phi)", "steer"],
        &[],
        None,
    );
    let text = report_text(&analyze_affine(&car, &AnalysisOptions::default()).unwrap());
    assert!(text.contains("spanned by           g1, g2, [g1,g2], [g1,[g1,g2]]"), "{text}");
    let text = report_text(&analyze_affine(&ellipse(None), &AnalysisOptions::default()).unwrap());
    assert!(text.contains("only by switching      vx + Xd: by f(3)-f(1)\n"), "{text}");
}
