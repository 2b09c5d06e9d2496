//! What the report says of the plate, for both shapes.

use bracketry::Analysis;
use bracketry::plate::{Shape, published};

fn analysis(shape: &Shape) -> Analysis {
    bracketry::analyze(&published(shape, 0.3).unwrap(), &bracketry::lie::AnalysisOptions::default()).unwrap()
}

#[test]
fn over_all_modes_smoothed_and_at_rest_the_shape_does_not_matter() {
    for shape in [Shape::REFERENCE_ELLIPSE, Shape::REFERENCE_DISK] {
        let a = analysis(&shape);
        assert_eq!((a.states, a.inputs), (10, 2));
        assert_eq!(a.affinization.integrators.values().sum::<u32>(), 4);
        assert_eq!(a.report.switched.as_ref().unwrap().dimensions.growth, [6, 10], "{shape:?}");
        assert_eq!(a.report.smoothed.as_ref().unwrap().dimensions.growth, [3, 6, 10], "{shape:?}");
        let point = a.report.at_point.as_ref().unwrap().known().unwrap();
        assert_eq!(point.dimensions.growth, [2, 5, 8, 10], "{shape:?}");
        assert_eq!(point.linear_controllability_rank, Some(7), "{shape:?}");
    }
}

#[test]
fn in_one_mode_an_ellipse_leaves_two_functions_to_themselves() {
    let a = analysis(&Shape::REFERENCE_ELLIPSE);
    assert_eq!(a.report.modes.len(), 4);
    for m in &a.report.modes {
        assert_eq!(m.dimensions.growth, [3, 5, 7, 9, 9]);
        assert_eq!(m.dimensions.strong_growth, [2, 4, 6, 8, 8]);
        assert_eq!(m.autonomous.known().unwrap(), &["x + X", "vx + Xd"]);
    }
}

#[test]
fn in_one_mode_a_disk_leaves_its_yaw_to_the_tilt_too() {
    // Its moment about the plate's axis does not depend on yaw: w' = −s μ/2 θ'', so w + s μ/2 θ' is constant.
    let a = analysis(&Shape::REFERENCE_DISK);
    for m in &a.report.modes {
        assert_eq!(m.dimensions.growth, [3, 5, 7, 7]);
        assert_eq!(m.dimensions.strong_growth, [2, 4, 6, 6]);
        let functions = m.autonomous.known().unwrap();
        let forward = m.signs.0.iter().any(|(name, sign)| *name == "vx" && *sign > 0);
        let expected = if forward { "2*phi + mu*theta" } else { "2*phi - mu*theta" };
        let same = |f: &bracketry::lie::Function| {
            let mut p = bracketry::symbolic::Pool::new();
            let (a, b) = (p.parse(&f.to_string()).unwrap(), p.parse(expected).unwrap());
            let difference = p.sub(a, b);
            p.zero_test(difference, &bracketry::symbolic::Bindings::default()).is_zero()
        };
        assert!(functions.iter().any(same), "{expected} among {functions:?}");
    }
}

#[test]
fn the_summary_names_what_stays_and_why_switching_helps() {
    let summary = bracketry::report::analysis::summary(&analysis(&Shape::REFERENCE_ELLIPSE));
    for part in
        ["x + X and vx + Xd", "dimension only 8, out of 10", "difference of two drifts", "10 of 10", "smoothed model"]
    {
        assert!(summary.contains(part), "`{part}` in: {summary}");
    }
}

#[test]
fn a_one_sided_input_is_not_called_controllable() {
    // v' = u² ≥ 0: the affine system v' = v1 is controllable, the original one is not.
    let text = "states = ['x', 'v']\ninputs = ['u']\n[dynamics]\nx = 'v'\nv = 'u^2'\n[point]\nu = 0";
    let system = bracketry::system::System::parse("m", text).unwrap();
    let a = bracketry::analyze(&system, &bracketry::lie::AnalysisOptions::default()).unwrap();
    assert_eq!(a.affinization.input_change[0].range().as_deref(), Some("v1 ≥ 0"));
    let point = a.report.at_point.unwrap();
    let point = point.known().unwrap();
    assert_eq!(point.stlc.verdict, bracketry::lie::controllability::Verdict::No);
    // v never falls.
    assert_eq!(point.stabilizable.as_ref().unwrap().known(), Some(&false));
    // Around u = 1 the same input goes both ways, but only u = 0 holds the state, at the end of the range.
    let system = bracketry::system::System::parse("m", &text.replace("u = 0", "u = 1")).unwrap();
    let a = bracketry::analyze(&system, &bracketry::lie::AnalysisOptions::default()).unwrap();
    assert_ne!(a.report.at_point.unwrap().known().unwrap().stlc.verdict, bracketry::lie::controllability::Verdict::Yes);
}

