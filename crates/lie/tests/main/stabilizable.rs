//! Whether feedback stabilizes an equilibrium: systems with known answers, in coordinates that hide them.

use crate::common::system;
use bracketry_lie::controllability::{InputValues, PointReport, Verdict};
use bracketry_lie::reason::StabilizableReason;
use bracketry_lie::{AnalysisOptions, Answer, analyze_affine};
use proptest::prelude::*;

/// What holds at the origin, or where the named variables have other values.
fn report(
    states: &str,
    inputs: &str,
    dynamics: &[&str],
    at: &[(&str, &str)],
    options: &AnalysisOptions,
) -> PointReport {
    let (states, inputs): (Vec<&str>, Vec<&str>) =
        (states.split_whitespace().collect(), inputs.split_whitespace().collect());
    let system = system(&states, &inputs, &[], dynamics, &[], Some(at));
    analyze_affine(&system, options).unwrap().at_point.unwrap().known().unwrap().clone()
}

fn stabilizable(states: &str, inputs: &str, dynamics: &[&str]) -> (Option<bool>, Option<StabilizableReason>) {
    let r = report(states, inputs, dynamics, &[], &AnalysisOptions::default());
    (r.stabilizable.unwrap().known().copied(), r.stabilizable_reason)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// x' = v, v' = u, e' = 0 with E = e + p(x, v): E − p never changes.
    #[test]
    fn a_conserved_function_excludes_it(a in -3_i64..4, b in -3_i64..4, c in 1_i64..4) {
        // p = a x²/2 + b v²/2 + c x v + a x³/3.
        let energy = format!("{a}*x*v + {b}*v*u + {c}*v^2 + {c}*x*u + {a}*x^2*v");
        let (answer, why) = stabilizable("x v E", "u", &["v", "u", &energy]);
        prop_assert_eq!(answer, Some(false));
        prop_assert_eq!(why, Some(StabilizableReason::Leaves { dimension: 2, states: 3 }));
    }

    /// x' = u, z' = h(z) with h'(0) > 0, Z = z + a x² + b x.
    #[test]
    fn unstable_equations_without_inputs_exclude_it(a in -3_i64..4, b in -3_i64..4, k in 1_i64..4, c in -2_i64..3) {
        let z = format!("(Z - {a}*x^2 - {b}*x)");
        let rate = format!("{k}*{z} + {c}*{z}^2 + {a}*2*x*u + {b}*u");
        let (answer, why) = stabilizable("x Z", "u", &["u", &rate]);
        prop_assert_eq!(answer, Some(false));
        if c != 0 || a != 0 {
            prop_assert_eq!(why, Some(StabilizableReason::UnstableQuotient));
        }
    }

    /// y' = x^k, in other coordinates: Y = y + a x².
    #[test]
    fn powers_in_the_plane_decide_by_their_parity(k in 2_i64..6, a in -2_i64..3) {
        let rate = format!("x^{k} + {a}*2*x*u");
        let (answer, _) = stabilizable("x Y", "u", &["u", &rate]);
        prop_assert_eq!(answer, Some(k % 2 == 1), "{}", rate);
    }

    /// What jumps reach is no argument: y' = x² + c x³ does not fall near 0, in any company.
    #[test]
    fn jumps_do_not_stabilize(c in 1_i64..5, a in -2_i64..3) {
        let rate = format!("x^2 + {c}*x^3");
        let r = report("x y z q", "u w", &["u", &rate, &format!("w + {a}*q"), "z"], &[], &AnalysisOptions::default());
        prop_assert_eq!(r.stlc.verdict, Verdict::Yes);
        prop_assert_eq!(r.stlc.with_bounded_inputs(), Verdict::No);
        prop_assert_eq!(r.stabilizable, Some(Answer::Known(false)));
    }

    /// y' = a y − b x³ is stabilized by x = c y^(1/3), which is no smooth feedback; a "no" would be wrong.
    #[test]
    fn an_unstable_mode_of_the_linearization_alone_decides_nothing(a in 1_i64..4, b in 1_i64..4) {
        let (answer, _) = stabilizable("x y", "u", &["u", &format!("{a}*y - {b}*x^3")]);
        prop_assert_ne!(answer, Some(false));
    }
}

