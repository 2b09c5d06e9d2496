//! Functions that cancel in the equations as they are read: where they have no value, nothing is said of the point.

use bracketry_lie::operating::{LinearModel, NotLinearizable, TrimOptions, TrimStatus};
use bracketry_lie::{AnalysisOptions, Answer, analyze_affine, trim};
use bracketry_system::System;

use crate::tier::first;

/// A function with values for some arguments only, an argument for which it has none, and one for which it has.
const PARTIAL: [(&str, &str, &str); 5] = [
    ("sqrt(G)", "-1", "4"),
    ("log(G)", "-1/3", "sqrt(2)"),
    ("G^(1/3)", "-sqrt(2)", "1/5"),
    ("asin(G)", "2", "1/2"),
    ("acos(G)", "-sqrt(3)", "-1/4"),
];
/// Expressions of it that are constant, or as smooth as x.
const CANCELING: [&str; 3] = ["F - F", "0*F", "(y + F) - (F + y)"];
/// Those of one function alone.
const INVERSE: [(usize, &str); 3] = [(0, "F^2"), (1, "exp(F)"), (2, "F^3")];

/// y' = u and x' = an expression in which F(x + y) cancels, written out, by a definition, and by one of another.
fn models(function: &str, canceling: &str) -> [String; 3] {
    let head = "states = ['x', 'y']\ninputs = ['u']\n";
    let f = function.replace('G', "(x + y)");
    let out = canceling.replace('F', &format!("({f})"));
    let named = canceling.replace('F', "f");
    [
        format!("{head}[dynamics]\nx = '{out} + y'\ny = 'u'\n"),
        format!("{head}[definitions]\nf = '{f}'\n[dynamics]\nx = '{named} + y'\ny = 'u'\n"),
        format!("{head}[definitions]\nf = '{f}'\nc = '{named}'\n[dynamics]\nx = 'c + y'\ny = 'u'\n"),
    ]
}

fn at(text: &str, x: &str) -> System {
    System::parse("m", &format!("{text}[point]\nx = '{x}'\n")).unwrap()
}

#[test]
fn nothing_is_said_where_what_cancels_has_no_value() {
    let all = PARTIAL.iter().enumerate().flat_map(|(k, &f)| {
        let own = INVERSE.iter().filter(move |i| i.0 == k).map(|i| i.1);
        CANCELING.into_iter().chain(own).map(move |c| (f, c))
    });
    for ((function, without, with), canceling) in first(100, all) {
        for text in models(function, canceling) {
            let system = at(&text, without);
            let report = analyze_affine(&system, &AnalysisOptions::default()).unwrap();
            assert!(matches!(report.at_point, Some(Answer::Unknown(_))), "{text} at {without}");
            assert!(matches!(LinearModel::new(&system), Err(NotLinearizable::Irregular(_))), "{text} at {without}");
            let fixed = system.point.as_ref().unwrap().states[0];
            let options = TrimOptions { fixed: vec![("x".into(), fixed)], starts: 8, ..TrimOptions::default() };
            // The simplified equations vanish for a y, at which F has no value either.
            assert_eq!(trim(&system, &options).unwrap().status, TrimStatus::NotFound, "{text} at {without}");
            // Elsewhere the answer is that of the equations without it.
            let system = at(&text, with);
            let report = analyze_affine(&system, &AnalysisOptions::default()).unwrap();
            let answer = report.at_point.as_ref().and_then(Answer::known).unwrap();
            assert_eq!(answer.dimensions.accessible_dimension, Answer::Known(2), "{text} at {with}");
            LinearModel::new(&system).unwrap();
        }
    }
}

#[test]
fn a_definition_that_no_equation_names_needs_no_value() {
    let text = "states = ['x']\ninputs = ['u']\n[definitions]\nf = 'log(x)'\ng = '2*f'\n[dynamics]\nx = 'u'\n";
    assert!(at(text, "-1").canceled.is_empty());
    LinearModel::new(&at(text, "-1")).unwrap();
    // Nor does one that is part of an output only where the output has none.
    let text = "states = ['x']\ninputs = ['u']\n[definitions]\nf = 'log(x)'\n[dynamics]\nx = 'u'\n[outputs]\nz = 'f'\n";
    assert!(matches!(LinearModel::new(&at(text, "-1")), Err(NotLinearizable::Irregular(_))));
}

#[test]
fn calls_cancel_as_text_does() {
    let built = |x: f64| {
        let b = System::builder("built");
        let (state, u) = (b.state("x"), b.input("u"));
        b.dynamics(state, state.sqrt().pow(2) + 1.0 + u);
        b.point(state, x);
        b.build().unwrap()
    };
    assert!(
        matches!(LinearModel::new(&built(-1.0)), Err(NotLinearizable::Irregular(why)) if why.to_string().starts_with("sqrt(x), which cancels in the equations, has no value"))
    );
    LinearModel::new(&built(1.0)).unwrap();
}
