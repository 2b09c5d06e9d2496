//! Systems at the edge of what can be said: the answer is exact, unknown with a reason, or a clear error.

use crate::common::{answered, ratio, system};
use bracketry_lie::controllability::{PointReport, Verdict};
use bracketry_lie::{AnalysisOptions, Answer, Error, Report, analyze_affine};
use bracketry_system::System;

fn report(s: &System) -> Report {
    analyze_affine(s, &AnalysisOptions::default()).unwrap()
}

fn at_point(r: &Report) -> &PointReport {
    r.at_point.as_ref().and_then(Answer::known).unwrap()
}

#[test]
fn without_inputs_every_state_is_autonomous() {
    let r = report(&system(&["x", "y"], &[], &[], &["y", "-sin(x) - y"], &[], Some(&[])));
    assert_eq!(r.modes[0].dimensions.growth, [1, 1]);
    assert_eq!(r.modes[0].dimensions.strong_growth, [0]);
    assert_eq!(answered(&r.modes[0].autonomous), Answer::Known(vec!["x".into(), "y".into()]));
    // At rest nothing moves, yet the pendulum's damped equilibrium needs no input.
    assert_eq!(at_point(&r).dimensions.accessible_dimension, Answer::Known(0));
    assert_eq!(at_point(&r).stabilizable, Some(Answer::Known(true)));
    assert_eq!(at_point(&r).stlc.verdict, Verdict::No);
}

#[test]
fn an_unstable_mode_out_of_reach_cannot_be_stabilized() {
    let r = report(&system(&["x", "y"], &["u"], &[], &["u", "2*y"], &[], Some(&[])));
    assert_eq!(at_point(&r).linear_controllability_rank, Some(1));
    assert_eq!(at_point(&r).stabilizable, Some(Answer::Known(false)));
}

/// VTOL aircraft held up by its thrust: an equilibrium only with the input of the point.
#[test]
fn the_inputs_of_the_point_count() {
    let model = |thrust: &str| {
        let dynamics = ["vx", "vy", "w", "-sin(th)*u1 + ep*cos(th)*u2", "cos(th)*u1 + ep*sin(th)*u2 - gr", "u2"];
        report(&system(
            &["x", "y", "th", "vx", "vy", "w"],
            &["u1", "u2"],
            &[("gr", ratio(981, 100)), ("ep", ratio(1, 10))],
            &dynamics,
            &[],
            Some(&[("u1", thrust)]),
        ))
    };
    let hover = model("gr");
    assert_eq!(at_point(&hover).equilibrium, Answer::Known(true));
    assert_eq!(at_point(&hover).linear_controllability_rank, Some(6));
    assert_eq!(at_point(&hover).stlc.verdict, Verdict::Yes);
    let fall = model("0");
    assert_eq!(at_point(&fall).equilibrium, Answer::Known(false));
    assert_eq!(at_point(&fall).linear_controllability_rank, None);
    // The verdict is then around the inputs that would hold the point.
    assert_eq!(at_point(&fall).stlc.verdict, Verdict::Yes);
    assert!(at_point(&fall).stlc.reason.to_string().starts_with("about u1 = gr, u2 = 0, which holds the point"));
}

#[test]
fn a_point_with_pi_and_sines_of_rationals_is_exact() {
    let r = report(&system(
        &["x", "y", "th"],
        &["u", "v"],
        &[],
        &["u*cos(th)", "u*sin(th)", "v"],
        &[],
        Some(&[("x", "pi"), ("th", "0.7")]),
    ));
    assert_eq!(at_point(&r).dimensions.growth, [2, 3]);
    let r = report(&system(&["x", "y"], &["u"], &[], &["u", "cos(x)"], &[], Some(&[("x", "pi/2")])));
    assert_eq!(at_point(&r).equilibrium, Answer::Known(true));
    assert_eq!(at_point(&r).linear_controllability_rank, Some(2));
}

/// √3 is no residue modulo 2^61 − 1, so values at π/3 need another prime. There x' = (sin x − √3/2) u stands still.
#[test]
fn a_point_with_the_root_of_three_is_exact() {
    let at = |x: &str| {
        let dynamics = ["(sin(x) - sqrt(3)/2)*u", "cos(x)*w"];
        at_point(&report(&system(&["x", "y"], &["u", "w"], &[], &dynamics, &[], Some(&[("x", x)])))).dimensions.clone()
    };
    assert_eq!(at("pi/3").accessible_dimension, Answer::Known(1));
    assert_eq!(at("2*pi/3").accessible_dimension, Answer::Known(1));
    assert_eq!(at("pi/4").accessible_dimension, Answer::Known(2));
}

#[test]
fn a_singular_point_is_unknown_with_a_reason() {
    let r = report(&system(&["x", "y"], &["u"], &[], &["u", "tan(x)/y"], &[], Some(&[])));
    assert_eq!(r.modes[0].dimensions.accessible_dimension, Answer::Known(2));
    let json = serde_json::to_value(&r).unwrap();
    assert_eq!(json["at_point"], "unknown");
    assert_eq!(json["at_point_reason"], "1/y has no value at the point");
}

