//! What outputs tell about states and parameters, against answers of the literature.

use crate::common::{ratio, system};
use bracketry_lie::observability::{Direction, ObservabilityReport};
use bracketry_lie::{AnalysisOptions, Answer, Error, Evidence, Named, observe};

/// Analyzes `x' = dynamics` with generic-looking values of the parameters.
fn report_on(
    states: &str,
    inputs: &str,
    parameters: &str,
    dynamics: &[&str],
    outputs: &[&str],
    asked: &[&str],
) -> ObservabilityReport {
    let values: Vec<_> = parameters
        .split_whitespace()
        .enumerate()
        .map(|(i, n)| (n, ratio(13 + 10 * i as i64, 7 + 4 * i as i64)))
        .collect();
    let (states, inputs): (Vec<&str>, Vec<&str>) =
        (states.split_whitespace().collect(), inputs.split_whitespace().collect());
    let s = system(&states, &inputs, &values, dynamics, outputs, None);
    let options =
        AnalysisOptions { determined: asked.iter().map(|&t| t.to_owned()).collect(), ..AnalysisOptions::default() };
    observe(&s, &options, &mut Evidence::default()).unwrap().unwrap()
}

fn names(list: Option<&Named<bool>>, value: bool) -> Vec<&str> {
    list.iter().flat_map(|m| &m.0).filter(|v| v.1 == value).map(|v| v.0.as_str()).collect()
}

fn fields_of(list: &[Direction]) -> Vec<String> {
    list.iter().map(|d| d.field.to_string()).collect()
}

fn symmetries(list: &[Direction]) -> Vec<String> {
    list.iter().filter_map(|d| d.symmetry.as_ref()).map(ToString::to_string).collect()
}

const UNICYCLE: [&str; 3] = ["u1*cos(th)", "u1*sin(th)", "u2"];

#[test]
fn the_range_to_a_beacon_does_not_see_rotations_about_it() {
    for output in ["(x^2 + y^2)/2", "atan(y/x) - th"] {
        let r = report_on("x y th", "u1 u2", "", &UNICYCLE, &[output], &[]);
        assert_eq!(r.rank, Answer::Known(2));
        assert_eq!(r.unobservable, ["x", "y", "th"]);
        assert_eq!(fields_of(&r.unobservable_directions), ["-y ∂x + x ∂y + ∂th"]);
        assert_eq!(symmetries(&r.unobservable_directions), ["rotation in the x-y plane together with th"]);
    }
    let r = report_on("x y th", "u1 u2", "a b", &UNICYCLE, &["((x - a)^2 + (y - b)^2)/2"], &[]);
    assert_eq!(fields_of(&r.unobservable_directions), ["(b - y) ∂x + (x - a) ∂y + ∂th"]);
    assert_eq!(r.fix_to_identify, Some(vec!["a".into(), "b".into()]));
    assert_eq!(r.unidentifiable_directions.len(), 3);
}

#[test]
fn a_compass_sees_no_translation() {
    let r = report_on("x y th", "u1 u2", "", &UNICYCLE, &["th"], &[]);
    assert_eq!(symmetries(&r.unobservable_directions), ["translation along x", "translation along y"]);
}

/// Without maneuvers of the observer the range of a target cannot be told from its bearing (Nardone & Aidala 1981).
#[test]
fn bearings_alone_leave_the_scale_open_unless_the_observer_accelerates() {
    let still = report_on("x y vx vy", "", "", &["vx", "vy", "0", "0"], &["atan(y/x)"], &[]);
    assert_eq!(still.rank, Answer::Known(3));
    assert_eq!(symmetries(&still.unobservable_directions), ["scaling of x by s, y by s, vx by s, and vy by s"]);
    let moving = report_on("x y vx vy", "ax ay", "", &["vx", "vy", "ax", "ay"], &["atan(y/x)"], &[]);
    assert_eq!((moving.rank, moving.unobservable_directions), (Answer::Known(4), Vec::new()));
}

