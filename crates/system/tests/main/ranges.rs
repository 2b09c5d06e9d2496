//! Ranges of new inputs are exact: every bound is approached, none is crossed, and what is not established is unknown.

use bracketry_system::AtPoint::{AtLower, AtUpper, Interior};
use bracketry_system::{Candidate, Method, NewInput, Range, System};
use proptest::prelude::*;

/// The input change of x' = w(u).
fn change(w: &str, inputs: &str, point: &str) -> Candidate {
    let list: Vec<String> = inputs.split_whitespace().map(|u| format!("'{u}'")).collect();
    let text = format!(
        "states = ['x']\ninputs = [{}]\n[parameters]\nk = 2\nc = 0.5\n[dynamics]\nx = '{w}'\n{point}",
        list.join(",")
    );
    let all = System::parse("m", &text).unwrap().affinize().unwrap().candidates;
    all.into_iter().find(|c| c.is_accepted() && !c.input_change.is_empty()).unwrap()
}

fn input(w: &str, inputs: &str) -> NewInput {
    change(w, inputs, "").input_change.remove(0)
}

#[test]
fn limits_are_those_of_calculus() {
    for (w, limits) in [
        ("u^2", "v1 ≥ 0"),
        ("-u^2", "v1 ≥ 0"),
        ("u^2 + u", "v1 ≥ -0.25"),
        ("u^4 - 3*u^2", "v1 ≥ -2.25"),
        ("u^2 + c*u", "v1 ≥ -0.0625"),
        ("(u + 1)^2", "v1 ≥ 0"),
        ("u/(1 + u^2)", "|v1| ≤ 0.5"),
        ("1/(1 + u^2)", "0 < v1 ≤ 1"),
        ("exp(u)", "v1 > 0"),
        ("exp(-u)", "v1 > 0"),
        ("exp(u) + exp(-u)", "v1 ≥ 2"),
        ("exp(2*u) - exp(2*u)*exp(2*u)", "v1 ≤ 0.25"),
        ("tanh(u)", "|v1| < 1"),
        ("atan(u)", "|v1| < 0.5*pi"),
        ("u/sqrt(1 + u^2)", "|v1| < 1"),
        ("u/sqrt(9 + 4*u^2)", "|v1| < 0.5"),
        ("u/(1 + abs(u))", "|v1| < 1"),
        ("sin(u)", "|v1| ≤ 1"),
        ("sin(u)*cos(u)", "|v1| ≤ 0.5"),
        ("3*sin(u) + 4*cos(u)", "|v1| ≤ 5"),
        ("sin(u)^2", "0 ≤ v1 ≤ 1"),
        ("cosh(u)", "v1 ≥ 1"),
        ("sqrt(u)", "v1 ≥ 0"),
        ("abs(u)", "v1 ≥ 0"),
        ("max(u, 0)", "v1 ≥ 0"),
        ("min(max(u, -1), k)", "-1 ≤ v1 ≤ 2"),
        ("max(u - 1, 0)*u", "v1 ≥ 0"),
        ("2^u", "v1 > 0"),
        ("abs(sqrt(u) - 1)", "v1 ≥ 0"),
    ] {
        let v = input(w, "u");
        assert_eq!(v.range().as_deref(), Some(limits), "{w}");
        assert_eq!(v.values.is_onto(), Some(false), "{w}");
    }
    // Several inputs: independent terms and factors.
    for (w, limits) in [
        ("u^2 + w^2", "v1 ≥ 0"),
        ("u^2 + sin(w)", "v1 ≥ -1"),
        ("sin(u)*sin(w)", "|v1| ≤ 1"),
        ("exp(u)*w^2", "v1 ≥ 0"),
        ("tanh(u)*cos(w)", "|v1| < 1"),
    ] {
        assert_eq!(input(w, "u w").range().as_deref(), Some(limits), "{w}");
    }
}

