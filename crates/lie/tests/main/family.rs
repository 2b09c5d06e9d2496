//! The family of constant inputs and the affine form have the same dimensions, and neither depends on coordinates or
//! feedback.

use bracketry_lie::analysis::{Family, family_dimensions};
use bracketry_lie::{AnalysisOptions, Answer, Report, analyze_affine};
use bracketry_system::{Method, System};
use proptest::prelude::*;

fn model(text: &str) -> System {
    System::parse("test", text).unwrap()
}

/// Model text from states, inputs and equations.
fn text(states: &str, inputs: &str, equations: &[&str]) -> String {
    let list = |s: &str| s.split_whitespace().map(|n| format!("'{n}'")).collect::<Vec<_>>().join(",");
    let lines: Vec<String> = states.split_whitespace().zip(equations).map(|(s, e)| format!("{s} = '{e}'")).collect();
    format!("states = [{}]\ninputs = [{}]\n[dynamics]\n{}\n", list(states), list(inputs), lines.join("\n"))
}

fn report(system: &System) -> Report {
    analyze_affine(system, &AnalysisOptions::default()).unwrap()
}

fn family(original: &System) -> Family {
    let affine = original.affinize().unwrap().system;
    family_dimensions(original, &affine, &report(&affine)).unwrap()
}

/// States, inputs, equations, dim L, dim S, integrators.
type Case<'a> = (&'a str, &'a str, &'a [&'a str], usize, usize, usize);

#[test]
fn dimensions_of_the_family_are_those_of_the_affine_form_without_its_integrators() {
    let cases: &[Case<'_>] = &[
        ("x y", "u", &["cos(u)", "sin(u)"], 2, 2, 1),
        ("x", "u", &["-x + x*u^2"], 1, 1, 0),
        ("x y", "u", &["u", "u^2"], 2, 2, 1),
        // A fixed line: the velocities differ along it only.
        ("x y", "u", &["u^2 + sin(u)", "2*u^2 + 2*sin(u)"], 1, 1, 0),
        ("x y", "u", &["u^2 + sin(u)", "2*u^2 + 2*sin(u) + 1"], 2, 1, 0),
        // The clock z' = 1 is accessible but not strongly.
        ("x y z", "u", &["cos(u)", "sin(u)", "1"], 3, 2, 1),
        ("x y z", "u w", &["u", "w", "u*w"], 3, 3, 1),
        ("x y th", "v w", &["v*cos(th)", "v*sin(th)", "w^3"], 3, 3, 0),
        ("x v", "i", &["v", "9.81 - i^2/x^2"], 2, 2, 0),
        ("x y z", "u1 u2", &["u1^2", "cos(u2)", "sin(u2)"], 3, 3, 1),
        ("x y", "u", &["u + x*u^2", "x*u + x^2*u^2"], 1, 1, 0),
        ("x y", "u", &["abs(u)*u", "y*abs(u)*u"], 1, 1, 0),
        // x + v + X' is constant.
        ("x v", "X", &["v", "-der(X,2) - v"], 3, 3, 0),
        ("x", "u", &["der(u)^2"], 2, 2, 1),
    ];
    for (states, inputs, equations, all, strong, integrators) in cases {
        let f = family(&model(&text(states, inputs, equations)));
        let found = (f.accessible_dimension.clone(), f.strongly_accessible_dimension.clone(), f.integrators);
        assert_eq!(found, (Answer::Known(*all), Answer::Known(*strong), *integrators), "{equations:?}");
        assert_eq!(f.agrees, Answer::Known(true), "{equations:?}: {f:?}");
    }
}

#[test]
fn the_published_plate_agrees_with_its_family_in_every_mode() {
    let plate = System::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/plate_published.toml")).unwrap();
    let f = family(&plate);
    assert_eq!(f.accessible_dimension, Answer::Known(9));
    assert_eq!(f.strongly_accessible_dimension, Answer::Known(8));
    assert_eq!((f.integrators, f.agrees), (0, Answer::Known(true)));
}

#[test]
fn a_form_of_another_system_does_not_agree() {
    let original = model(&text("x y", "u", &["cos(u)", "sin(u)"]));
    let wrong = model(&text("x y u", "v", &["cos(u)", "0", "v"]));
    let f = family_dimensions(&original, &wrong, &report(&wrong)).unwrap();
    assert_eq!(f.agrees, Answer::Known(false));
}

#[test]
fn what_does_not_apply_is_unknown() {
    let f = family(&model(&text("x", "u", &["sign(u - x)"])));
    assert!(f.agrees.reason().unwrap().to_string().contains("depends on an input and on the state"));
    // New states that need fewer integrators than the chain of the input has.
    let original = model(&text("x", "u", &["-x + u + der(u)"]));
    let a = original.affinize().unwrap();
    let lower = a.candidates.iter().find(|c| c.method == Method::CoordinateChange).unwrap().system.clone().unwrap();
    let f = family_dimensions(&original, &lower, &report(&lower)).unwrap();
    assert!(f.agrees.reason().unwrap().to_string().contains("does not keep"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]

    /// Whatever the search does to a random system, each accepted candidate that keeps its states has the family's
    /// dimensions.
    #[test]
    fn every_candidate_of_a_random_system_agrees(rows in prop::collection::vec((0usize..9, 0usize..9, 0usize..5, -2i32..3), 3)) {
        const OF_INPUTS: [&str; 9] = ["u", "w", "u^2", "u*w", "sin(u)", "cos(u)", "exp(w)", "u + x*u^2", "w^3"];
        const OF_STATES: [&str; 5] = ["1", "x", "y*z", "sin(y)", "x + z"];
        let equations: Vec<String> = rows
            .iter()
            .map(|&(i, j, k, c)| format!("{}*{} + ({c})*{}", OF_STATES[k], OF_INPUTS[i], OF_INPUTS[j]))
            .collect();
        let equations: Vec<&str> = equations.iter().map(String::as_str).collect();
        let original = model(&text("x y z", "u w", &equations));
        for c in original.affinize().unwrap().candidates {
            let Some(affine) = c.system else { continue };
            let f = family_dimensions(&original, &affine, &report(&affine)).unwrap();
            prop_assert_eq!(&f.agrees, &Answer::Known(true), "{:?} by {:?}: {:?}", equations, c.method, f);
        }
    }
}
