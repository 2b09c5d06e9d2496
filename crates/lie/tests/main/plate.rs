//! What the inputs of the hyper-plate reach: published model with four integrators.

use crate::common::{answered, disk, ellipse};
use bracketry_lie::controllability::Verdict;
use bracketry_lie::{AnalysisOptions, Answer, Report, analyze_affine};

const REST: &[(&str, &str)] = &[];

fn reports(point: Option<&[(&str, &str)]>) -> [Report; 2] {
    [disk(point), ellipse(point)].map(|s| analyze_affine(&s, &AnalysisOptions::default()).unwrap())
}

#[test]
fn an_ellipse_is_not_accessible_in_any_mode_and_two_sums_are_out_of_reach() {
    let report = analyze_affine(&ellipse(None), &AnalysisOptions::default()).unwrap();
    assert_eq!(report.modes.len(), 4);
    for mode in &report.modes {
        assert_eq!(mode.dimensions.growth, [3, 5, 7, 9, 9]);
        assert_eq!(mode.dimensions.strong_growth, [2, 4, 6, 8, 8]);
        assert_eq!(answered(&mode.autonomous), Answer::Known(vec!["x + X".into(), "vx + Xd".into()]));
        assert_eq!(mode.autonomous_not_found, None);
        assert_eq!(mode.involutive, Answer::Known(true));
    }
}

/// The yaw inertia of a disk does not depend on phi: w' = −s mu/2 thetadd as long as vx keeps its sign s.
#[test]
fn a_disk_also_turns_with_the_plate() {
    let report = analyze_affine(&disk(None), &AnalysisOptions::default()).unwrap();
    for mode in &report.modes {
        assert_eq!(mode.dimensions.growth, [3, 5, 7, 7]);
        assert_eq!(mode.dimensions.strong_growth, [2, 4, 6, 6]);
        let sign = if mode.signs.0[0].1 > 0 { "+" } else { "-" };
        let found = [
            "x + X".to_owned(),
            "vx + Xd".to_owned(),
            format!("2*phi {sign} mu*theta"),
            format!("2*w {sign} mu*thetad"),
        ];
        assert_eq!(answered(&mode.autonomous), Answer::Known(found.to_vec()));
    }
}

#[test]
fn switching_between_modes_reaches_everything() {
    for report in reports(None) {
        let all = report.switched.unwrap().dimensions;
        assert_eq!(all.growth, [6, 10]);
        assert_eq!(all.accessible_dimension, Answer::Known(10));
        assert_eq!(all.strongly_accessible_dimension, Answer::Known(10));
    }
}

#[test]
fn the_smoothed_plate_is_accessible() {
    for report in reports(None) {
        let smoothed = report.smoothed.unwrap();
        assert_eq!(smoothed.dimensions.growth, [3, 6, 10]);
        assert_eq!(smoothed.dimensions.strongly_accessible_dimension, Answer::Known(10));
    }
}

#[test]
fn at_rest_the_smoothed_plate_is_accessible() {
    for report in reports(Some(REST)) {
        let Some(Answer::Known(p)) = report.at_point else { panic!("{:?}", report.at_point_reason) };
        assert_eq!(p.equilibrium, Answer::Known(true));
        assert_eq!(p.dimensions.growth, [2, 5, 8, 10]);
        assert_eq!(p.linear_controllability_rank, Some(7));
        let smoothed = p.smoothed_stlc.unwrap();
        assert_eq!(smoothed.verdict, Verdict::Yes);
        assert_eq!(smoothed.weights, Some(vec![1, 1]));
        // Of the plate itself that says nothing: dry friction holds the object against small accelerations.
        assert_ne!(p.stlc.verdict, Verdict::Yes);
    }
}

#[test]
fn the_report_has_the_agreed_field_names() {
    let report = analyze_affine(&ellipse(Some(REST)), &AnalysisOptions::default()).unwrap();
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["modes"][1]["signs"], serde_json::json!({"vx": 1, "vy": -1}));
    assert_eq!(json["modes"][0]["accessible_dimension"], 9);
    assert_eq!(json["modes"][0]["strongly_accessible_dimension"], 8);
    assert_eq!(json["modes"][0]["autonomous"], serde_json::json!(["x + X", "vx + Xd"]));
    assert_eq!(json["switched"]["growth"], serde_json::json!([6, 10]));
    assert_eq!(json["smoothed"]["epsilon"], 0.01);
    assert_eq!(json["at_point"]["equilibrium"], true);
    assert_eq!(json["involutive"], false);
    assert_eq!(json["static_feedback_linearizable"], false);
    assert_eq!(json["certificate"]["prime"], "2^61-1");
    assert!(json["certificate"]["error_probability"].as_str().unwrap().starts_with("< 1e-"));
}