#[test]
fn a_central_force_moves_a_body_along_one_line() {
    // The Lie algebra is infinite-dimensional; an invariant plane shows that the rest stays at rest.
    let r = report(&system(
        &["x", "y", "th", "vx", "vy", "w"],
        &["u"],
        &[],
        &["vx", "vy", "w", "u*cos(th)", "u*sin(th)", "0"],
        &[],
        Some(&[]),
    ));
    assert_eq!(at_point(&r).dimensions.growth, [1, 2, 2]);
    assert_eq!(at_point(&r).dimensions.accessible_dimension, Answer::Known(2));
    assert_eq!(r.modes[0].dimensions.accessible_dimension, Answer::Known(5));
    assert_eq!(r.modes[0].dimensions.strongly_accessible_dimension, Answer::Known(4));
    assert_eq!(answered(&r.modes[0].autonomous), Answer::Known(vec!["th".into(), "w".into()]));
}

#[test]
fn autonomous_products_are_found() {
    let r = report(&system(&["x", "y"], &["u"], &[], &["x*u", "y - y*u"], &[], None));
    assert_eq!(answered(&r.modes[0].autonomous), Answer::Known(vec!["x*y".into()]));
}

#[test]
fn a_root_is_exact() {
    let r = report(&system(&["x", "y"], &["u"], &[], &["u", "sqrt(1 + x^2) - 1"], &[], Some(&[])));
    // ẏ = x²/2 + … moves one way only.
    assert_eq!(at_point(&r).dimensions.growth, [1, 1, 2]);
    assert_eq!(at_point(&r).stlc.with_bounded_inputs(), Verdict::No);
    assert_ne!(at_point(&r).stlc.verdict, Verdict::Yes);
}

#[test]
fn what_is_not_affine_is_an_error() {
    let square = system(&["x"], &["u"], &[], &["u^2"], &[], None);
    assert!(matches!(analyze_affine(&square, &AnalysisOptions::default()), Err(Error::NotAffine { .. })));
    let switched_input = system(&["x"], &["u"], &[], &["sign(u)"], &[], None);
    assert!(matches!(analyze_affine(&switched_input, &AnalysisOptions::default()), Err(Error::NotAffine { .. })));
    let many: Vec<String> = (0..11).map(|i| format!("sign(x - {i})")).collect();
    let switches = system(&["x"], &[], &[], &[&many.join(" + ")], &[], None);
    assert_eq!(analyze_affine(&switches, &AnalysisOptions::default()).unwrap_err(), Error::Modes { switches: 11 });
    assert_eq!(
        analyze_affine(&system(&[], &[], &[], &[], &[], None), &AnalysisOptions::default()).unwrap_err(),
        Error::NoStates
    );
}

#[test]
fn the_longest_growth_of_trailers_is_found() {
    let n = 6;
    let chain = |i: usize| (0..i).map(|j| format!("*cos(t{j} - t{})", j + 1)).collect::<Vec<_>>().concat();
    let mut states = vec!["x".to_owned(), "y".to_owned()];
    states.extend((0..=n).map(|i| format!("t{i}")));
    let mut dynamics = vec![format!("u1*cos(t{n}){}", chain(n)), format!("u1*sin(t{n}){}", chain(n)), "u2".to_owned()];
    dynamics.extend((1..=n).map(|i| format!("u1{}*sin(t{} - t{i})", chain(i - 1), i - 1)));
    let states: Vec<&str> = states.iter().map(String::as_str).collect();
    let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
    let r = report(&system(&states, &["u1", "u2"], &[], &dynamics, &[], Some(&[])));
    assert_eq!(r.modes[0].dimensions.growth, [2, 3, 4, 5, 6, 7, 8, 9]);
    assert_eq!(at_point(&r).dimensions.growth, [2, 3, 4, 5, 6, 7, 8, 9]);
}

#[test]
fn many_inputs_are_not_permuted_forever() {
    // Nine integrators and one product that no linearization reaches.
    let names: Vec<String> = (0..9).map(|i| format!("v{i}")).chain(["z".to_owned()]).collect();
    let inputs: Vec<String> = (0..9).map(|i| format!("u{i}")).collect();
    let mut dynamics = inputs.clone();
    dynamics.push("v0*v1".to_owned());
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
    let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
    let r = report(&system(&names, &inputs, &[], &dynamics, &[], Some(&[])));
    assert_eq!(at_point(&r).linear_controllability_rank, Some(9));
    // The only bad brackets, [v_i, [f, v_i]], vanish: v0·v1 takes both signs.
    assert_eq!(at_point(&r).stlc.verdict, Verdict::Yes);
}

/// x_1' = u, x_i' = x_{i−1} cos(x_i): every bracket is longer than the one before.
fn chain(n: usize) -> Report {
    let names: Vec<String> = (1..=n).map(|i| format!("x{i}")).collect();
    let mut dynamics = vec!["u".to_owned()];
    dynamics.extend((2..=n).map(|i| format!("x{}*cos(x{i})", i - 1)));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
    report(&system(&names, &["u"], &[], &dynamics, &[], Some(&[])))
}

