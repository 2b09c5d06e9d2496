//! Local controllability of systems whose inputs have ranges, with answers known by construction.

use crate::common::system;
use bracketry_lie::controllability::{InputValues, Stlc, Verdict};
use bracketry_lie::{AnalysisOptions, analyze, analyze_affine};
use bracketry_system::System;
use proptest::prelude::*;

const FAR: f64 = f64::INFINITY;

fn stlc(states: &str, ranges: &[(&str, f64, f64)], dynamics: &[&str], at: &[(&str, &str)]) -> Stlc {
    let states: Vec<&str> = states.split(' ').collect();
    let inputs: Vec<&str> = ranges.iter().map(|r| r.0).collect();
    let s = system(&states, &inputs, &[], dynamics, &[], Some(at));
    let ranges = ranges.iter().map(|(n, a, b)| ((*n).to_owned(), InputValues::Between(*a, *b))).collect();
    let report = analyze_affine(&s, &AnalysisOptions { ranges, ..AnalysisOptions::default() }).unwrap();
    report.at_point.unwrap().known().unwrap().stlc.clone()
}

fn verdict(states: &str, ranges: &[(&str, f64, f64)], dynamics: &[&str]) -> Verdict {
    stlc(states, ranges, dynamics, &[]).verdict
}

const QUADROTOR: &[&str] = &[
    "a",
    "b",
    "c",
    "p + q*sin(r)*tan(s) + w*cos(r)*tan(s)",
    "q*cos(r) - w*sin(r)",
    "(q*sin(r) + w*cos(r))/cos(s)",
    "(f1 + f2 + f3 + f4)*(cos(r)*sin(s)*cos(t) + sin(r)*sin(t))",
    "(f1 + f2 + f3 + f4)*(cos(r)*sin(s)*sin(t) - sin(r)*cos(t))",
    "(f1 + f2 + f3 + f4)*cos(r)*cos(s) - 981/100",
    "f2 - f4",
    "f3 - f1",
    "f1 - f2 + f3 - f4 + p*q/10",
];

/// Four rotors hover if their thrusts together can exceed the weight; one of them alone cannot be missed.
#[test]
fn four_rotors_hover() {
    let hover = |most: f64| {
        let ranges = ["f1", "f2", "f3", "f4"].map(|f| (f, 0.0, most));
        stlc("x y z r s t a b c p q w", &ranges, QUADROTOR, &[])
    };
    assert_eq!(hover(5.0).verdict, Verdict::Yes);
    for weak in [2.4525, 2.0] {
        assert_eq!(hover(weak).verdict, Verdict::No, "{}", hover(weak).reason);
    }
}

#[test]
fn inputs_that_cannot_rest() {
    assert_eq!(verdict("x", &[("u", 1.0, 2.0)], &["u"]), Verdict::No);
    assert_eq!(verdict("x", &[("u", 1.0, FAR)], &["u"]), Verdict::No);
    assert_eq!(verdict("h v", &[("u", 0.0, 0.5)], &["v", "u - 1"]), Verdict::No);
    assert_eq!(verdict("h v", &[("u", 0.0, 1.0)], &["v", "u - 1"]), Verdict::No);
    assert_eq!(verdict("h v", &[("u", 0.0, 1.5)], &["v", "u - 1"]), Verdict::Yes);
    // The weight is irrational.
    assert_eq!(verdict("h v", &[("u", 0.0, 1.0)], &["v", "u - sqrt(2)"]), Verdict::No);
    assert_eq!(verdict("h v", &[("u", 0.0, 2.0)], &["v", "u - sqrt(2)"]), Verdict::Yes);
    // Decimal fractions are what they say: 0.3 holds 3/10 at the end of the range.
    assert_eq!(verdict("h v", &[("u", 0.0, 0.3)], &["v", "u - 3/10"]), Verdict::No);
}

/// y falls with x² and rises with v, which also a bounded v does; without a square against v it never falls.
#[test]
fn against_a_square() {
    let u = ("u", -1.0, 1.0);
    for most in [1.0, FAR] {
        let against = |dynamics: &[&str]| stlc("x y", &[u, ("v", 0.0, most)], dynamics, &[]);
        let found = against(&["u", "v - x^2"]);
        assert_eq!(found.verdict, Verdict::Yes, "{}", found.reason);
        assert!(found.reason.to_string().contains("the square of the integral of w2"), "{}", found.reason);
        assert_eq!(against(&["u", "v - 4*x^2"]).verdict, Verdict::Yes);
        assert_eq!(against(&["u", "v + x^2"]).verdict, Verdict::No);
        assert_eq!(against(&["u", "v + x^2 + x^4"]).verdict, Verdict::No);
    }
    let deep = stlc("x a y", &[u, ("v", 0.0, 1.0)], &["a", "u", "v - x^2"], &[]);
    assert_eq!(deep.verdict, Verdict::Yes, "{}", deep.reason);
    assert_eq!(verdict("x y", &[u, ("v", -1.0, 0.0)], &["u", "v + x^2"]), Verdict::Yes);
}

