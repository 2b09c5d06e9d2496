//! The necessary condition for flatness by ruled manifolds, on systems whose velocities are ruled or not by construction.

use crate::common::{ratio, system};
use bracketry_lie::feedback::{FlatnessReport, FlatnessVerdict};
use bracketry_lie::reason::FlatnessReason;
use bracketry_lie::{AnalysisOptions, analyze, analyze_affine};
use bracketry_system::System;

fn general(s: &System) -> FlatnessReport {
    analyze(s, &AnalysisOptions::default()).unwrap().report.control.flatness.unwrap()
}

/// x' = u, y' = v, z' = `rate`.
fn surface(rate: &str) -> System {
    system(&["x", "y", "z"], &["u", "v"], &[("k", ratio(3, 7))], &["u", "v", rate], &[], None)
}

/// The same with integrators in front of the inputs.
fn prolonged(rate: &str) -> System {
    system(&["x", "y", "z", "u", "v"], &["a", "b"], &[("k", ratio(3, 7))], &["u", "v", rate, "a", "b"], &[], None)
}

/// Definite forms, also after changes of coordinates z + x y, z + x² and linear changes of the inputs; a graph of order 3.
const NOT_RULED: &[&str] = &[
    "u^2 + v^2",
    "u^2 + u*v + v^2",
    "2*(u + v)^2 + 3*(u - 2*v)^2 + k*z",
    "k*u^2 + v^2 + u*y + v*x",
    "u^2*(1 + x^2) + v^2 + 2*x*u - z",
    "u^3 + v^3",
    "u^4 + v^4 + x",
    "u^2*v + u*v^2 + v^3*u^2 + u^5",
    "sin(x)^2*u^2 + v^2",
];

/// Affine, products, and cones: in every case lines through all points.
const RULED: &[&str] =
    &["u*v", "u*v + u*y + v*x", "(u + v)*(u - 2*v)", "y*u", "u^2 - v^2 + z", "u^2*v", "v*sin(u)", "u^2/v"];

#[test]
fn surfaces_without_lines_exclude_flatness() {
    for rate in NOT_RULED {
        let found = general(&surface(rate));
        assert_eq!((found.verdict, found.reason), (FlatnessVerdict::No, FlatnessReason::NotRuled), "{rate}");
        let found = analyze_affine(&prolonged(rate), &AnalysisOptions::default()).unwrap().control.flatness.unwrap();
        assert_eq!(found.verdict, FlatnessVerdict::No, "prolonged: {rate}");
    }
}

#[test]
fn surfaces_with_lines_do_not() {
    for rate in RULED {
        assert_ne!(general(&surface(rate)).verdict, FlatnessVerdict::No, "{rate}");
        let found = analyze_affine(&prolonged(rate), &AnalysisOptions::default()).unwrap().control.flatness.unwrap();
        assert_ne!(found.verdict, FlatnessVerdict::No, "prolonged: {rate}");
    }
}

#[test]
fn three_inputs_by_semidefinite_combinations() {
    let of = |first: &str, second: &str| {
        general(&system(&["x", "y", "z", "p", "q"], &["u", "v", "w"], &[], &["u", "v", "w", first, second], &[], None))
            .verdict
    };
    // Each form is indefinite or degenerate; together they have no common real zero.
    assert_eq!(of("u^2 - v^2", "v^2 + w^2 - u^2/2"), FlatnessVerdict::No);
    assert_eq!(of("u^2", "v^2 + w^2 + u*v"), FlatnessVerdict::No);
    assert_ne!(of("u^2 - v^2", "v*w"), FlatnessVerdict::No);
}

/// A new input for u² + v² beside those for u and v is none of the model's own.
#[test]
fn flatness_of_an_affine_form_with_dependent_inputs_is_not_that_of_the_model() {
    let s = system(&["x", "y", "z"], &["u", "v"], &[], &["u", "v", "u*v + u^2*v^2"], &[], None);
    let found = general(&s);
    assert_ne!(found.verdict, FlatnessVerdict::Yes, "{}", found.reason);
}
