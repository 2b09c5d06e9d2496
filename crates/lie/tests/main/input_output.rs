//! Relative degree, decoupling matrix, zero dynamics and static feedback linearization of systems from textbooks.

use crate::common::{ratio, shown, system};
use bracketry_lie::feedback::{ControlReport, LinearizationReport, ZeroDynamicsReport};
use bracketry_lie::{AnalysisOptions, Answer, Report, analyze_affine};
use bracketry_symbolic::{Bindings, Rational};
use bracketry_system::System;

fn report(s: &System) -> Report {
    analyze_affine(s, &AnalysisOptions::default()).unwrap()
}

fn control(s: &System) -> ControlReport {
    report(s).control
}

fn degrees(c: &ControlReport) -> Vec<Option<usize>> {
    c.input_output.as_ref().unwrap().relative_degree.known().unwrap().clone()
}

fn zero_dynamics(c: &ControlReport) -> &ZeroDynamicsReport {
    c.input_output.as_ref().unwrap().zero_dynamics.as_ref().unwrap().known().unwrap()
}

fn linearization(c: &ControlReport) -> &LinearizationReport {
    c.feedback_linearization.as_ref().unwrap()
}

/// Whether two texts are the same function.
fn same(s: &System, a: &str, b: &str) -> bool {
    let mut pool = s.pool.clone();
    let (a, b) = (pool.parse(a).unwrap(), pool.parse(b).unwrap());
    let difference = pool.sub(a, b);
    pool.zero_test(difference, &Bindings::new()).is_zero()
}

/// Hauser, Sastry & Meyer 1992.
fn vtol(eps: (i64, i64), outputs: &[&str]) -> System {
    system(
        &["x", "y", "th", "vx", "vy", "w"],
        &["u1", "u2"],
        &[("gr", ratio(981, 100)), ("ep", ratio(eps.0, eps.1))],
        &["vx", "vy", "w", "-sin(th)*u1 + ep*cos(th)*u2", "cos(th)*u1 + ep*sin(th)*u2 - gr", "u2"],
        outputs,
        None,
    )
}

#[test]
fn a_vtol_aircraft_held_in_place_rolls_over() {
    let s = vtol((1, 2), &["x", "y"]);
    let c = control(&s);
    let io = c.input_output.as_ref().unwrap();
    assert_eq!(degrees(&c), [Some(2), Some(2)]);
    assert_eq!(io.decoupling_determinant.as_ref().unwrap().to_string(), "-ep");
    assert_eq!(io.singular_set.as_ref().unwrap().to_string(), "none");
    assert_eq!(io.vector_relative_degree, Some(true));
    let z = zero_dynamics(&c);
    assert_eq!(z.states, ["th", "w"]);
    assert_eq!(z.equations, ["w", "gr*sin(th)/ep"]);
    assert_eq!(z.minimum_phase, Answer::Known(false));
    let largest = z.eigenvalues.iter().map(|e| e.re).fold(0.0, f64::max);
    assert!((largest - (2.0 * 9.81f64).sqrt()).abs() < 1e-12);
}

#[test]
fn the_decoupling_feedback_inverts_the_decoupling_matrix() {
    let s = vtol((1, 2), &["x", "y"]);
    let c = control(&s);
    let u = &c.input_output.as_ref().unwrap().decoupling_feedback.as_ref().unwrap().0;
    let acceleration = ["-sin(th)*(U1) + ep*cos(th)*(U2)", "cos(th)*(U1) + ep*sin(th)*(U2) - gr"];
    for (a, v) in acceleration.iter().zip(["v1", "v2"]) {
        assert!(same(&s, &a.replace("U1", &u[0].1.to_string()).replace("U2", &u[1].1.to_string()), v), "{u:?}");
    }
}

#[test]
fn without_coupling_the_vtol_aircraft_has_no_vector_relative_degree() {
    let s = system(
        &["x", "y", "th", "vx", "vy", "w"],
        &["u1", "u2"],
        &[],
        &["vx", "vy", "w", "-sin(th)*u1", "cos(th)*u1 - 1", "u2"],
        &["x", "y"],
        None,
    );
    let io = control(&s).input_output.unwrap();
    assert_eq!(io.decoupling_rank, Some(1));
    assert_eq!(io.vector_relative_degree, Some(false));
    assert_eq!(io.decoupling_determinant.as_ref().unwrap().to_string(), "0");
}

#[test]
fn an_output_that_no_input_reaches_has_no_relative_degree() {
    let s = system(&["x", "y", "z"], &["u"], &[], &["u", "x", "-z + z^2"], &["z", "y"], None);
    let c = control(&s);
    assert_eq!(degrees(&c), [None, Some(2)]);
    assert_eq!(c.input_output.unwrap().decoupling_matrix, [["0"], ["1"]]);
}