/// An input that pushes to one side without a bound can go around a circle and come back from the other side, which tests
/// near the point do not see.
#[test]
fn half_of_a_line_is_no_bound() {
    let ranges = [("v", 0.0, FAR), ("w", 0.0, FAR)];
    let found = stlc("x y", &ranges, &["v*(1 - y) + w", "v*x"], &[]);
    assert_ne!(found.verdict, Verdict::No, "{}", found.reason);
}

/// λ·f + the largest Σ λ·g_i u_i, for the normals λ of all edges of the polygon of velocities: the velocities have 0 in their
/// interior just where all are positive.
fn surrounds(drift: [i64; 2], thrusters: &[([i64; 2], [i64; 2])]) -> bool {
    let normals = thrusters.iter().filter(|t| t.0 != [0, 0]).flat_map(|([a, b], _)| [[-b, *a], [*b, -a]]);
    let normals: Vec<[i64; 2]> = normals.collect();
    let spans = normals.iter().any(|m| normals.iter().any(|n| m[0] * n[1] != m[1] * n[0]));
    let most = |l: &[i64; 2]| {
        let ends = thrusters.iter().map(|(g, [low, high])| {
            let slope = l[0] * g[0] + l[1] * g[1];
            (slope * low).max(slope * high)
        });
        l[0] * drift[0] + l[1] * drift[1] + ends.sum::<i64>()
    };
    spans && normals.iter().all(|l| most(l) > 0)
}

/// Direction and range.
type Thruster = ([i64; 2], [i64; 2]);

