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