/// The model of glucose and insulin by Bolie (1961); the symmetry is that of Massonis & Villaverde 2020.
#[test]
fn the_scaling_symmetry_of_bolies_model_is_named() {
    let rates = ["p1*q1 - p2*q2 + delta", "p3*q2 + p4*q1"];
    let r = report_on("q1 q2", "delta", "p1 p2 p3 p4 Vp", &rates, &["q1/Vp"], &["p2*p4", "p2/p4"]);
    assert_eq!(names(r.identifiable.as_ref(), false), ["p2", "p4"]);
    assert_eq!(names(r.identifiable_states.as_ref(), false), ["q2"]);
    assert_eq!(fields_of(&r.unidentifiable_directions), ["q2 ∂q2 - p2 ∂p2 + p4 ∂p4"]);
    assert_eq!(symmetries(&r.unidentifiable_directions), ["scaling of q2 by s, p2 by s^(-1), and p4 by s"]);
    assert_eq!(r.fix_to_identify, Some(vec!["p2".into()]));
    assert_eq!(names(r.determined.as_ref(), true), ["p2*p4"]);
    assert_eq!(names(r.determined.as_ref(), false), ["p2/p4"]);
}

/// Bellman & Åström 1970: two compartments, input and output in the first, loss from the first.
#[test]
fn compartments() {
    let rates = ["-(a01 + a21)*x1 + a12*x2 + u", "a21*x1 - a12*x2"];
    let r = report_on("x1 x2", "u", "a01 a12 a21", &rates, &["x1"], &[]);
    assert_eq!(names(r.identifiable.as_ref(), true), ["a01", "a12", "a21"]);
    // With losses from both, of the four rates only three combinations appear in the transfer function.
    let rates = ["-(a01 + a21)*x1 + a12*x2 + u", "a21*x1 - (a12 + a02)*x2"];
    let r = report_on("x1 x2", "u", "a01 a02 a12 a21", &rates, &["x1"], &["a12*a21", "a01 + a21", "a02 + a12"]);
    assert_eq!(names(r.identifiable.as_ref(), false), ["a01", "a02", "a12", "a21"]);
    assert_eq!(names(r.determined.as_ref(), false), Vec::<&str>::new());
    assert_eq!(r.fix_to_identify.as_ref().map(Vec::len), Some(1));
    // Without an input the amplitude is unknown as well.
    assert_eq!(r.identifiable_without_inputs.map(|m| m.0.iter().any(|p| p.1)), Some(false));
}

/// Vajda, Godfrey & Rabitz 1989, second-order homogeneous system.
#[test]
fn vajdas_quadratic_system() {
    let rates = ["p1*x1^2 + p2*x1*x2 + u", "p3*x1^2 + p4*x1*x2"];
    let r = report_on("x1 x2", "u", "p1 p2 p3 p4", &rates, &["x1"], &["p2*p3"]);
    assert_eq!(names(r.identifiable.as_ref(), true), ["p1", "p4"]);
    assert_eq!(names(r.determined.as_ref(), true), ["p2*p3"]);
    assert_eq!(fields_of(&r.unidentifiable_directions), ["x2 ∂x2 - p2 ∂p2 + p3 ∂p3"]);
}

#[test]
fn epidemics_seen_through_an_unknown_reporting_rate() {
    let sir = ["-be*S*I", "be*S*I - ga*I", "ga*I"];
    let r = report_on("S I R", "", "be ga k", &sir, &["k*I"], &["be/k"]);
    assert_eq!(names(r.identifiable.as_ref(), true), ["ga"]);
    assert_eq!(names(r.determined.as_ref(), true), ["be/k"]);
    assert_eq!(fields_of(&r.unobservable_directions), ["∂R"]);
    let scaling = "scaling of S by s, I by s, be by s^(-1), and k by s^(-1)";
    assert_eq!(symmetries(&r.unidentifiable_directions), ["translation along R", scaling]);
    let seir = ["-be*S*I/N", "be*S*I/N - nu*E", "nu*E - ga*I"];
    let r = report_on("S E I", "", "be nu ga k N", &seir, &["k*I"], &[]);
    assert_eq!(names(r.identifiable.as_ref(), true), ["nu", "ga"]);
    assert_eq!(r.fix_to_identify.map(|l| l.len()), Some(2));
}