#[test]
fn a_long_chain_is_followed_to_its_end() {
    let n = 16;
    let r = chain(n);
    assert_eq!(r.modes[0].dimensions.strong_growth, (1..=n).collect::<Vec<_>>());
    assert_eq!(r.static_feedback_linearizable, Answer::Known(true));
    // The drift vanishes at the point: its brackets with the input field alone span everything.
    assert_eq!(at_point(&r).dimensions.growth, (1..=n).collect::<Vec<_>>());
    assert_eq!(at_point(&r).stlc.verdict, Verdict::Yes);
}

/// Coordinate fields take the place of the brackets at a generic point, but not at a given one.
#[test]
fn a_chain_that_is_too_long_is_decided_but_for_the_point() {
    let n = 60;
    let r = chain(n);
    assert_eq!(r.modes[0].dimensions.strong_growth, (1..=n).collect::<Vec<_>>());
    assert_eq!(r.involutive, Answer::Known(true));
    let reason = at_point(&r).dimensions.reason.as_ref().unwrap().to_string();
    assert!(reason.contains("brackets longer than 12 were not formed"), "{reason}");
}

/// Every component has every state, and no coordinate field comes before the end.
#[test]
fn brackets_that_grow_too_large_are_unknown_with_the_work_that_was_spent() {
    let n = 16;
    let names: Vec<String> = (1..=n).map(|i| format!("x{i}")).collect();
    let sum = |i: usize, k: usize| {
        let terms = (1..=n).map(|j| format!("{j}*x{j}^3*({} + x{i}*x{})^5", i + k, (i + j) % n + 1));
        terms.collect::<Vec<_>>().join(" + ")
    };
    let dynamics: Vec<String> = (1..=n).map(|i| format!("{} + ({})*u", sum(i, 1), sum(i, 20))).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
    let r = report(&system(&names, &["u"], &[], &dynamics, &[], None));
    let dimensions = &r.modes[0].dimensions;
    assert!(dimensions.reason.as_ref().unwrap().to_string().contains("nodes"), "{dimensions:?}");
    assert!(!r.decided());
}

/// Coordinate fields come one by one, so that no rank of a large matrix is taken.
#[test]
fn chains_of_many_states_are_decided() {
    let n = 200;
    let names: Vec<String> = (1..=n).map(|i| format!("x{i}")).collect();
    for link in ["x", "x + x^3"] {
        let mut dynamics = vec!["u".to_owned()];
        dynamics.extend(names[..n - 1].iter().map(|x| link.replace('x', x)));
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
        let r = report(&system(&names, &["u"], &[], &dynamics, &[], None));
        let dimensions = &r.modes[0].dimensions;
        assert_eq!(dimensions.strongly_accessible_dimension.known(), Some(&n), "{dimensions:?}");
        assert_eq!(dimensions.accessible_dimension.known(), Some(&n), "{dimensions:?}");
        assert_eq!(dimensions.strong_growth, (1..=n).collect::<Vec<_>>());
    }
}

/// x_i' = x_i u_i + x_{i+1} u_{i+1} on a ring: g_i = x_i (e_i + e_{i−1}), which span everything if n is odd, and all but the
/// alternating sum if n is even. No equation is tested against all pairs of inputs.
#[test]
fn systems_of_many_inputs_are_decided() {
    for (n, dimension) in [(30, 29), (31, 31)] {
        let names: Vec<String> = (0..n).map(|i| format!("x{i}")).collect();
        let inputs: Vec<String> = (0..n).map(|i| format!("u{i}")).collect();
        let rates: Vec<String> = (0..n).map(|i| [i, (i + 1) % n].map(|k| format!("x{k}*u{k}")).join(" + ")).collect();
        let [names, inputs, rates] =
            [&names, &inputs, &rates].map(|l| l.iter().map(String::as_str).collect::<Vec<_>>());
        let r = report(&system(&names, &inputs, &[], &rates, &[], None));
        let dimensions = &r.modes[0].dimensions;
        assert_eq!(dimensions.accessible_dimension.known(), Some(&dimension), "{dimensions:?}");
    }
}

/// Of very many states, dimensions alone are determined, and the rest is said to be unknown.
#[test]
fn the_dimensions_of_a_very_large_linear_system_are_decided() {
    let n = 5001;
    let names: Vec<String> = (1..=n).map(|i| format!("x{i}")).collect();
    for last in ["u", "x1"] {
        let mut dynamics: Vec<&str> = names[1..].iter().map(String::as_str).collect();
        dynamics.push(last);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let r = report(&system(&names, &["u"], &[], &dynamics, &[], None));
        let (dimensions, reached) = (&r.modes[0].dimensions, if last == "u" { n } else { 0 });
        assert_eq!(dimensions.strongly_accessible_dimension.known(), Some(&reached), "{last}");
        assert_eq!(dimensions.accessible_dimension.known(), Some(&reached.max(1)), "{last}");
        assert!(r.involutive.reason().unwrap().to_string().contains("5000 states"));
    }
}