#[test]
fn an_output_with_feedthrough_is_left_out() {
    let s = system(&["x", "v"], &["u"], &[], &["v", "u"], &["x + u"], None);
    let c = control(&s);
    assert_eq!(c.input_output, None);
    assert_eq!(linearization(&c).linearizing_outputs, ["x"]);
}

fn ball_and_beam(point: Option<&[(&str, &str)]>) -> System {
    system(
        &["r", "v", "th", "w"],
        &["u1"],
        &[("B", ratio(5, 7)), ("G", ratio(981, 100))],
        &["v", "B*(r*w^2 - G*sin(th))", "w", "u1"],
        &["r"],
        point,
    )
}

#[test]
fn the_relative_degree_of_ball_and_beam_is_not_defined_at_rest() {
    let defined = |point: &[(&str, &str)]| {
        let r = report(&ball_and_beam(Some(point)));
        r.at_point.as_ref().and_then(Answer::known).unwrap().relative_degree_defined.clone().unwrap()
    };
    assert_eq!(defined(&[]), Answer::Known(false));
    assert_eq!(defined(&[("r", "1")]), Answer::Known(false));
    assert_eq!(defined(&[("r", "1"), ("w", "2")]), Answer::Known(true));
    let io = control(&ball_and_beam(None)).input_output.unwrap();
    assert_eq!(io.decoupling_matrix, [["2*B*r*w"]]);
    assert_eq!(io.singular_set.as_ref().unwrap().to_string(), "r = 0 or w = 0");
}

#[test]
fn a_denominator_that_vanishes_at_the_point_leaves_it_open() {
    let s = system(&["x", "v"], &["u"], &[], &["v", "u/x"], &["x"], Some(&[]));
    let r = report(&s);
    let defined = r.at_point.as_ref().and_then(Answer::known).and_then(|p| p.relative_degree_defined.clone());
    assert!(!matches!(defined, Some(Answer::Known(_))), "{defined:?}");
}

/// x1' = a sin x2, x2' = −x1² + u (Khalil 2002, sec. 13.1).
#[test]
fn khalil_sine() {
    let s = system(&["x1", "x2"], &["u"], &[("a", ratio(2, 1))], &["a*sin(x2)", "-x1^2 + u"], &["x1"], None);
    let c = control(&s);
    let io = c.input_output.as_ref().unwrap();
    assert_eq!(io.decoupling_determinant.as_ref().unwrap().to_string(), "a*cos(x2)");
    assert_eq!(io.singular_set.as_ref().unwrap().to_string(), "cos(x2) = 0");
    assert_eq!(zero_dynamics(&c).dimension, 0);
    let l = linearization(&c);
    assert_eq!((l.dims.as_slice(), l.linearizing_outputs[0].to_string().as_str()), ([1, 2].as_slice(), "x1"));
    assert!(same(&s, &l.feedback.as_ref().unwrap().0[0].1.to_string(), "x1^2 + v1/(a*cos(x2))"));
}

/// Isidori 1995, ex. 4.1.5 (controlled Van der Pol) and the field-controlled DC motor (Khalil 2002, ex. 13.8).
#[test]
fn field_controlled_dc_motor() {
    let constants =
        [("a", ratio(2, 1)), ("b", ratio(3, 1)), ("k", ratio(5, 1)), ("c", ratio(7, 1)), ("t", ratio(11, 1))];
    let f = ["-a*x1 + u", "-b*x2 + k - c*x1*x3", "t*x1*x2"];
    let s = system(&["x1", "x2", "x3"], &["u"], &constants, &f, &["x3"], Some(&[("x2", "k/b")]));
    let c = control(&s);
    assert_eq!(degrees(&c), [Some(2)]);
    assert_eq!(c.input_output.as_ref().unwrap().singular_set.as_ref().unwrap().to_string(), "x2 = 0");
    let z = zero_dynamics(&c);
    assert_eq!((z.states.join(", "), shown(&z.equations).join(", ")), ("x2".to_owned(), "k - b*x2".to_owned()));
    assert_eq!(z.minimum_phase, Answer::Known(true));
    // h = t x2² + c x3² linearizes.
    let l = linearization(&c);
    assert_eq!(l.dims, [1, 2, 3]);
    assert_eq!(l.linearizing_outputs, ["c*x3^2 + t*x2^2"]);
}

#[test]
fn stable_and_unstable_linear_zeros() {
    // y = (s + z)/(s² + 2 s + 3) u
    let with_zero = |z: i64| {
        let s = system(
            &["x1", "x2"],
            &["u"],
            &[("z", Rational::from(z))],
            &["x2", "-3*x1 - 2*x2 + u"],
            &["z*x1 + x2"],
            None,
        );
        let c = control(&s);
        assert_eq!(degrees(&c), [Some(1)]);
        let zero = zero_dynamics(&c);
        assert_eq!(zero.eigenvalues[0].re, -z as f64);
        zero.minimum_phase.clone()
    };
    assert_eq!(with_zero(4), Answer::Known(true));
    assert_eq!(with_zero(-4), Answer::Known(false));
}