#[test]
fn functions_that_take_every_value_are_unrestricted() {
    for w in [
        "u^3",
        "u + u^3",
        "u - u^3",
        "abs(u)*u",
        "sign(u)*u^2",
        "sign(u)*sqrt(abs(u))",
        "u + sin(u)",
        "2*u^3 + 2*sin(u)",
        "sinh(u)",
        "exp(u) - exp(-u)",
        "u*exp(u^2)",
        "u + tanh(u) + k*u^3",
        "tan(u)",
        "log(u)",
        "u*sqrt(1 + u^2)",
        "max(u - 1, 0) + min(u + 1, 0)",
        "sin(x) + u^3",
    ] {
        let v = input(w, "u");
        assert_eq!((&v.values, v.range()), (&Range::Onto, None), "{w}");
    }
    for w in ["u*w", "u^2 - w^2", "u^2 + u*w", "u^2 + w^3", "u*cos(w)", "exp(u) - exp(w)"] {
        assert_eq!(input(w, "u w").values, Range::Onto, "{w}");
    }
}

#[test]
fn what_is_not_established_is_unknown() {
    for w in ["u^2*exp(u) + sin(u)", "1/u", "u + x*u^2", "exp(x*u)", "u^2 + u*sin(u)"] {
        let v = input(w, "u");
        assert!(matches!(v.values, Range::Unknown { .. }), "{w}: {}", v.values);
        assert_eq!((v.values.is_onto(), v.range()), (None, None), "{w}");
    }
}

#[test]
fn irrational_bounds_are_rounded_and_said_to_be() {
    let Range::Interval { lower: Some(b), upper: None } = input("u^4 + u", "u").values else { unreachable!() };
    // At u = −4^(−1/3).
    let u = -(0.25f64.cbrt());
    approx::assert_relative_eq!(b.value, u.powi(4) + u, max_relative = 1e-14);
    assert!(b.closed && b.exact.is_none());
}

#[test]
fn where_the_point_lies_in_the_range_is_told() {
    let at = |w: &str, inputs: &str, point: &str| {
        let c = change(w, inputs, &format!("[point]\n{point}\n"));
        (c.input_change[0].at_point, c.regular_at_point, c.interior_at_point)
    };
    assert_eq!(at("u^2", "u", "u = 0"), (AtLower, Some(false), Some(false)));
    assert_eq!(at("u^2", "u", "u = 1"), (Interior, Some(true), Some(true)));
    assert_eq!(at("1/(1 + u^2)", "u", "u = 0"), (AtUpper, Some(false), Some(false)));
    assert_eq!(at("sin(u)", "u", "u = 'pi/2'"), (AtUpper, Some(false), Some(false)));
    assert_eq!(at("sin(u)", "u", "u = 'pi/6'"), (Interior, Some(true), Some(true)));
    // Not regular, and yet all values around are taken.
    assert_eq!(at("u^3", "u", "u = 0"), (Interior, Some(false), Some(true)));
    assert_eq!(at("u^2 - u^4", "u", "u = 0"), (Interior, Some(false), Some(true)));
    assert_eq!(at("u*w", "u w", "u = 0"), (Interior, Some(false), Some(true)));
    // A corner of |u|, and of a function that takes all values.
    assert_eq!(at("abs(u)", "u", "u = 0"), (AtLower, None, Some(false)));
    assert_eq!(at("max(u, 0) + min(2*u, 0)", "u", "u = 0").2, Some(true));
    // Without a formula for the range, by values on both sides.
    assert_eq!(at("u^2*sin(u) + u^3*cos(u)", "u", "u = 0").0, Interior);
}

