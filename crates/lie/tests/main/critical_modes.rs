//! Whether feedback stabilizes an equilibrium with uncontrollable modes on the imaginary axis: families with known answers.

use crate::common::{elementary, system};
use crate::tier::cases;
use bracketry_lie::reason::StabilizableReason;
use bracketry_lie::{AnalysisOptions, Answer, analyze_affine};
use proptest::prelude::*;

fn verdict(states: &[&str], inputs: &[&str], dynamics: &[&str]) -> (Option<bool>, StabilizableReason) {
    let system = system(states, inputs, &[], dynamics, &[], Some(&[]));
    let r = analyze_affine(&system, &AnalysisOptions::default()).unwrap().at_point.unwrap().known().unwrap().clone();
    let (answer, why) = (r.stabilizable.unwrap().known().copied(), r.stabilizable_reason.unwrap());
    if answer == Some(true) {
        // The feedback is continuous, which needs Brockett's condition.
        assert_eq!(r.brockett_condition.unwrap().known(), Some(&true), "{dynamics:?}: {why}");
    }
    (answer, why)
}

/// The verdict on s_i' = `dynamics` in the coordinates Z = T s, where T is a product of elementary matrices.
fn hidden(inputs: &[&str], dynamics: &[String], mixing: &[(usize, usize, i64)]) -> Option<bool> {
    let n = dynamics.len();
    let (to, back) = elementary(n, mixing);
    let sum = |row: &[i64], of: &dyn Fn(usize) -> String| {
        let terms: Vec<String> = (0..n).filter(|&j| row[j] != 0).map(|j| format!("({})*({})", row[j], of(j))).collect();
        format!("({})", terms.join(" + "))
    };
    let old: Vec<String> = back.iter().map(|row| sum(row, &|j| format!("Z{j}"))).collect();
    let moved: Vec<String> = dynamics
        .iter()
        .map(|f| old.iter().enumerate().fold(f.clone(), |f, (i, x)| f.replace(&format!("s{i}"), x)))
        .collect();
    let rates: Vec<String> = to.iter().map(|row| sum(row, &|j| moved[j].clone())).collect();
    let names: Vec<String> = (0..n).map(|i| format!("Z{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let rates: Vec<&str> = rates.iter().map(String::as_str).collect();
    verdict(&names, inputs, &rates).0
}

/// s0' = u, s1' = h, in coordinates with s1 + a s0² in place of s1.
fn bent(h: &str, a: i64) -> Vec<String> {
    let h = h.replace("s1", &format!("(s1 - {a}*s0^2)"));
    vec!["u".to_owned(), format!("{h} + {}*s0*u", 2 * a)]
}

/// s0 at the end of a chain of integrators before s_k' = h(s0, s_k) with s1 in h for s_k.
fn behind_integrators(h: &str, integrators: usize) -> Vec<String> {
    let mut list: Vec<String> = (1..integrators).map(|i| format!("s{i}")).collect();
    list.push("u".to_owned());
    list.push(h.replace("s1", &format!("s{integrators}")));
    list
}

#[test]
fn signs_in_the_plane() {
    for (h, expected) in [
        ("x*y", true),
        ("x*y + y^2", true),
        ("-x^2*y", true),
        ("y^3 - x^2*y", true),
        ("y + x^2", false),
        ("y - x^2", false),
        ("x^2*y", false),
        ("y^3 + x^2", false),
        ("y^2 - x^3*y", true),
        ("sin(y)*x^2", false),
        ("-sin(y)*x^2", true),
        ("exp(y) - 1 + x^2", false),
    ] {
        let (found, why) = verdict(&["x", "y"], &["u"], &["u", h]);
        assert_eq!(found, Some(expected), "{h}: {why}");
    }
    let (_, why) = verdict(&["x", "y"], &["u"], &["u", "x^2*y"]);
    let expected = "where y is above its value at the point, it cannot decrease near the point for any inputs";
    assert_eq!(why.to_string(), expected);
    let (_, why) = verdict(&["x", "v", "y"], &["u"], &["v", "u", "x*y"]);
    assert!(matches!(why, StabilizableReason::CriticalMode { .. }), "{why}");
}

fn nonzero() -> impl Strategy<Value = i64> {
    (-3_i64..4).prop_filter("not zero", |c| *c != 0)
}

proptest! {
    #![proptest_config(cases(1))]

    /// h = a x y + b y² + …: x = κ |y| gives any sign. The terms of degree 3 change nothing.
    #[test]
    fn products_are_stabilized(a in nonzero(), b in -3_i64..4, c in -3_i64..4, d in -3_i64..4, bend in -2_i64..3, t in -2_i64..3, k in 1_usize..4) {
        let h = format!("({a}*s0*s1 + {b}*s1^2 + {c}*s0^2*s1 + {d}*s1^3)");
        prop_assert_eq!(hidden(&["u"], &bent(&h, bend), &[(0, 1, t), (1, 0, 1)]), Some(true), "{}", h);
        prop_assert_eq!(hidden(&["u"], &behind_integrators(&h, k), &[(0, k, t), (k, 0, 1)]), Some(true), "{} behind {}", h, k);
    }

    /// h = b y³ + c x y² − a x² y + …, a ≠ 0: x = κ y with a large κ decides by the sign of a, or by that of a form that has both.
    #[test]
    fn cubic_forms_are_stabilized_where_they_fall(a in 1_i64..4, b in -3_i64..4, c in -3_i64..4, d in -3_i64..4, bend in -2_i64..3, t in -2_i64..3, k in 1_usize..4) {
        let h = format!("({b}*s1^3 + {c}*s0*s1^2 - {a}*s0^2*s1 + {d}*s0^3*s1 + {c}*s1^4)");
        prop_assert_eq!(hidden(&["u"], &bent(&h, bend), &[(0, 1, t), (1, 0, 1)]), Some(true), "{}", h);
        prop_assert_eq!(hidden(&["u"], &behind_integrators(&h, k), &[(0, k, t), (k, 0, 1)]), Some(true), "{} behind {}", h, k);
        // −h rises above y = 0 unless the form b y² + c x y − a x² takes positive values, which −h makes negative.
        let opposite = format!("(-1)*{h}");
        let indefinite = c * c + 4 * a * b > 0;
        let definite = c * c + 4 * a * b < 0;
        let found = hidden(&["u"], &bent(&opposite, bend), &[(0, 1, t)]);
        if indefinite || definite {
            prop_assert_eq!(found, Some(indefinite), "{}", opposite);
        }
    }

    /// h = ± y^j + p x² + …, with weights 2 for y and j for x, and terms of higher weight: y does not come back from the side to which
    /// x² drives it. With −y^j and an odd j, it does.
    #[test]
    fn squares_drive_away(j in 1_u32..4, p in nonzero(), c in -3_i64..4, d in -3_i64..4, e in -3_i64..4, bend in -2_i64..3, t in -2_i64..3, k in 1_usize..3) {
        let sign = if p > 0 || j % 2 == 0 { p.signum() } else { 1 };
        let h = format!("({sign}*s1^{j} + {p}*s0^2 + {c}*s0^3 + {d}*s0*s1^{j} + {e}*s1^{})", j + 1);
        prop_assert_eq!(hidden(&["u"], &bent(&h, bend), &[(0, 1, t), (1, 0, 1)]), Some(false), "{}", h);
        prop_assert_eq!(hidden(&["u"], &behind_integrators(&h, k), &[(0, k, t), (k, 0, 1)]), Some(false), "{} behind {}", h, k);
    }

    /// h = a x² y (1 + …) + e y^k: whether y comes back is decided by e where x² y drives away.
    #[test]
    fn powers_of_the_mode_decide_beside_squares(a in 1_i64..4, c in -3_i64..4, d in -3_i64..4, e in nonzero(), k in 3_u32..6, bend in -2_i64..3, t in -2_i64..3) {
        let h = format!("({a}*s0^2*s1*(1 + {c}*s0 + {d}*s1) + {e}*s1^{k})");
        let expected = e < 0 && k % 2 == 1;
        prop_assert_eq!(hidden(&["u"], &bent(&h, bend), &[(0, 1, t), (1, 0, 1)]), Some(expected), "{}", h);
        prop_assert_eq!(hidden(&["u"], &behind_integrators(&h, 2), &[(0, 2, t), (2, 0, 1)]), Some(expected), "{} behind 2", h);
    }

    /// A decaying state z' = −b z + c y² in y' = a z y + x z + d y³ − x y³ moves y by a c/b + d in total.
    #[test]
    fn decaying_states_add_to_the_rate(a in nonzero(), b in 1_i64..4, c in nonzero(), d in -3_i64..4, t in -2_i64..3) {
        let dynamics = ["u".to_owned(), format!("{a}*s1*s2 + {d}*s1^3 - s1^3*s0"), format!("-{b}*s2 + {c}*s1^2 + s0*s2")];
        let total = a * c + b * d;
        let found = hidden(&["u"], &dynamics, &[(0, 1, t), (2, 1, 1), (1, 0, 1)]);
        if total < 0 {
            prop_assert_eq!(found, Some(true));
        } else if total > 0 {
            // Not stabilized by what is known here; no answer must be wrong.
            prop_assert_ne!(found, Some(true));
        }
    }

    /// Two inputs: y' = a x y + b q³ y − y x²: a ≠ 0 decides alone; else −x² y does, or its sign is that of no input.
    #[test]
    fn several_inputs(a in -2_i64..3, b in -2_i64..3, p in nonzero(), t in -2_i64..3) {
        let dynamics = ["u + s1*s2".to_owned(), "w".to_owned(), format!("{a}*s0*s2 + {b}*s1^3*s2 + {p}*s2*s0^2")];
        let found = hidden(&["u", "w"], &dynamics, &[(0, 2, t), (2, 1, 1)]);
        let expected = a != 0 || b != 0 || p < 0;
        prop_assert_eq!(found, Some(expected));
    }
}

/// y' = y − x⁴ is driven away where y < 0, y' = −y − x⁴ decays, and y' = x² − y² has an answer on one side only.
#[test]
fn near_misses() {
    assert_eq!(verdict(&["x", "y"], &["u"], &["u", "y - x^4"]).0, Some(false));
    assert_eq!(verdict(&["x", "y"], &["u"], &["u", "-y - x^4"]).0, Some(true));
    assert_eq!(verdict(&["x", "y"], &["u"], &["u", "x^2 - y^2"]).0, Some(true));
    assert_eq!(verdict(&["x", "y"], &["u"], &["u", "x^2 + x*y + y^2"]).0, Some(false));
    // (x − y²)² is not negative; the Lipschitz curves see only its leading part.
    assert_eq!(verdict(&["x", "v", "y"], &["u"], &["v", "u", "(x - y^2)^2"]).0, Some(false));
    // A part that no series shows: exp(−1/x²) is not analytic.
    assert_ne!(verdict(&["x", "v", "y"], &["u"], &["v", "u", "y*abs(x)"]).0, Some(true));
}

proptest! {
    #![proptest_config(cases(1))]

    /// s1' = s2, s2' = −k s1 + …: an input behind integrators that acts on the amplitude by a s0 s2 or a s0 s1 stabilizes, whatever the
    /// terms of degree 3. Without it, s0² s2 only adds to c (k s1² + s2²) s2 where b > 0.
    #[test]
    fn oscillating_pairs(k in 1_i64..4, a in nonzero(), b in 1_i64..3, c in nonzero(), which in 1_usize..3, chain in 0_usize..2, t in -2_i64..3) {
        let cubic = format!("{c}*({k}*s1^2 + s2^2)*s2 + {b}*s0^2*s2");
        let mut acted = vec!["u".to_owned(), "s2".to_owned(), format!("-{k}*s1 + {a}*s0*s{which} + {cubic}")];
        let mut alone = vec!["u".to_owned(), "s2".to_owned(), format!("-{k}*s1 + {cubic}")];
        if chain == 1 {
            for list in [&mut acted, &mut alone] {
                list[0] = "s3".to_owned();
                list.push("u".to_owned());
            }
        }
        prop_assert_eq!(hidden(&["u"], &acted, &[(0, 1, t), (1, 0, 1), (2, 1, 1)]), Some(true));
        let found = hidden(&["u"], &alone, &[(0, 1, t), (1, 0, 1)]);
        // c q s2² + b s0² s2² is the rate of a form q.
        prop_assert_eq!(found, Some(c < 0));
    }
}

proptest! {
    #![proptest_config(cases(1))]

    /// s1 and s2 grow together, whatever s0 is, where it only multiplies them: eigenvalues a ± iω, a > 0, or of both signs; for a < 0
    /// they decay. What s0³ adds may stabilize.
    #[test]
    fn growing_modes_that_inputs_only_multiply(a in nonzero(), w in 1_i64..4, c in -2_i64..3, d in -2_i64..3, t in -2_i64..3) {
        let of = |more: &str| {
            let first = format!("{a}*s1 + {w}*s2 + {c}*s0*s1 + {d}*s2^2");
            ["u".to_owned(), first, format!("{a}*s2 - {w}*s1 + {d}*s0*s1 - {c}*s0^2*s2 {more}")]
        };
        prop_assert_eq!(hidden(&["u"], &of(""), &[(0, 1, t), (1, 0, 1), (2, 1, 1)]), Some(a < 0));
        let saddle = ["u".to_owned(), format!("{w}*s1 + {c}*s0*s2"), format!("-s2 + {d}*s0*s1")];
        prop_assert_eq!(hidden(&["u"], &saddle, &[(0, 1, t), (1, 0, 1), (2, 1, 1)]), Some(false));
        if a > 0 {
            prop_assert_ne!(hidden(&["u"], &of("+ s0^3"), &[(0, 1, t)]), Some(false));
        }
    }
}

/// (y e^(x/c))' = y^2k e^(x/c) ≥ 0, whatever the input is: y > 0 does not come back. x + c log(y), which is constant along the input field
/// too, is no coordinate at y = 0.
#[test]
fn functions_that_are_singular_at_the_point_stabilize_nothing() {
    for (x, y) in [
        ("u", "y^2 - u*y"),
        ("u", "2*y^2 - u*y/2"),
        ("u*(1 + y)", "y^2 - u*y"),
        ("u*(1 - y^2)", "y^2 - u*y*(1 - y^2)"),
        ("u", "y^4 - 2*u*y"),
        ("u", "u*y^2 + y^3"),
        ("-x + u", "-u*y + x*y + y^2"),
    ] {
        let system = system(&["x", "y"], &["u"], &[], &[x, y], &[], Some(&[]));
        let report = analyze_affine(&system, &AnalysisOptions::default()).unwrap();
        let point = report.at_point.unwrap().known().cloned().unwrap();
        assert_ne!(point.stabilizable, Some(Answer::Known(true)), "{x}, {y}: {:?}", point.stabilizable_reason);
    }
}

proptest! {
    #![proptest_config(cases(1))]

    /// s0' = u, s_k' = Σ (s0 B + …) s: with s0 = −κ |s| the modes s1, s2 turn and decay where B has eigenvalues a ± b i with a ≠ 0.
    /// The quadratic terms of the modes alone, and all of degree 3, change nothing.
    #[test]
    fn several_modes_that_one_input_multiplies(a in nonzero(), b in -3_i64..4, c in -3_i64..4, d in -3_i64..4, k in 1_usize..3, t in -2_i64..3) {
        let turned = |h: [&str; 2]| {
            let mut list = behind_integrators("s1", k);
            list.pop();
            list.extend(h.map(|h| h.replace("s2", &format!("s{}", k + 1)).replace("s1", &format!("s{k}")).replace("s9", "s0")));
            list
        };
        let h = turned([
            &format!("(s9*({a}*s1 - {b}*s2) + {c}*s1*s2 + {d}*s2^2 + {c}*s9^2*s1)"),
            &format!("(s9*({b}*s1 + {a}*s2) + {d}*s1^2 - {c}*s2^2 + {d}*s9*s1*s2)"),
        ]);
        prop_assert_eq!(hidden(&["u"], &h, &[(0, k, t), (k + 1, 0, 1)]), Some(true), "{:?}", h);
    }

    /// Modes that decay by terms of degree 3 beside one that an input makes decay.
    #[test]
    fn modes_of_degree_three_beside_one_that_is_multiplied(a in nonzero(), b in 1_i64..4, c in 1_i64..4, t in -2_i64..3) {
        let h = ["u".to_owned(), format!("{a}*s0*s1"), format!("-{b}*s2^3 - {c}*s1^2*s2")];
        prop_assert_eq!(hidden(&["u"], &h, &[(0, 1, t), (0, 2, 1)]), Some(true), "{:?}", h);
        // Where one of them never falls, nothing helps.
        let h = ["u".to_owned(), format!("{a}*s0*s1"), format!("{b}*s2^3 + {c}*s1^2*s2")];
        let found = hidden(&["u"], &h, &[(0, 1, t)]);
        prop_assert_eq!(found, Some(false), "{:?}", h);
    }
}