/// x' = u on a range: at an end the state moves to one side only, outside the point is none of rest.
#[test]
fn ranges_of_inputs_are_kept() {
    let with = |lower: f64, upper: f64, u: &str| {
        let ranges = vec![("u".to_owned(), InputValues::Between(lower, upper))];
        report("x", "u", &["u"], &[("u", u)], &AnalysisOptions { ranges, ..AnalysisOptions::default() })
    };
    assert_eq!(with(-1.0, 1.0, "0").stabilizable, Some(Answer::Known(true)));
    assert_eq!(with(0.0, 1.0, "0").stabilizable, Some(Answer::Known(false)));
    let outside = with(1.0, 2.0, "0");
    assert_eq!((outside.equilibrium, outside.stabilizable), (Answer::Known(false), None));
    assert_eq!(outside.outside_ranges, ["u"]);
}

/// √9.81 at a point, exactly: the second state is the first times it.
#[test]
fn the_root_of_the_acceleration_of_gravity_is_exact_at_a_point() {
    for g in ["9.81", "9.8", "10", "981/1000"] {
        let r = report(
            "x y",
            "u",
            &["u", &format!("(sqrt({g})^2 - {g})*u + sqrt({g})*x")],
            &[],
            &AnalysisOptions::default(),
        );
        assert_eq!(r.linear_controllability_rank, Some(2), "{g}");
    }
}