#[test]
fn values_that_two_inputs_take_together_are_told() {
    let both = |x: &str, y: &str| {
        let text =
            format!("states = ['x', 'y']\ninputs = ['u', 'w']\n[dynamics]\nx = '{x}'\ny = '{y}'\n[point]\nx = 0");
        let a = System::parse("m", &text).unwrap().affinize().unwrap();
        assert_eq!((a.method, a.input_change.len()), (Method::InputChange, 2), "{x}, {y}");
        let chosen = a.candidates.into_iter().find(|c| c.chosen).unwrap();
        (chosen.independent_ranges, chosen.interior_at_point, chosen.covers_at_point)
    };
    // Different inputs.
    assert_eq!(both("u^3", "w^3"), (Some(true), Some(true), Some(true)));
    assert_eq!(both("u^2", "w"), (Some(true), Some(false), Some(false)));
    // Polar coordinates reach every vector.
    assert_eq!(both("u*cos(w)", "u*sin(w)"), (Some(true), Some(true), Some(true)));
    // Sum and product: only where the product is at most a quarter of the square; that set's convex hull is the plane.
    assert_eq!(both("u + w", "u*w"), (None, Some(true), None));
    // Speed and steering angle: at rest nothing turns, but the hull is the plane.
    assert_eq!(both("u", "u*tan(w)"), (None, Some(true), None));
    // The second is at least the square of the first: no neighborhood of 0.
    assert_eq!(both("u", "u^2 + w^2"), (None, Some(false), Some(false)));
    // Values on all sides.
    assert_eq!(both("sinh(u + w)*(u - w)^2", "sinh(u - w)*(u + w)^2").1, Some(true));
    // Both take both signs, and yet their sum is never negative: the arguments add up to 2w², and sinh is odd and grows.
    assert_eq!(both("sinh(w^2 + u)", "sinh(w^2 - u)").1, None);
    // At the edge: the first is never negative.
    assert_eq!(both("u^2*(2 + sin(u))", "w^3").1, None);
    // All values that are seen lie on a line, but for a millionth.
    assert_eq!(both("u^3", "atan(u^3/10^6 + w^3/10^12)").1, None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// No sample of a random polynomial, or quotient of polynomials, lies outside its range, and finite ends that
    /// belong to it are nearly taken.
    #[test]
    fn samples_lie_within_and_fill_the_range(p in prop::collection::vec(-3i32..4, 2..6), q in 1i32..4, quotient: bool) {
        let polynomial: Vec<String> = p.iter().enumerate().map(|(k, c)| format!("({c})*u^{}", k + 1)).collect();
        let polynomial = polynomial.join(" + ");
        let w = if quotient { format!("({polynomial})/({q} + u^2)^2") } else { polynomial };
        let text = format!("states = ['x']\ninputs = ['u']\n[dynamics]\nx = '{w}'");
        let a = System::parse("m", &text).unwrap().affinize().unwrap();
        prop_assume!(a.method == Method::InputChange);
        let v = &a.input_change[0];
        let mut pool = a.system.pool.clone();
        let u = pool.symbol("u");
        let tape = bracketry_system::symbolic::Tape::compile(&pool, &[u], &[v.function]).unwrap();
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in -40_000..=40_000 {
            let mut out = [0.0];
            tape.eval(&[f64::from(k) * 1e-3], &mut Vec::new(), &mut out);
            (least, greatest) = (least.min(out[0]), greatest.max(out[0]));
        }
        let scale = 1.0 + least.abs().min(greatest.abs());
        match &v.values {
            Range::Onto => prop_assert!(least < -5.0 && greatest > 5.0, "{w}: {least} … {greatest}"),
            Range::Interval { lower, upper } => {
                if let Some(b) = lower {
                    prop_assert!(least >= b.value - 1e-9 * scale, "{w}: {least} below {b:?}");
                    prop_assert!(!b.closed || least <= b.value + 1e-4 * scale, "{w}: {least} far above {b:?}");
                }
                if let Some(b) = upper {
                    prop_assert!(greatest <= b.value + 1e-9 * scale, "{w}: {greatest} above {b:?}");
                    prop_assert!(!b.closed || greatest >= b.value - 1e-4 * scale, "{w}: {greatest} far below {b:?}");
                }
            }
            Range::Unknown { reason } => prop_assert!(false, "{w}: {reason}"),
        }
    }
}
