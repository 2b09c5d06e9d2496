//! Verdicts at a point that an affine form or a linearization alone would get wrong, and values that have none.

use bracketry::Analysis;
use bracketry::lie::Answer;
use bracketry::lie::controllability::{PointReport, Verdict};
use bracketry::system::System;

fn analysis(states: &str, inputs: &str, dynamics: &str, rest: &str) -> Analysis {
    let list = |names: &str| names.split(' ').map(|n| format!("'{n}'")).collect::<Vec<_>>().join(", ");
    let text = format!("states = [{}]\ninputs = [{}]\n[dynamics]\n{dynamics}\n{rest}", list(states), list(inputs));
    bracketry::analyze(&System::parse("m", &text).unwrap(), &bracketry::lie::AnalysisOptions::default()).unwrap()
}

fn at_point(a: &Analysis) -> &PointReport {
    a.report.at_point.as_ref().and_then(Answer::known).unwrap()
}

/// u1 = 0 holds x still, so that no input gives x' = ε, y' = 0: Brockett's condition fails for the original, though the
/// affine form x' = v1, y' = v2 is as controllable as can be.
#[test]
fn feedback_of_new_inputs_needs_all_values_that_they_take_together() {
    for second in ["u1", "u1 + u2"] {
        let a = analysis("x y", "u1 u2", &format!("x = 'u1*u2'\ny = '{second}'"), "[point]");
        let p = at_point(&a);
        assert_ne!(p.stabilizable, Some(Answer::Known(true)), "{second}");
        assert_ne!(p.brockett_condition, Some(Answer::Known(true)), "{second}");
    }
    // u + u³ takes every value near 0, each once.
    let p = analysis("x", "u", "x = 'x + u + u^3'", "[point]");
    assert_eq!(at_point(&p).stabilizable, Some(Answer::Known(true)));
}

/// x' = x − y³, y' = u is stabilized by feedback that is continuous but not differentiable (Kawski 1989), and
/// x' = x + x u by u = −2.
#[test]
fn an_unstable_mode_out_of_reach_of_smooth_feedback_does_not_exclude_other_feedback() {
    for (states, dynamics) in [("x y", "x = 'x - y^3'\ny = 'u'"), ("x", "x = 'x + x*u'")] {
        let a = analysis(states, "u", dynamics, "[point]");
        assert_eq!(at_point(&a).stabilizable, Some(Answer::Known(true)), "{dynamics}");
    }
    let linear = analysis("x y", "u", "x = 'x'\ny = 'x + u'", "[point]");
    assert_eq!(at_point(&linear).stabilizable, Some(Answer::Known(false)));
}

/// The passive joint of a horizontal arm keeps its angular momentum: 3 of 4 dimensions at generic points, so no more at rest.
#[test]
fn what_generic_points_lack_no_point_has() {
    let d = "((3 + cos(q2)) - (1 + 0.5*cos(q2))^2)";
    let dynamics = format!(
        "q1 = 'w1'\nq2 = 'w2'\n\
         w1 = '(0.5*sin(q2)*(2*w1*w2 + w2^2) - (1 + 0.5*cos(q2))*(t2 - 0.5*sin(q2)*w1^2))/{d}'\n\
         w2 = '(-(1 + 0.5*cos(q2))*0.5*sin(q2)*(2*w1*w2 + w2^2) + (3 + cos(q2))*(t2 - 0.5*sin(q2)*w1^2))/{d}'"
    );
    let a = analysis("q1 q2 w1 w2", "t2", &dynamics, "[point]");
    assert_eq!(a.report.modes[0].dimensions.accessible_dimension, Answer::Known(3));
    assert_eq!(at_point(&a).stlc.verdict, Verdict::No);
}