/// HIV dynamics (Perelson & Nelson 1999): with the viral load alone λ and p appear as a product (Xia & Moog 2003, Wu et al. 2008).
#[test]
fn the_viral_load_alone_leaves_production_rates_open() {
    let rates = ["lam - d*T - be*T*V", "be*T*V - del*I", "p*I - c*V"];
    let r = report_on("T I V", "", "lam d be del p c", &rates, &["V"], &["lam*p"]);
    assert_eq!(names(r.identifiable.as_ref(), false), ["lam", "p"]);
    assert_eq!(names(r.determined.as_ref(), true), ["lam*p"]);
    assert_eq!(names(r.identifiable_states.as_ref(), false), ["T", "I"]);
    let both = report_on("T I V", "", "lam d be del p c", &rates, &["V", "T"], &[]);
    assert_eq!(names(both.identifiable.as_ref(), false), Vec::<&str>::new());
    assert_eq!(both.fix_to_identify, None);
}

#[test]
fn an_enzyme_is_identified_from_its_substrate() {
    let r = report_on("S", "", "Vm Km", &["-Vm*S/(Km + S)"], &["S"], &[]);
    assert_eq!(names(r.identifiable.as_ref(), true), ["Vm", "Km"]);
    let r = report_on("S", "", "Vm Km k", &["-Vm*S/(Km + S)"], &["k*S"], &["Vm/Km"]);
    assert_eq!(names(r.identifiable.as_ref(), true), Vec::<&str>::new());
    assert_eq!(names(r.determined.as_ref(), true), ["Vm/Km"]);
}

#[test]
fn a_pendulum_and_a_motor() {
    let r = report_on("q w", "u", "m l g", &["w", "-g/l*sin(q) + u/(m*l^2)"], &["q"], &["g/l", "m*l^2", "g"]);
    assert_eq!(names(r.determined.as_ref(), true), ["g/l", "m*l^2"]);
    assert_eq!(symmetries(&r.unidentifiable_directions), ["scaling of m by s^2, l by s^(-1), and g by s^(-1)"]);
    // From voltage to angle three of the six parameters of a motor can be found.
    let motor = ["(u - R*i - Ke*w)/L", "(Kt*i - b*w)/J", "w"];
    let combinations = ["Kt/(L*J)", "R/L + b/J", "(R*b + Kt*Ke)/(L*J)"];
    let r = report_on("i w th", "u", "R L Ke Kt J b", &motor, &["th"], &combinations);
    assert_eq!(names(r.determined.as_ref(), true), combinations);
    assert_eq!(names(r.identifiable.as_ref(), true), Vec::<&str>::new());
    assert_eq!((r.unidentifiable_directions.len(), r.fix_to_identify.map(|l| l.len())), (3, Some(3)));
    // With the current measured the electrical side is known; torque scales with the inertia.
    let r = report_on("i w", "u", "R L Ke Kt J b", &motor[..2], &["w", "i"], &[]);
    assert_eq!(symmetries(&r.unidentifiable_directions), ["scaling of Kt by s, J by s, and b by s"]);
}

/// x' = −a x + sin(b u): the input is known, also where integrators in front of it would make it a state.
#[test]
fn inputs_that_enter_nonlinearly_are_known() {
    let r = report_on("x", "u", "a b", &["-a*x + sin(b*u)"], &["x"], &[]);
    assert_eq!(r.rank, Answer::Known(1));
    assert_eq!(names(r.identifiable.as_ref(), true), ["a", "b"]);
    assert_eq!(names(r.identifiable_without_inputs.as_ref(), false), ["b"]);
    let r = report_on("x", "u", "a b c", &["-a*x + c*u^2/b"], &["x"], &["c/b"]);
    assert_eq!(names(r.identifiable.as_ref(), true), ["a"]);
    assert_eq!(names(r.determined.as_ref(), true), ["c/b"]);
}

#[test]
fn a_function_that_cannot_be_read_is_an_error() {
    let s = system(&["x"], &[], &[("rate", ratio(1, 2))], &["-rate*x"], &["x"], None);
    let ask = |text: &str| {
        let options = AnalysisOptions { determined: vec![text.to_owned()], ..AnalysisOptions::default() };
        observe(&s, &options, &mut Evidence::default()).unwrap_err()
    };
    let Error::Function { text, problem } = ask("x*rat") else { panic!("a function that cannot be read") };
    assert_eq!(text, "x*rat");
    assert_eq!(problem, "`rat` is neither a state nor a parameter; did you mean `rate`?");
    assert!(matches!(ask("x*("), Error::Function { .. }));
}