#[test]
fn the_rounds_show_what_one_mode_never_moves_and_switching_does() {
    use bracketry::Influence::{Free, Moves, None};
    let tables = analysis(&Shape::REFERENCE_ELLIPSE).report.reach;
    assert_eq!(tables.len(), 2);
    let row = |t: usize, name: &str| tables[t].rows.iter().find(|r| r.function == name).unwrap().influence.clone();
    assert_eq!(row(0, "x + X"), [None; 5]);
    assert_eq!(row(0, "x"), [None, Moves, Moves, Moves, Moves]);
    assert_eq!(row(0, "theta"), [None, Moves, Moves, Free, Free]);
    assert_eq!(row(1, "x + X"), [None, Free]);
    assert_eq!(row(1, "x"), [None, Free]);
    assert_eq!((tables[0].alike, tables[0].signs.condition().to_string()), (4, "vx > 0, vy > 0".to_owned()));
}

#[test]
fn a_state_without_any_input_is_influenced_by_none() {
    let text = "states = ['a', 'b']\ninputs = ['u']\n[dynamics]\na = 'u'\nb = '-b'";
    let system = bracketry::system::System::parse("m", text).unwrap();
    let tables = bracketry::analyze(&system, &bracketry::lie::AnalysisOptions::default()).unwrap().report.reach;
    let last: Vec<_> =
        tables[0].rows.iter().map(|r| (r.function.to_string(), r.influence.last().copied().unwrap())).collect();
    assert_eq!(last, [("a".into(), bracketry::Influence::Free), ("b".into(), bracketry::Influence::None)]);
}

#[test]
fn integrators_in_front_of_inputs_are_known_states() {
    let text = "states = ['x']\ninputs = ['u']\n[parameters]\na = 1\nb = 2\n[dynamics]\nx = '-a*x + sin(b*u) + u^3'\n[outputs]\ny = 'x'";
    let system = bracketry::system::System::parse("m", text).unwrap();
    let a = bracketry::analyze(&system, &bracketry::lie::AnalysisOptions::default()).unwrap();
    let o = a.report.observability.unwrap();
    assert_eq!((o.rank.known(), o.unobservable.len(), o.rank_with_parameters), (Some(&1), 0, Some(3)));
    assert!(o.identifiable.unwrap().0.iter().all(|p| p.1));
}

#[test]
fn the_affine_form_reaches_as_much_as_the_original_with_constant_inputs() {
    let a = analysis(&Shape::REFERENCE_ELLIPSE);
    let family = a.family.as_ref().unwrap();
    assert_eq!(family.agrees, bracketry::lie::Answer::Known(true));
    assert!(bracketry::report::analysis::text(&a).contains("agrees"));
    // Affine as it stands: nothing to compare.
    let a = bracketry::analyze(&a.affinization.system, &bracketry::lie::AnalysisOptions::default()).unwrap();
    assert!(a.family.is_none());
}

#[test]
fn one_sided_inputs_that_push_to_one_side_do_not_control() {
    let verdict = |dynamics: &str| {
        let text = format!("states = ['x', 'y']\ninputs = ['a', 'b', 'c']\n[dynamics]\n{dynamics}\n[point]\n");
        let system = bracketry::system::System::parse("m", &text).unwrap();
        let a = bracketry::analyze(&system, &bracketry::lie::AnalysisOptions::default()).unwrap();
        a.report.at_point.unwrap().known().unwrap().stlc.verdict
    };
    // Three cables that can only pull: 120° apart they do control, all to one side they do not.
    assert_ne!(verdict("x = 'a^2 - b^2/2 - c^2/2'\ny = 'b^2 - c^2'"), bracketry::lie::controllability::Verdict::No);
    assert_ne!(verdict("x = 'a^2 + b^2/2 + c^2/2'\ny = 'b^2 - c^2'"), bracketry::lie::controllability::Verdict::Yes);
    assert_eq!(verdict("x = 'a^2'\ny = 'x + b'"), bracketry::lie::controllability::Verdict::No);
    assert_eq!(verdict("x = 'a^2 - b^2'\ny = 'c'"), bracketry::lie::controllability::Verdict::Yes);
}

#[test]
fn inputs_that_hold_the_point_must_lie_in_their_range() {
    use bracketry::lie::controllability::Verdict::{No, Yes};
    let verdict = |rate: &str, u: &str| {
        let text = format!("states = ['x']\ninputs = ['u']\n[dynamics]\nx = '{rate}'\n[point]\nu = {u}");
        let system = bracketry::system::System::parse("m", &text).unwrap();
        let a = bracketry::analyze(&system, &bracketry::lie::AnalysisOptions::default()).unwrap();
        a.report.at_point.unwrap().known().unwrap().stlc.verdict
    };
    // x' = sin(u) rests inside the range, x' = sin(u) − 1 at its end; x' = sin(u) − 2 never does.
    assert_eq!(verdict("sin(u)", "0"), Yes);
    assert_ne!(verdict("sin(u) - 1", "'pi/2'"), Yes);
    assert_ne!(verdict("sin(u) - 2", "0"), Yes);
    // x' = exp(u) > 0 has no rest, x' = exp(u) − 1 has one.
    assert_ne!(verdict("exp(u)", "0"), Yes);
    assert_eq!(verdict("exp(u) - 1", "0"), Yes);
    // At the end of the range the state can only rise.
    assert_eq!(verdict("u^2", "0"), No);
    assert_ne!(verdict("1 - cos(u)", "0"), Yes);
}