#[test]
fn outputs_that_linearize_say_where_they_have_no_value() {
    let a = analysis("x y z", "u1 u2", "x = 'u1'\ny = 'z + y*u1'\nz = 'u2'", "[outputs]\na = 'x'\nb = 'y'");
    let report = a.report.control.feedback_linearization.as_ref().unwrap();
    if report.linearizing_outputs.iter().any(|h| h.to_string().contains("log(y)")) {
        assert!(report.singular_set.as_ref().unwrap().to_string().contains("y = 0"));
    } else {
        assert!(!report.linearizing_outputs.is_empty());
    }
}

#[test]
fn exponents_may_be_variables_and_irrational() {
    for rate in ["2^x*u", "x^x*u", "x^pi*u", "(x + 1)^x*u", "2^x^x*u"] {
        let a = analysis("x", "u", &format!("x = '{rate}'"), "[point]\nx = 1");
        assert_ne!(a.report.modes[0].dimensions.accessible_dimension, Answer::Known(0), "{rate}");
    }
}

#[test]
fn a_point_that_is_no_number_is_refused() {
    let mut system = System::parse("m", "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u' }").unwrap();
    for value in ["sqrt(-1)", "log(0)", "1/0"] {
        let error = bracketry::point(&mut system, &format!("x={value}")).unwrap_err().to_string();
        assert!(error.contains('x'), "{error}");
    }
}

/// v' = −x + u²: what the affine form was told of its new input stays in the model file that it is written to.
#[test]
fn the_range_of_a_new_input_goes_into_the_affine_model_file() {
    let text = "states = ['x', 'v']\ninputs = ['u']\n[dynamics]\nx = 'v'\nv = '-x + u^2'\n[point]";
    let affine = System::parse("m", text).unwrap().affinize().unwrap().system;
    let written = affine.to_toml().unwrap();
    let again = System::parse("affine.toml", &written).unwrap();
    assert_eq!(again.input_ranges.len(), 1, "{written}");
    assert_eq!((&again.input_ranges[0].min, &again.input_ranges[0].max), (&Some(0.into()), &None), "{written}");
    let verdict = |s: &System| {
        let a = bracketry::analyze(s, &bracketry::lie::AnalysisOptions::default()).unwrap();
        at_point(&a).stlc.verdict
    };
    assert_eq!(verdict(&again), Verdict::No, "{written}");
    // Around v1 = 1, inside the range, the same equations are controllable.
    let inside = written.replace("[point]", "[point]\nx = 1\nv1 = 1");
    assert_eq!(verdict(&System::parse("inside.toml", &inside).unwrap()), Verdict::Yes, "{inside}");
}

#[test]
fn a_range_of_no_input_or_without_values_is_refused() {
    let with = |range: &str| {
        let text = format!("states = ['x']\ninputs = ['u']\n[ranges]\n{range}\n[dynamics]\nx = 'u'");
        System::parse("m.toml", &text).unwrap_err().to_string()
    };
    assert!(with("w = { min = 0 }").contains("`w` is not an input"));
    assert!(with("u = { min = 1, max = 0 }").contains("range of `u`"));
    assert!(with("u = 3").contains("range of `u`"));
    assert!(with("u = { low = 3 }").contains("low"));
}

/// x' = u with u ≥ 0 only rises, whether u is an input or has an integrator in front of it.
#[test]
fn an_input_at_the_end_of_its_range_stabilizes_nothing() {
    for rate in ["u", "u + sin(u) - cos(u) + 1"] {
        let text = format!(
            "states = ['x', 'y']\ninputs = ['u', 'w']\n[ranges]\nu = {{ min = 0 }}\n[dynamics]\nx = '{rate}'\ny = 'w'\n[point]"
        );
        let a = bracketry::analyze(&System::parse("m", &text).unwrap(), &bracketry::lie::AnalysisOptions::default())
            .unwrap();
        let p = at_point(&a);
        assert_ne!(p.stlc.verdict, Verdict::Yes, "{rate}");
        assert_ne!(p.stabilizable, Some(Answer::Known(true)), "{rate}");
        assert_ne!(p.brockett_condition, Some(Answer::Known(true)), "{rate}");
    }
}
