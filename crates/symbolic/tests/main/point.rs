//! Hessians, values at points and Taylor polynomials.

use crate::common::{Kind, NAMES, cases, generator, point, random, value_and_size, values};
use bracketry_symbolic::{Bindings, EvaluationError, Expr, Pool, Symbol};
use proptest::prelude::*;
use rand::RngExt;

fn zero(p: &mut Pool, e: Expr) -> bool {
    p.zero_test(e, &Bindings::new()).is_zero()
}

/// A point with exact coordinates, and the same as expressions.
fn exact_point(p: &mut Pool, x: [f64; 3]) -> ([f64; 3], Vec<(Symbol, Expr)>) {
    let thousandths = x.map(|v| (v * 1000.0).round() as i64);
    let at = NAMES.iter().zip(thousandths).map(|(n, k)| (p.symbol(n), p.ratio(k, 1000))).collect();
    (thousandths.map(|k| k as f64 / 1000.0), at)
}

proptest! {
    #![proptest_config(cases(300))]

    /// Substitution and evaluation commute.
    #[test]
    fn a_value_put_in_is_the_value_of_the_function(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 5, Kind::Smooth);
        let (x, at) = exact_point(&mut p, point(&mut rng));
        // Undefined at this point: nothing to compare.
        let Ok(at_all) = p.at(e, &at) else { return Ok(()) };
        let at_one = p.at(e, &at[..1]).and_then(|f| p.at(f, &at[1..])).unwrap();
        let (v, size) = value_and_size(&mut p, e, x);
        let put = values(&mut p, &[at_all, at_one], x);
        prop_assert!(p.symbols_of(&[at_all]).is_empty());
        for w in put {
            prop_assert!(!size.is_finite() || size > 1e5 || (v - w).abs() <= 1e-7 * size * size, "{}: {v}", p.text(e));
        }
    }

    /// Order of the remainder: with deviations of size h it falls as h^(degree + 1).
    #[test]
    fn the_remainder_of_a_taylor_polynomial_has_its_order(seed: u64, degree in 0..5_u32) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 3, Kind::Smooth);
        let (x, at) = exact_point(&mut p, point(&mut rng));
        let Ok(t) = p.taylor(e, &at, degree) else { return Ok(()) };
        let Ok(next) = p.taylor(e, &at, degree + 1) else { return Ok(()) };
        let direction: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        // e − T_d = (T_{d+1} − T_d) + O(h^(d + 2)); both sides at two sizes of h.
        let mut ratios = Vec::new();
        for h in [2e-2, 5e-3] {
            let here = std::array::from_fn(|i| x[i] + h * direction[i]);
            let v = values(&mut p, &[e, t, next], here);
            let size = value_and_size(&mut p, e, here).1 + value_and_size(&mut p, next, here).1;
            // Only where the first term left out is far above the rounding.
            let first = (v[2] - v[1]).abs();
            if !v.iter().all(|v| v.is_finite()) || size > 1e3 || first < 1e-10 * size {
                return Ok(());
            }
            ratios.push((v[0] - v[1] - (v[2] - v[1])).abs() / first);
        }
        let [wide, near] = [ratios[0], ratios[1]];
        // The next order is smaller by a factor that falls with h, once h is small for this function.
        prop_assert!(wide > 0.1 || near < 0.5 * wide + 1e-3, "{} to degree {degree}: {wide} {near}", p.text(e));
    }

    /// ∂^α of the polynomial and of the function agree at the point, for all |α| ≤ 2.
    #[test]
    fn a_taylor_polynomial_has_the_derivatives_of_the_function(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 3, Kind::Smooth);
        let (x, at) = exact_point(&mut p, point(&mut rng));
        let Ok(t) = p.taylor(e, &at, 2) else { return Ok(()) };
        let s = NAMES.map(|n| p.symbol(n));
        for f in [e, t] {
            let h = p.hessian(f, &s);
            for i in 0..3 {
                for j in 0..3 {
                    prop_assert_eq!(h[i][j], h[j][i]);
                }
            }
        }
        let mut all = vec![(e, t)];
        let (de, dt) = (p.gradient(e, &s), p.gradient(t, &s));
        all.extend(de.into_iter().zip(dt));
        let (he, ht) = (p.hessian(e, &s).concat(), p.hessian(t, &s).concat());
        all.extend(he.into_iter().zip(ht));
        for (a, b) in all {
            let (v, size) = value_and_size(&mut p, a, x);
            let (w, other) = value_and_size(&mut p, b, x);
            let size = size + other;
            if size < 1e5 {
                prop_assert!((v - w).abs() <= 1e-7 * size * size, "{}: {v} {w}", p.text(e));
            }
        }
    }
}