#[test]
fn higher_order_terms_decide_on_scalar_zero_dynamics() {
    let verdict = |equation: &str| {
        let s = system(&["y", "z"], &["u"], &[], &["u", equation], &["y"], None);
        zero_dynamics(&control(&s)).minimum_phase.clone()
    };
    assert_eq!(verdict("-z^3 + y"), Answer::Known(true));
    assert_eq!(verdict("z^3 + y"), Answer::Known(false));
    assert_eq!(verdict("-z^2 + y"), Answer::Known(false));
    assert_eq!(verdict("y"), Answer::Known(false));
}

#[test]
fn an_oscillating_zero_dynamics_is_not_judged_by_its_linearization() {
    let s = system(&["y", "p", "q"], &["u"], &[], &["u", "q", "-p - q^3 + y"], &["y"], None);
    let c = control(&s);
    // p'' + p'^3 + p = 0 loses energy, which the linearization does not show.
    assert_eq!(zero_dynamics(&c).minimum_phase, Answer::Known(true));
}

#[test]
fn outputs_that_leave_an_input_free() {
    let s = system(&["x", "y", "th"], &["u1", "u2"], &[], &["u1*cos(th)", "u1*sin(th)", "u2"], &["x", "y"], None);
    let c = control(&s);
    assert_eq!((degrees(&c), c.input_output.as_ref().unwrap().decoupling_rank), (vec![Some(1), Some(1)], Some(1)));
    let z = zero_dynamics(&c);
    assert_eq!((z.states.join(", "), shown(&z.equations).join(", ")), ("th".to_owned(), "u2".to_owned()));
    assert_eq!(
        z.inputs.0.iter().map(|(u, e)| (u.as_str(), e.to_string())).collect::<Vec<_>>(),
        [("u1", "0".to_owned())]
    );
    assert!(matches!(z.minimum_phase, Answer::Unknown(_)));
}

#[test]
fn the_zero_dynamics_of_a_tank_are_those_at_its_point() {
    // The level is held at its value at the point, not at zero.
    let s = system(&["h", "T"], &["q"], &[], &["q - sqrt(h)", "q*(5 - T)/h"], &["h"], Some(&[("h", "4"), ("T", "5")]));
    let c = control(&s);
    let z = zero_dynamics(&c);
    assert_eq!(
        z.held_at.0.iter().map(|(u, e)| (u.as_str(), e.to_string())).collect::<Vec<_>>(),
        [("h", "4".to_owned())]
    );
    assert!(same(&s, &z.equations[0].to_string(), "(5 - T)/2"), "{:?}", z.equations);
    assert_eq!(z.minimum_phase, Answer::Known(true));
}

/// Isidori 1995, sec. 6.1: without a vector relative degree the algorithm goes on with new constraints.
#[test]
fn zero_dynamics_without_vector_relative_degree() {
    let f = ["u1", "x4 + x3*u1", "-x3 + x4", "u2"];
    let s = system(&["x1", "x2", "x3", "x4"], &["u1", "u2"], &[], &f, &["x1", "x2"], None);
    let c = control(&s);
    assert_eq!(c.input_output.as_ref().unwrap().vector_relative_degree, Some(false));
    let z = zero_dynamics(&c);
    assert_eq!((z.states.join(", "), shown(&z.equations).join(", ")), ("x3".to_owned(), "-x3".to_owned()));
    assert_eq!(z.minimum_phase, Answer::Known(true));
}

#[test]
fn dimensions_go_on_after_a_distribution_that_is_not_involutive() {
    let s = system(&["x1", "x2", "x3"], &["u"], &[], &["x2 + x3^2", "x3", "u"], &[], None);
    let c = control(&s);
    assert_eq!(linearization(&c).dims, [1, 2, 3]);
    assert_eq!(linearization(&c).involutive, [true, false, true]);
}

#[test]
fn linearizing_outputs_of_a_multi_input_system() {
    // Chains of 3 and 1: x3 is the output with relative degree 3.
    let f = ["u1", "x1 + x1^3", "x2 + x2^2", "u2 + x1*x3"];
    let s = system(&["x1", "x2", "x3", "x4"], &["u1", "u2"], &[], &f, &[], None);
    let c = control(&s);
    let l = linearization(&c);
    assert_eq!(l.controllability_indices, [3, 1]);
    assert_eq!(l.linearizing_outputs[0], "x3");
    assert_eq!(l.coordinates[0].len(), 3);
    assert_eq!(l.singular_set.as_ref().unwrap().to_string(), "2*x2 + 1 = 0");
}