/// An input that does not move the state at the point may have another value there.
#[test]
fn constant_inputs_may_stabilize() {
    assert_eq!(stabilizable("x", "u", &["x*u"]).0, Some(true));
    assert_eq!(stabilizable("x y", "u", &["y + u*x", "-x"]).0, Some(true));
    // V = x² − y² grows with every input.
    assert_ne!(stabilizable("x y", "u", &["x + u*y", "-2*y + u*x"]).0, Some(true));
    let ranges = vec![("u".to_owned(), InputValues::Between(0.0, 2.0))];
    let options = AnalysisOptions { ranges, ..AnalysisOptions::default() };
    assert_ne!(report("x", "u", &["x*u"], &[("u", "1")], &options).stabilizable, Some(Answer::Known(true)));
    // At rest at the end of the range: a tank without inflow.
    let tank = report(
        "h",
        "q",
        &["q - 2*h"],
        &[],
        &AnalysisOptions {
            ranges: vec![("q".to_owned(), InputValues::Between(0.0, 1.0))],
            ..AnalysisOptions::default()
        },
    );
    assert_eq!(tank.stabilizable_reason, Some(StabilizableReason::Stable));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// z' = a x² + b x y + c y² + linear terms of the inputs: the image is open just when the form is indefinite, also in
    /// coordinates that mix z with the others.
    #[test]
    fn brocketts_condition_for_quadratic_forms(a in -3_i64..4, b in -3_i64..4, c in -3_i64..4, k in -2_i64..3) {
        prop_assume!(b * b != 4 * a * c);
        let rate = format!("{a}*x^2 + {b}*x*y + {c}*y^2 + {k}*u");
        let r = report("x y Z", "u v", &["u", "v", &rate], &[], &AnalysisOptions::default());
        prop_assert_eq!(r.brockett_condition, Some(Answer::Known(b * b > 4 * a * c)), "{}", rate);
        // Two torques on a rigid body: by STLC and dynamic feedback.
        let decided = if b * b > 4 * a * c { Some(true) } else { Some(false) };
        prop_assert_eq!(r.stabilizable.unwrap().known().copied(), decided, "{}", rate);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// An input u ≥ 0 and a free one in coordinates X = x + a y² + b y: x = X − a y² − b y never falls.
    #[test]
    fn functions_that_rise_with_one_sided_inputs(a in -3_i64..4, b in -3_i64..4, k in 1_i64..4) {
        let ranges = vec![("u".to_owned(), InputValues::Between(0.0, 1.0))];
        let rate = format!("{k}*u + {a}*2*y*v + {b}*v");
        let r = report("X y", "u v", &[&rate, "v"], &[], &AnalysisOptions { ranges, ..AnalysisOptions::default() });
        prop_assert_eq!(r.stlc.with_bounded_inputs(), Verdict::No);
        prop_assert_eq!(r.stabilizable, Some(Answer::Known(false)));
    }

    /// The sum of squares of any functions does not fall: z' = (p x + q sin y)² + (r y + z)², in the given coordinates.
    #[test]
    fn forms_in_any_functions_have_their_sign(p in 1_i64..4, q in -3_i64..4, r in -3_i64..4) {
        let (f, g) = (format!("({p}*x + {q}*sin(y))"), format!("({r}*y + z)"));
        let rate = format!("2*{f}^2 + 2*{f}*{g} + 3*{g}^2");
        let report = report("x y z", "u v", &["u", "v", &rate], &[], &AnalysisOptions::default());
        prop_assert_eq!(report.stlc.verdict, Verdict::No, "{}", rate);
        prop_assert_eq!(report.stabilizable, Some(Answer::Known(false)));
        prop_assert_eq!(report.brockett_condition, Some(Answer::Known(false)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// x' = u Ω x with a skew Ω in the norm of a form P: xᵀPx never changes, though its gradient vanishes at the origin. The field turns
    /// x + p y + q y² and y.
    #[test]
    fn what_is_constant_excludes_it_where_its_gradient_vanishes(a in 1_i64..4, b in 1_i64..4, p in -2_i64..3, q in -2_i64..3) {
        let x = format!("(X - {p}*y - {q}*y^2)");
        let rate = format!("-{b}*{x}*u");
        let outer = format!("{a}*y*u + ({p} + 2*{q}*y)*({rate})");
        let (answer, why) = stabilizable("X y", "u", &[&outer, &rate]);
        prop_assert_eq!(answer, Some(false), "{:?}", why);
    }

    /// Inputs at an end of their ranges, with others inside that hold the point.
    #[test]
    fn inputs_inside_their_ranges_stabilize(a in 1_i64..4, b in 1_i64..4, c in -2_i64..3) {
        let ranges = ["u", "v"].map(|n| (n.to_owned(), InputValues::Between(0.0, 1.0))).to_vec();
        let options = AnalysisOptions { ranges, ..AnalysisOptions::default() };
        let judge = |dynamics: &[&str]| {
            let r = report("x y", "u v", dynamics, &[], &options);
            (r.stabilizable.unwrap().known().copied(), r.stabilizable_reason)
        };
        // u and v balance each other at any height.
        let (answer, why) = judge(&[&format!("{a}*y"), &format!("{b}*(u - v) + {c}*x")]);
        prop_assert_eq!(answer, Some(true), "{:?}", why);
        let other = matches!(why, Some(StabilizableReason::OtherInputs { .. }));
        prop_assert!(other);
        // A damper that is open at the point.
        let (answer, why) = judge(&["y", &format!("-{a}*x - {b}*y*u")]);
        prop_assert_eq!(answer, Some(true), "{:?}", why);
        // Both inputs push to one side.
        let (answer, why) = judge(&["y", &format!("{a}*u + {b}*v")]);
        prop_assert_eq!(answer, Some(false), "{:?}", why);
    }

    /// The drift alone is asymptotically stable by terms of degree 3, at an end of the ranges and between.
    #[test]
    fn what_rests_by_itself_needs_no_feedback(a in 1_i64..4, b in 1_i64..4, c in -2_i64..3, inside in any::<bool>()) {
        let lower = if inside { -1.0 } else { 0.0 };
        let ranges = vec![("u".to_owned(), InputValues::Between(lower, 1.0))];
        let options = AnalysisOptions { ranges, ..AnalysisOptions::default() };
        for sign in [1, -1] {
            let r = report("x y", "u", &["y", &format!("-{a}*x - {}*y^3 + {c}*x*y^2*u", sign * b)], &[], &options);
            let expected = (sign == 1).then_some(true);
            prop_assert_eq!(r.stabilizable.unwrap().known().copied().filter(|s| *s), expected, "{:?}", r.stabilizable_reason);
        }
    }

    /// Two states that decay each with an input of its own.
    #[test]
    fn several_inputs_that_do_not_move_the_state(a in 1_i64..4, b in 1_i64..4, c in -2_i64..3) {
        let (answer, why) = stabilizable("x y", "u v", &[&format!("{a}*x*u + {c}*y^2"), &format!("{b}*y*v + {c}*x*y")]);
        prop_assert_eq!(answer, Some(true), "{:?}", why);
        let other = matches!(why, Some(StabilizableReason::OtherInputs { .. }));
        prop_assert!(other);
    }

    /// z' = xʲ (y + p(x) y²): where x is not 0, y moves z to both sides. In Z = z + q x y the equilibria are the same.
    #[test]
    fn brocketts_condition_by_equilibria_nearby(j in 1_i64..4, p in -2_i64..3, q in -2_i64..3) {
        let rate = format!("x^{j}*(y + {p}*y^2) + {q}*(y*u + x*v)");
        let r = report("x y Z", "u v", &["u", "v", &rate], &[], &AnalysisOptions::default());
        prop_assert_eq!(r.brockett_condition, Some(Answer::Known(true)), "{}", rate);
        // With a square, z moves to one side of every equilibrium.
        let rate = format!("x^{}*y^2 + {q}*(y*u + x*v)", 2 * j);
        let r = report("x y Z", "u v", &["u", "v", &rate], &[], &AnalysisOptions::default());
        prop_assert_eq!(r.brockett_condition, Some(Answer::Known(false)), "{}", rate);
    }
}