#[test]
fn taylor_polynomials_of_the_elementary_functions() {
    for (f, degree, expected) in [
        ("exp(x)", 4, "1 + x + x^2/2 + x^3/6 + x^4/24"),
        ("sin(x)", 6, "x - x^3/6 + x^5/120"),
        ("log(1 + x)", 3, "x - x^2/2 + x^3/3"),
        ("1/(1 - x)", 4, "1 + x + x^2 + x^3 + x^4"),
        ("sqrt(1 + x)", 3, "1 + x/2 - x^2/8 + x^3/16"),
        ("atan(x)", 5, "x - x^3/3 + x^5/5"),
        ("tanh(x)", 5, "x - x^3/3 + 2*x^5/15"),
        ("tan(x + y)", 3, "x + y + (x + y)^3/3"),
        ("cos(x)*exp(y)", 2, "1 + y + y^2/2 - x^2/2"),
        ("(1 + x)^a", 2, "1 + a*x + a*(a - 1)*x^2/2"),
        ("a^x", 2, "1 + x*log(a) + x^2*log(a)^2/2"),
        ("(a + x)^y", 2, "1 + y*log(a) + y^2*log(a)^2/2 + x*y/a"),
        ("x^3*(1 + y)", 3, "x^3"),
        ("x^7", 6, "0"),
        ("(x + y)^100", 3, "0"),
        ("atan2(x, 1 + y)", 2, "x - x*y"),
        ("max(x + 1, y)*min(x, 2)", 2, "x + x^2"),
        ("abs(x - 1)", 3, "1 - x"),
        ("sin(a)*x", 0, "0"),
        ("sin(a)", 3, "sin(a)"),
        ("asin(x)", 3, "x + x^3/6"),
    ] {
        let mut p = Pool::new();
        let e = p.parse(f).unwrap();
        let (x, y, o) = (p.symbol("x"), p.symbol("y"), p.int(0));
        let t = p.taylor(e, &[(x, o), (y, o)], degree).unwrap();
        let s = p.parse(expected).unwrap();
        let d = p.sub(t, s);
        assert!(zero(&mut p, d), "{f}: {}", p.text(t));
    }
}

#[test]
fn the_point_may_be_symbolic() {
    let mut p = Pool::new();
    let e = p.parse("sin(x)").unwrap();
    let (x, a) = (p.symbol("x"), p.var("a"));
    let t = p.taylor(e, &[(x, a)], 3).unwrap();
    let s = p.parse("sin(a) + cos(a)*(x-a) - sin(a)*(x-a)^2/2 - cos(a)*(x-a)^3/6").unwrap();
    let d = p.sub(t, s);
    assert!(zero(&mut p, d), "{}", p.text(t));
}

#[test]
fn where_there_is_no_polynomial_the_function_is_named() {
    let mut p = Pool::new();
    let (x, o) = (p.symbol("x"), p.int(0));
    for (f, named) in [
        ("1 + abs(x)", "abs(x)"),
        ("sqrt(x)", "sqrt(x)"),
        ("sign(sin(x))", "sign(sin(x))"),
        ("max(x, 0)", "max(x, 0)"),
        ("x^(5/3)", "x^(5/3)"),
    ] {
        let e = p.parse(f).unwrap();
        assert_eq!(p.taylor(e, &[(x, o)], 2), Err(EvaluationError::NotSmooth { text: named.into() }));
    }
    for (f, named) in [
        ("y/x", "1/x"),
        ("log(x)", "log(x)"),
        ("1/(sin(x)^2 + cos(x)^2 - 1)", "1/(sin(x)^2 + cos(x)^2 - 1)"),
        ("x^(-1/2)", "1/sqrt(x)"),
    ] {
        let e = p.parse(f).unwrap();
        assert_eq!(p.taylor(e, &[(x, o)], 2), Err(EvaluationError::NoValue { text: named.into() }), "{f}");
    }
    let e = p.parse("asin(x)").unwrap();
    let one = p.int(1);
    assert_eq!(p.taylor(e, &[(x, one)], 1), Err(EvaluationError::NotSmooth { text: "asin(x)".into() }));
    let many: Vec<_> = (0..20).map(|i| (p.symbol(&format!("v{i}")), o)).collect();
    assert_eq!(p.taylor(e, &many, 20), Err(EvaluationError::TooManyTerms { variables: 20, degree: 20 }));
}

#[test]
fn values_that_do_not_exist_are_refused() {
    let mut p = Pool::new();
    let (x, y, o) = (p.symbol("x"), p.symbol("y"), p.int(0));
    // 0/0 is no number, though a product with 0 would be 0.
    let e = p.parse("x/y").unwrap();
    assert_eq!(p.at(e, &[(x, o), (y, o)]), Err(EvaluationError::NoValue { text: "1/y".into() }));
    let e = p.parse("x*log(x)").unwrap();
    assert_eq!(p.at(e, &[(x, o)]), Err(EvaluationError::NoValue { text: "log(x)".into() }));
    // All at once: x and y change places.
    let e = p.parse("x - 2*y").unwrap();
    let (ex, ey) = (p.sym(x), p.sym(y));
    let swapped = p.at(e, &[(x, ey), (y, ex)]).unwrap();
    let expected = p.parse("y - 2*x").unwrap();
    let d = p.sub(swapped, expected);
    assert!(zero(&mut p, d));
}
