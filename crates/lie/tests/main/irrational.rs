//! Answers at points and with constants that are no rational numbers, where rounding looks like a sign.

use crate::common::system;
use bracketry_lie::controllability::{PointReport, Verdict};
use bracketry_lie::{AnalysisOptions, Answer, analyze_affine};
use proptest::prelude::*;

/// Functions that increase at 0 < x < 1, and points there at which their values are irrational.
const FUNCTIONS: &[&str] = &["sqrt(x)", "sin(x)", "exp(x)", "sqrt(1 + x^2)", "log(1 + x)", "x*sqrt(2)", "cos(1/3)*x^3"];
const POINTS: &[&str] = &["1/2", "2/7", "9/10", "1/3"];

fn known_at_point(states: &[&str], inputs: &[&str], dynamics: &[&str], point: &[(&str, &str)]) -> Option<PointReport> {
    let system = system(states, inputs, &[], dynamics, &[], Some(point));
    let report = analyze_affine(&system, &AnalysisOptions::default()).unwrap();
    report.at_point.and_then(|p| p.known().cloned())
}

fn at_point(states: &[&str], inputs: &[&str], dynamics: &[&str]) -> PointReport {
    known_at_point(states, inputs, dynamics, &[]).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// x' = u, y' = ± (g(x) − g(x0))^k: an even power moves y to one side, an odd power to both. The field lacks some of the roots.
    #[test]
    fn powers_of_differences_move_to_one_side_where_they_are_even(
        g in 0..FUNCTIONS.len(), p in 0..POINTS.len(), k in 2u32..6, negative: bool
    ) {
        let (g, p) = (FUNCTIONS[g], POINTS[p]);
        let value = g.replace("exp", "EXP").replace('x', &format!("({p})")).replace("EXP", "exp");
        let rate = format!("{}({g} - ({value}))^{k}", if negative { "-" } else { "" });
        let Some(r) = known_at_point(&["x", "y"], &["u"], &["u", &rate], &[("x", p)]) else { return Ok(()) };
        prop_assert_eq!(r.stlc.verdict == Verdict::No, k % 2 == 0, "{}: {}", rate, r.stlc.reason);
        prop_assert_ne!(r.stlc.verdict == Verdict::Yes, k % 2 == 0, "{}: {}", rate, r.stlc.reason);
    }

    /// x' = c (u + s x + k), y' = d (u + s x + k): d x − c y stays, an uncontrollable eigenvalue 0.
    #[test]
    fn a_combination_that_stays_does_not_decay(c in 0usize..4, d in 0usize..4, s in -2i64..3) {
        let constants = ["cos(1)", "sqrt(3)", "exp(1/2)", "sin(2/5)"];
        let pull = format!("(u + ({s})*x)");
        let rates = [c, (c + 1 + d % 3) % 4].map(|i| format!("{}*{pull}", constants[i]));
        let r = at_point(&["x", "y"], &["u"], &[&rates[0], &rates[1]]);
        prop_assert!(!matches!(r.stabilizable, Some(Answer::Known(true))), "{:?}: {:?}", rates, r.stabilizable_reason);
    }
}

/// A and B together: cos a and sin a are the same numbers in both.
#[test]
fn constants_are_the_same_in_every_matrix() {
    let free = ["cos(3/10)*(v + z) + z^2", "sin(3/10)*(v + z)", "u + z*cos(1/2)"];
    let r = at_point(&["x", "y", "z"], &["u", "v"], &free);
    assert_eq!(r.linear_controllability_rank, Some(2));
    assert_eq!(r.stlc.verdict, Verdict::No, "{}", r.stlc.reason);
    assert!(!matches!(r.stabilizable, Some(Answer::Known(true))));
    let q = "(x*sin(3/10) - y*cos(3/10))^2";
    let rates =
        [format!("cos(3/10)*(u + cos(1/2)) + sin(3/10)*{q}"), format!("sin(3/10)*(u + cos(1/2)) - cos(3/10)*{q}")];
    let r = at_point(&["x", "y"], &["u"], &[&rates[0], &rates[1]]);
    assert_eq!(r.dimensions.accessible_dimension, Answer::Known(1));
}

