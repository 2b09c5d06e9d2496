//! Zero dynamics with eigenvalues on the imaginary axis, whose stability is known by construction.

use crate::common::system;
use crate::tier::cases;
use bracketry_lie::feedback::ZeroDynamicsReport;
use bracketry_lie::reason::MinimumPhaseReason;
use bracketry_lie::{AnalysisOptions, Answer, analyze_affine};
use proptest::prelude::*;

/// The system y' = u with z' = F(z) + y beside it: the zero dynamics of y are z' = F(z).
fn zero_dynamics(states: &[&str], equations: &[&str]) -> ZeroDynamicsReport {
    zero_dynamics_at(states, equations, &[])
}

/// The same about another point than the origin.
fn zero_dynamics_at(states: &[&str], equations: &[&str], at: &[(&str, &str)]) -> ZeroDynamicsReport {
    let mut names = vec!["y"];
    names.extend(states);
    let mut rhs = vec!["u".to_owned()];
    rhs.extend(equations.iter().map(|e| format!("{e} + y")));
    let rhs: Vec<&str> = rhs.iter().map(String::as_str).collect();
    let s = system(&names, &["u"], &[], &rhs, &["y"], Some(at));
    let report = analyze_affine(&s, &AnalysisOptions::default()).unwrap().control.input_output.unwrap();
    report.zero_dynamics.unwrap().known().unwrap().clone()
}

fn holds(states: &[&str], equations: &[&str]) -> Option<bool> {
    match zero_dynamics(states, equations).minimum_phase {
        Answer::Known(holds) => Some(holds),
        Answer::Unknown(_) => None,
    }
}

#[test]
fn cubic_damping_decides_by_its_sign() {
    for (sign, expected) in [("-", true), ("+", false)] {
        let cubic = |z: &str| format!("{sign} {z}^3");
        let oscillator = [format!("z2 {}", cubic("z1")), format!("-z1 {}", cubic("z2"))];
        let half_damped = ["z2".to_owned(), format!("-4*z1 {}", cubic("z2"))];
        let spring = ["z2".to_owned(), format!("-z1^3 {sign} z2")];
        let alone = [format!("z2 {sign} z1^3*(2 - z2)"), format!("-z1 {sign} z2^5")];
        for equations in [&oscillator, &half_damped, &spring] {
            let equations: Vec<&str> = equations.iter().map(String::as_str).collect();
            let found = holds(&["z1", "z2"], &equations);
            // An eigenvalue 1 is unstable in any case.
            assert_eq!(found, Some(expected), "{equations:?}");
        }
        // Whatever is not seen must not be wrong.
        let equations: Vec<&str> = alone.iter().map(String::as_str).collect();
        assert_ne!(holds(&["z1", "z2"], &equations), Some(!expected));
    }
    assert_eq!(holds(&["a", "b", "c"], &["-a^3 + b", "-a - b^3", "-2*c^3"]), Some(true));
}

#[test]
fn conservative_motion_is_only_stable() {
    // A mass that depends on the position, in coordinates that do not preserve volume.
    let z = zero_dynamics(&["q", "v"], &["v", "-q*(1 + v^2)/(1 + q^2)"]);
    assert_eq!(z.minimum_phase, Answer::Known(false), "{z:?}");
    let reason = z.minimum_phase_reason.unwrap();
    assert!(matches!(reason, MinimumPhaseReason::Conserved { stable: true, .. }), "{reason}");
    // Rotation with a speed that depends on the state, of which z1² + 3 z2² is conserved.
    let z = zero_dynamics(&["a", "b"], &["3*b*(1 + a)", "-a*(1 + a)"]);
    let reason = z.minimum_phase_reason.unwrap();
    assert!(matches!(reason, MinimumPhaseReason::Conserved { stable: true, .. }), "{reason}");
    assert!(reason.to_string().contains("stable, but not asymptotically"), "{reason}");
}

/// z' = c z^k + … in coordinates that a decaying state is mixed with: (z, w) → (z + w, w + z²).
#[test]
fn one_zero_eigenvalue_by_the_center_manifold() {
    assert_eq!(holds(&["a", "b"], &["a*b", "-b - a^2"]), Some(true));
    assert_eq!(holds(&["a", "b"], &["a*b", "-b + a^2"]), Some(false));
    assert_eq!(holds(&["a", "b"], &["a*b - a^3", "-b + a^2/2"]), Some(true));
    assert_eq!(holds(&["a", "b"], &["a*b - a^3/3", "-b + a^2/2"]), Some(false));
    assert_eq!(holds(&["a", "b"], &["a^2 + b", "-b"]), Some(false));
    // sin and its cubic term.
    assert_eq!(holds(&["a", "b"], &["sin(a) - a + b^2", "-b"]), Some(true));
    assert_eq!(holds(&["a", "b"], &["a - sin(a) + b^2", "-b"]), Some(false));
    // A line of equilibria: not asymptotically stable, or open, but never yes.
    assert_ne!(holds(&["a", "b"], &["a*b", "-b"]), Some(true));
}