/// Thrusters of a body on a plane: each with its direction and its range, and a constant load.
fn thrusters() -> impl Strategy<Value = ([i64; 2], Vec<Thruster>)> {
    let one = (prop::array::uniform2(-3i64..4), -1i64..2, 1i64..4).prop_map(|(g, low, width)| (g, [low, low + width]));
    (prop::array::uniform2(-3i64..4), prop::collection::vec(one, 1..6))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// As velocities or as accelerations at rest, constant fields are STLC just where they have 0 in their interior.
    #[test]
    fn thrusters_on_a_plane((load, thrusters) in thrusters(), second in any::<bool>()) {
        let names: Vec<String> = (1..=thrusters.len()).map(|i| format!("u{i}")).collect();
        let rate = |c: usize| {
            let terms = names.iter().zip(&thrusters).map(|(u, (g, _))| format!(" + ({})*{u}", g[c]));
            format!("{}{}", load[c], terms.collect::<String>())
        };
        let rates = [rate(0), rate(1)];
        let dynamics: Vec<&str> = if second { vec!["v", "w", &rates[0], &rates[1]] } else { vec![&rates[0], &rates[1]] };
        let ranges: Vec<(&str, f64, f64)> =
            names.iter().zip(&thrusters).map(|(u, (_, [l, h]))| (u.as_str(), *l as f64, *h as f64)).collect();
        let found = stlc(if second { "x y v w" } else { "x y" }, &ranges, &dynamics, &[]);
        let truth = if surrounds(load, &thrusters) { Verdict::Yes } else { Verdict::No };
        prop_assert_eq!(found.verdict, truth, "{} {:?} {:?}", found.reason, load, thrusters);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    /// z' = a x_p² + b y_q², at the ends of chains of depths p and q: definite is no, indefinite yes.
    #[test]
    fn forms_across_depths(p in 1usize..3, q in 1usize..4, a in 1i64..5, b in 1i64..5, up in any::<bool>()) {
        let chain = |name: &str, input: &str, depth: usize| {
            let states: Vec<String> = (1..=depth).map(|k| format!("{name}{k}")).collect();
            let mut rates = states[1..].to_vec();
            rates.push(input.to_owned());
            (states, rates)
        };
        let ((mut states, mut dynamics), (more, rates)) = (chain("x", "u", p), chain("y", "v", q));
        states.extend(more);
        states.push("z".to_owned());
        dynamics.extend(rates);
        dynamics.push(format!("{a}*x1^2 {} {b}*y1^2", if up { "+" } else { "-" }));
        let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
        let found = stlc(&states.join(" "), &[("u", -1.0, 1.0), ("v", -1.0, 1.0)], &dynamics, &[]);
        let truth = if up { Verdict::No } else { Verdict::Yes };
        prop_assert_eq!(found.verdict, truth, "{}: {:?}", found.reason, dynamics);
    }

    /// Chains that drive odd functions, which x^3 and x^2 y make accessible.
    #[test]
    fn odd_systems(c in prop::collection::vec(-3i64..4, 8)) {
        let z = format!("x^3 + ({})*x*y^2 + ({})*y^3 + ({})*z^3 + ({})*sin(z)", c[0], c[1], c[2], c[3]);
        let w = format!("x^2*y + ({})*z^3 + ({})*w + ({})*z^5 + ({})*w*cos(y)", c[4], c[5], c[6], c[7]);
        let found = stlc("x y z w", &[("u", -1.0, 1.0)], &["u", "x", &z, &w], &[]);
        prop_assert_eq!(found.verdict, Verdict::Yes, "{}: {} {}", found.reason, z, w);
    }
}

/// New inputs w(u) whose values near w(0) need u far from 0: what small inputs do is not concluded from them.
#[test]
fn values_of_new_inputs_may_be_far_away() {
    let judge = |w: &str| {
        let text = format!("states = ['x']\ninputs = ['u']\ndynamics = {{ x = '{w}' }}\n[point]\nx = 0\n");
        let system = System::parse("m", &text).unwrap();
        let report = analyze(&system, &AnalysisOptions::default()).unwrap().report;
        report.at_point.unwrap().known().unwrap().clone()
    };
    for (w, near) in [
        ("u^2 - 3*u^4", false),
        ("u^3 - u^2", false),
        ("1 - cos(u) - u^2/4", false),
        ("exp(u) - 1 - u - u^2", false),
        ("u^3", true),
        ("u + u^2", true),
    ] {
        let p = judge(w);
        assert_eq!(p.stlc.verdict, Verdict::Yes, "{w}");
        assert_eq!(p.stlc.with_bounded_inputs() == Verdict::Yes, near, "{w}: {:?}", p.stlc);
        assert_eq!(p.brockett_condition.unwrap().known() == Some(&true), near, "{w}");
    }
}

/// What holds at the point of a model file in general inputs.
fn of_model(text: &str) -> Option<bracketry_lie::controllability::PointReport> {
    let analysis = analyze(&System::parse("model.toml", text).unwrap(), &AnalysisOptions::default()).unwrap();
    analysis.report.at_point.unwrap().known().cloned()
}

/// The sign of a constant is a number, not a switch: terms with it cancel or stay, whatever the constant is.
#[test]
fn signs_of_constants_are_numbers() {
    for constant in ["2", "sqrt(2)", "pi/2", "1 + sin(1)", "exp(1/3)"] {
        for kink in ["abs(u - 1/3)", "-abs(u - 1/3)*(u - 1/3)"] {
            for (switch, value) in [("sign(u - C)", "sign(1/3 - C)"), ("max(u, C)", "max(1/3, C)")] {
                let rate = format!("{switch} - {value} + 2*(u - 1/3) + {kink}").replace('C', &format!("({constant})"));
                let text = format!(
                    "states = ['x']\ninputs = ['u']\ndynamics = {{ x = \"{rate}\" }}\nranges = {{ u = {{ min = -2, max = 3 }} }}\n\
                     [point]\nu = '1/3'\n"
                );
                // x' takes both signs beside u = 1/3.
                let verdict = of_model(&text).map(|r| r.stlc.verdict);
                assert_ne!(verdict, Some(Verdict::No), "{rate}");
            }
        }
    }
}

/// Inputs in switching functions jump to other modes: what one mode excludes, others may do.
#[test]
fn other_modes_of_the_inputs_are_not_excluded() {
    for (states, ranges, dynamics, point) in [
        // v = 1 holds the same state, and its linearization is controllable.
        ("'y', 'z'", "v = { min = -2, max = 2 }", "y = 'max(v, 0)*(v - 1)', z = 'sin(y) + v^3 - v'", "v = -1"),
        // 0 is inside the convex hull of the velocities.
        ("'x', 'y'", "u = { min = -9, max = 9 }", "x = 'u + u^2', y = 'max(u - 1, 0) - max(-u - 1, 0)'", "u = 0"),
        ("'x', 'y'", "u = { min = -9, max = 9 }", "x = 'u', y = 'sign(u - 1) + sign(u + 1)'", "u = 0"),
        ("'x', 'y'", "u = { min = -2, max = 2 }", "x = '1/9 - min(u, u^2)', y = 'abs(u)*u - 1/9'", "u = '1/3'"),
    ] {
        let input = if dynamics.contains('v') { "v" } else { "u" };
        let text = format!(
            "states = [{states}]\ninputs = ['{input}']\ndynamics = {{ {dynamics} }}\nranges = {{ {ranges} }}\n[point]\n{point}\n"
        );
        let r = of_model(&text).unwrap();
        let denied = |answer: &Option<bracketry_lie::Answer<bool>>| answer.as_ref().and_then(|a| a.known().copied());
        assert_ne!(denied(&r.stabilizable), Some(false), "{dynamics}: {:?}", r.stabilizable_reason);
        assert_ne!(denied(&r.brockett_condition), Some(false), "{dynamics}");
        // The ranges are finite: there are no other bounds to speak of.
        assert!(r.stlc.bounded.is_none() && r.stlc.verdict != Verdict::No, "{dynamics}: {:?}", r.stlc);
    }
}
