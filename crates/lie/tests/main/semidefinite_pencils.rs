//! Systems with several inputs that second-order forms keep from small-time local controllability, with known answers.

use crate::common::system;
use crate::tier::cases;
use bracketry_lie::controllability::Verdict;
use bracketry_lie::{AnalysisOptions, analyze_affine};
use proptest::prelude::*;

/// Whether the system is STLC at the origin with bounded inputs, and whether feedback stabilizes it.
fn verdicts(states: &[&str], inputs: &[&str], dynamics: &[&str]) -> (Verdict, Option<bool>, String) {
    let system = system(states, inputs, &[], dynamics, &[], Some(&[]));
    let r = analyze_affine(&system, &AnalysisOptions::default()).unwrap().at_point.unwrap().known().unwrap().clone();
    (r.stlc.with_bounded_inputs(), r.stabilizable.unwrap().known().copied(), r.stlc.reason.to_string())
}

#[test]
fn a_square_among_two_forms() {
    let (stlc, stabilizable, why) = verdicts(&["x", "y", "z", "w"], &["u", "v"], &["u", "v", "x^2 - y^2", "x*y + x^2"]);
    assert_eq!((stlc, stabilizable), (Verdict::No, Some(false)), "{why}");
    // x² − y² and x y are the parts of (x + i y)²: no combination is semidefinite, and the system is STLC.
    let (stlc, _, why) = verdicts(&["x", "y", "z", "w"], &["u", "v"], &["u", "v", "x^2 - y^2", "x*y"]);
    assert_eq!(stlc, Verdict::Yes, "{why}");
}

proptest! {
    #![proptest_config(cases(4))]

    /// z' + k w' + … = (p x + q y)² (1 + c x) for a combination that the coordinates hide: Z = z + a w, W = w + b Z + d x².
    #[test]
    fn hidden_squares(p in -2_i64..3, q in -2_i64..3, r in -2_i64..3, s in -2_i64..3, a in -2_i64..3, b in -2_i64..3, c in -1_i64..2, d in -1_i64..2) {
        prop_assume!((p, q) != (0, 0));
        // Where the forms depend on each other, terms of degree 3 decide, and the answer may stay open.
        prop_assume!((p * p, 2 * p * q) != (r * q * q, s * q * q));
        let square = format!("(({p}*x + {q}*y)^2*(1 + {c}*x))");
        let other = format!("({r}*x^2 + {s}*x*y + y^2 + x^3)");
        let z = format!("{square} + {a}*{other}");
        let w = format!("{other} + {b}*({z}) + {d}*2*x*u");
        let (stlc, stabilizable, why) = verdicts(&["x", "y", "Z", "W"], &["u", "v"], &["u", "v", &z, &w]);
        prop_assert_eq!((stlc, stabilizable), (Verdict::No, Some(false)), "{}; {}: {}", z, w, why);
    }

    /// Three forms in three variables, one of which is a square to which multiples of the others are added.
    #[test]
    fn hidden_squares_among_three(p in -1_i64..2, q in -1_i64..2, a in -1_i64..2, b in -1_i64..2, k in 1_i64..3) {
        let square = format!("(x + {p}*y + {q}*z)^2");
        let (f, g) = ("(x*y - z^2)".to_owned(), format!("(y^2 - {k}*x*z)"));
        let first = format!("{square} + {a}*{f} + {b}*{g}");
        let dynamics = ["u", "v", "w", &first, &f, &g];
        let (stlc, stabilizable, why) = verdicts(&["x", "y", "z", "a", "b", "c"], &["u", "v", "w"], &dynamics);
        prop_assert_eq!((stlc, stabilizable), (Verdict::No, Some(false)), "{}: {}", first, why);
    }

    /// Two forms of two variables without common zero line: no combination is semidefinite if and only if all are indefinite, which
    /// the discriminant of the pencil tells. The answers never contradict it.
    #[test]
    fn pencils_of_two_forms(a in -2_i64..3, b in -2_i64..3, c in -2_i64..3, d in -2_i64..3, e in -2_i64..3, f in -2_i64..3) {
        // det(s Q + t P) = s² (a c − b²) + s t (a f + c d − 2 b e) + t² (d f − e²), Q = [a b; b c].
        let (q, m, p) = (a * c - b * b, a * f + c * d - 2 * b * e, d * f - e * e);
        let dynamics = [format!("{a}*x^2 + 2*{b}*x*y + {c}*y^2"), format!("{d}*x^2 + 2*{e}*x*y + {f}*y^2")];
        let (stlc, _, why) = verdicts(&["x", "y", "z", "w"], &["u", "v"], &["u", "v", &dynamics[0], &dynamics[1]]);
        // The greatest value of the determinant over all (s, t) is negative: indefinite together.
        let indefinite = q < 0 && 4 * q * p > m * m;
        let root = |x: i64| x >= 0 && (0..40).any(|k| k * k == x);
        if indefinite {
            prop_assert_ne!(stlc, Verdict::No, "{:?}: {}", dynamics, why);
        } else if m * m - 4 * q * p > 0 || root(m * m - 4 * q * p) {
            prop_assert_eq!(stlc, Verdict::No, "{:?}: {}", dynamics, why);
        }
    }
}