/// z1'' = −z1 − c z1² z1' and an oscillator with a quadratic spring and damper, by the formula for the first focal value.
#[test]
fn oscillators_with_nonlinear_damping() {
    assert_eq!(holds(&["a", "b"], &["b", "-a - a^2*b"]), Some(true));
    assert_eq!(holds(&["a", "b"], &["b", "-a + a^2*b"]), Some(false));
    // b' = −4 a + p a b + s a²: the first focal value has the sign of p s.
    assert_eq!(holds(&["a", "b"], &["b", "-4*a + a*b + a^2"]), Some(false));
    assert_eq!(holds(&["a", "b"], &["b", "-4*a - 3*a*b + a^2"]), Some(true));
    assert_eq!(holds(&["a", "b"], &["b", "-sin(a)*(1 + a*b)"]), Some(true));
}

fn nonzero() -> impl Strategy<Value = i64> {
    (-3_i64..4).prop_filter("not zero", |c| *c != 0)
}

proptest! {
    #![proptest_config(cases(4))]

    /// Predator and prey: p x − a log x + q y − b log y is constant. With c x² more, prey limits itself, and the equilibrium attracts
    /// or repels.
    #[test]
    fn predator_and_prey(a in 1_i64..4, b in 1_i64..4, p in 1_i64..4, q in 1_i64..4, c in nonzero()) {
        // About x = b/p, y = a/q.
        let at = [("x", format!("{b}/{p}")), ("z", format!("{a}/{q}"))];
        let at: Vec<(&str, &str)> = at.iter().map(|(n, v)| (*n, v.as_str())).collect();
        let (prey, predator) = (format!("x*({a} - {q}*z)"), format!("z*({p}*x - {b})"));
        let free = zero_dynamics_at(&["x", "z"], &[&prey, &predator], &at);
        prop_assert_eq!(free.minimum_phase, Answer::Known(false));
        let reason = free.minimum_phase_reason.unwrap();
        prop_assert!(matches!(reason, MinimumPhaseReason::Conserved { stable: true, .. }), "{}", reason);
        let limited = format!("{prey} - {c}*x*({p}*x - {b})");
        let limited = zero_dynamics_at(&["x", "z"], &[&limited, &predator], &at);
        prop_assert_eq!(limited.minimum_phase, Answer::Known(c > 0));
    }

    /// q = k a² + b² with q' = 2 c q^(j + 1): the sign of c decides, in coordinates B = b + p a², A = a + r B² and beside a
    /// decaying state W = w + m a² that acts on the pair.
    #[test]
    fn focal_values_in_any_coordinates(k in 1_i64..5, c in nonzero(), j in 1_u32..3, p in -2_i64..3, r in -1_i64..2, m in -2_i64..3, d in 1_i64..3) {
        let q = format!("({k}*a^2 + b^2)^{j}");
        let (da, db) = (format!("(b + {c}*a*{q})"), format!("(-{k}*a + {c}*b*{q})"));
        let old = |s: &str| s.replace('b', &format!("(B - {p}*a^2)")).replace('a', &format!("(A - {r}*B^2)"));
        let plane = |da: &str, db: &str| {
            let big_b = format!("({db} + 2*{p}*a*{da})");
            [old(&format!("{da} + 2*{r}*(b + {p}*a^2)*{big_b}")), old(&big_b)]
        };
        let [x, y] = plane(&da, &db);
        prop_assert_eq!(holds(&["A", "B"], &[&x, &y]), Some(c < 0), "{} {}", x, y);
        if j == 1 {
            let (da, db) = (format!("(b + {c}*a*{q} + w*a)"), format!("(-{k}*a + {c}*b*{q} + 2*w*b + w^2)"));
            let [x, y] = plane(&da, &db);
            let w = format!("(W - {m}*a^2)");
            let dw = old(&format!("-{d}*{w} + 2*{m}*a*{da}")).replace('w', &old(&w));
            let [x, y] = [x, y].map(|e| e.replace('w', &old(&w)));
            prop_assert_eq!(holds(&["A", "B", "W"], &[&x, &y, &dw]), Some(c < 0), "{} {} {}", x, y, dw);
        }
    }
}

/// Coefficients that are zero and that floating point takes for rounding: the terms of higher degree decide.
#[test]
fn hidden_zeros_do_not_decide() {
    for zero in [
        "(sqrt(2)*sqrt(3) - sqrt(6))",
        "(exp(1)*exp(2) - exp(3))",
        "(sin(1)^2 + cos(1)^2 - 1)",
        "(sqrt(7)*sqrt(5) - sqrt(35))",
    ] {
        for sign in ["-", "+"] {
            for (cubic, expected) in [("-", Some(true)), ("+", Some(false))] {
                let equations = ["z1", "z2"].map(|z| format!("{sign}{zero}*{z} {cubic} {z}^3"));
                let equations = [equations[0].as_str(), &equations[1]];
                assert_eq!(holds(&["z1", "z2"], &equations), expected, "{equations:?}");
            }
        }
    }
}

/// a' = −√3 a + b/s, b' = −s a − √3 b: eigenvalues −√3 ± i in any units of b.
#[test]
fn eigenvalues_do_not_depend_on_units() {
    for digits in [0, 4, 8, 12] {
        let equations = [format!("-sqrt(3)*a + 10^(-{digits})*b"), format!("-10^{digits}*a - sqrt(3)*b")];
        let z = zero_dynamics(&["a", "b"], &[equations[0].as_str(), &equations[1]]);
        assert_eq!(z.minimum_phase, Answer::Known(true), "{digits}: {z:?}");
        for e in z.eigenvalues {
            assert!((e.re + 3f64.sqrt()).hypot(e.im.abs() - 1.0) < 1e-9, "{digits}: {e:?}");
        }
    }
}