/// Numbers in which nearly all digits cancel, with their signs: (1 − cos x)/x² − 2/5 and the like at small x, log((10¹⁶ + 1)/10¹⁶)
/// 10¹⁶ − 9/10, e^(π√163) − 262537412640768744 + 10⁻¹² …
const CANCELING: &[(&str, bool)] = &[
    ("((1 - cos(1e-8))*1e16 - 2/5)", true),
    ("((exp(1e-9) - 1 - 1e-9)*1e18 - 2/5)", true),
    ("((exp(1e-9) - 1 - 1e-9)*1e18 - 3/5)", false),
    ("((log(1e16 + 1) - log(1e16))*1e16 - 9/10)", true),
    ("((cosh(1e-8) - 1)*2e16 - 11/10)", false),
    ("((atan(1e8) - atan(1e8 - 1))*1e16 - 9/10)", true),
    ("((exp(19) + 1)^2 - exp(38) - 2*exp(19) - 3/2)", false),
    ("(exp(pi*sqrt(163)) - 262537412640768744 + 1e-12)", true),
    ("(1e9*(sqrt(2)*sqrt(3) - sqrt(6)) - 1e-8*sqrt(2))", false),
];

#[test]
fn canceling_digits_change_no_sign() {
    for &(number, positive) in CANCELING {
        let r = at_point(&["x", "y"], &["u"], &["u", &format!("{number}*y")]);
        assert_eq!(r.stabilizable, Some(Answer::Known(!positive)), "{number}: {:?}", r.stabilizable_reason);
        let r = at_point(&["x", "y", "z"], &["u"], &["u", "z", &format!("-y + {number}*z")]);
        assert_ne!(r.stabilizable, Some(Answer::Known(positive)), "{number}: {:?}", r.stabilizable_reason);
        // x² − g y² takes both signs for g > 0 only.
        let r = at_point(&["x", "y", "z"], &["u", "v"], &["u", "v", &format!("x^2 - {number}*y^2")]);
        assert_ne!(r.stlc.verdict, if positive { Verdict::No } else { Verdict::Yes }, "{number}: {}", r.stlc.reason);
    }
}

/// a_i' = −√(i + 1) a_i, i = 1 … n, in coordinates that mix them: n different eigenvalues.
#[test]
fn many_simple_eigenvalues_are_told_apart() {
    for n in [4, 8, 14] {
        let names: Vec<String> = (1..=n).map(|i| format!("a{i}")).collect();
        // b_i = a_i + a_(i+1): b_i' = −√(i + 1) b_i + (√(i + 1) − √(i + 2)) (b_(i+1) − b_(i+2) + …).
        let mut rates = vec!["u".to_owned()];
        for i in 1..=n {
            let sign = |j: usize| if (j - i) % 2 == 1 { "+" } else { "-" };
            let rest: Vec<String> = (i + 1..=n).map(|j| format!("{}a{j}", sign(j))).collect();
            let rest = rest.concat();
            let rest = if rest.is_empty() { "0".to_owned() } else { rest };
            rates.push(format!("-sqrt({})*a{i} + (sqrt({}) - sqrt({}))*({rest})", i + 1, i + 1, i + 2));
        }
        let states: Vec<&str> = std::iter::once("x").chain(names.iter().map(String::as_str)).collect();
        let dynamics: Vec<&str> = rates.iter().map(String::as_str).collect();
        let r = at_point(&states, &["u"], &dynamics);
        assert_eq!(r.stabilizable, Some(Answer::Known(true)), "{n}");
        let modes = r.uncontrollable_modes.unwrap().known().unwrap().clone();
        assert_eq!(modes.len(), n, "{n}: {modes:?}");
        for (i, mode) in modes.iter().enumerate() {
            let expected = -((i + 2) as f64).sqrt();
            assert!((mode.re - expected).abs() < 1e-9 && mode.im == 0.0, "{n}: {mode:?} {expected}");
        }
    }
}

/// The angle of (0, 0) has no value, also where it is asked for at a point.
#[test]
fn angles_at_the_origin_have_no_value() {
    for rate in ["atan2(y, x)", "atan2(sin(x), x^2)", "atan2(y - sqrt(2)*x, 3*x)"] {
        let r = known_at_point(&["x", "y"], &["u"], &["u", rate], &[]);
        assert!(r.is_none_or(|r| r.stlc.verdict != Verdict::Yes), "{rate}");
    }
}
