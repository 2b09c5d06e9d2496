//! Simplification and expansion as statements of algebra.

use bracketry_symbolic::{Expr, Func, Func2, Pool, Tape};
use proptest::prelude::*;

fn simplified(text: &str) -> String {
    let mut p = Pool::new();
    let e = p.parse(text).unwrap();
    let s = p.simplify(e);
    p.text(s)
}

#[test]
fn simplify_gives_the_short_form() {
    for (text, short) in [
        ("x + y + x + 2*y", "2*x + 3*y"),
        ("a*b*a^2*b^-1", "a^3"),
        ("(x + y) - (x - y)", "2*y"),
        ("2*(x + y) - 2*x", "2*y"),
        ("2*x + 2*y", "2*(x + y)"),
        ("6*x + 4*y", "6*x + 4*y"),
        ("x/3 + x/6", "0.5*x"),
        ("(x^2)^3/x^5", "x"),
        ("sqrt(x)*sqrt(x)", "x"),
        ("sqrt(4*9)", "6"),
        ("8^(2/3)", "4"),
        ("2^x*2^(-x)", "1"),
        ("x^(2*a)*x^(-a)", "x^a"),
        ("exp(2*x)*exp(-x)", "exp(x)"),
        ("exp(3*log(x))", "x^3"),
        ("sin(q)^2 + cos(q)^2", "1"),
        ("m*l^2*sin(q)^2 + m*l^2*cos(q)^2", "l^2*m"),
        ("1 - sin(q)^2", "cos(q)^2"),
        ("3*sin(q)^2 + cos(q)^2 - 3", "-2*cos(q)^2"),
        ("sin(q)^4 + sin(q)^2*cos(q)^2", "sin(q)^2"),
        ("sin(x - y) + sin(y - x)", "0"),
        ("cos(x - y) - cos(y - x)", "0"),
        ("min(a, b) - min(b, a)", "0"),
        ("abs(x)^2", "x^2"),
        ("(x - y)*(y - x) + (x - y)^2", "0"),
        ("(x + y)^2 - x^2 - y^2", "2*x*y"),
        ("(a + b)*(a - b) + b^2", "a^2"),
        ("(2*x + 2)*(x + 1)^-1", "2"),
        ("tanh(x + x)", "tanh(2*x)"),
        ("0*x", "0"),
        ("z*(y - x) + z*(x - y)", "0"),
        ("(x - 1/3)*z + z*(1 - 3*x)/3", "0"),
    ] {
        assert_eq!(simplified(text), short, "{text}");
    }
}

#[test]
fn what_has_no_shorter_form_is_kept() {
    // Where sqrt(x²) is |x|, and 1/0 has no value.
    for text in [
        "sqrt(x^2)",
        "sin(x)^2 + cos(y)^2",
        "2*sin(x)^2 + cos(x)^2",
        "sign(x)^2",
        "x*(y + z)",
        "z*(y - x)",
        "z*(6*x + 4*y)",
        "z*(4*x - 1/3)",
    ] {
        assert_eq!(simplified(text), text);
    }
}

#[test]
fn order_depends_on_names_not_on_history() {
    let text = "c*x10 + b*x2^2 + sin(a)*x2 - 3 + a*b*c + x2/c";
    let expected = simplified(text);
    assert_eq!(expected, "a*b*c + b*x2^2 + c*x10 + x2*sin(a) + x2/c - 3");
    for first in [["x2", "x10", "a", "b", "c"], ["c", "b", "a", "x10", "x2"]] {
        let mut p = Pool::new();
        for n in first {
            let e = p.var(n);
            p.sin(e);
        }
        let e = p.parse(text).unwrap();
        let s = p.simplify(e);
        assert_eq!(p.text(s), expected);
    }
}

#[test]
fn expand_multiplies_out() {
    for (text, expanded) in [
        ("x*(y + z)", "x*y + x*z"),
        ("(x + 1)^3", "x^3 + 3*x^2 + 3*x + 1"),
        ("(a + b)*(a^2 - a*b + b^2)", "a^3 + b^3"),
        ("sin(x*(x + 1))", "sin(x^2 + x)"),
        ("(x + y)/z", "x/z + y/z"),
        ("1/(x + y)^2", "(x + y)^-2"),
    ] {
        let mut p = Pool::new();
        let (e, reference) = (p.parse(text).unwrap(), p.parse(expanded).unwrap());
        let s = p.expand(e);
        let reference = p.expand(reference);
        assert_eq!(s, reference, "{text} = {}", p.text(s));
    }
}

#[test]
fn expand_keeps_a_factor_that_would_be_too_long() {
    let mut p = Pool::new();
    let sum: Vec<String> = (0..10).map(|i| format!("x{i}")).collect();
    let text = format!("({})^20", sum.join(" + "));
    let e = p.parse(&text).unwrap();
    let s = p.expand(e);
    assert!(p.reachable(&[s]).len() < 20_000);
    // (x0 + …)^20 at x_i = 1 is 10^20.
    let arguments: Vec<_> = (0..10).map(|i| p.symbol(&format!("x{i}"))).collect();
    let tape = Tape::compile(&p, &arguments, &[s]).unwrap();
    let mut out = [0.0];
    tape.eval(&[1.0; 10], &mut Vec::new(), &mut out);
    assert!((out[0] / 1e20 - 1.0).abs() < 1e-12);
}

#[test]
fn deep_and_shared_expressions_are_simplified_in_reasonable_time() {
    let mut p = Pool::new();
    let (x, y) = (p.var("x"), p.var("y"));
    // Fibonacci sums: flattened term by term they would have 2^60 terms.
    let (mut a, mut b) = (x, y);
    for _ in 0..60 {
        let next = p.add(a, b);
        (a, b) = (b, next);
    }
    let s = p.simplify(b);
    assert_eq!(p.text(s), "1548008755920*x + 2504730781961*y");
    let mut e = x;
    for _ in 0..5000 {
        e = p.sin(e);
        e = p.add(e, y);
    }
    let s = p.simplify(e);
    assert_eq!(p.reachable(&[s]).len(), p.reachable(&[e]).len());
}

/// One of the operations that are smooth and bounded enough for a numeric comparison.
fn step(p: &mut Pool, kind: u32, a: Expr, b: Expr) -> Expr {
    match kind % 19 {
        0 => p.sin(a),
        1 => p.cos(a),
        2 => p.call(Func::Tanh, a),
        3 => p.call(Func::Abs, a),
        4 => p.call2(Func2::Max, a, b),
        // Not √a², which would turn rounding errors of size ε into √ε.
        5 => {
            let (s, one) = (p.powi(a, 2), p.int(1));
            let s = p.add(s, one);
            p.sqrt(s)
        }
        6 => {
            let one = p.int(1);
            let s = p.powi(a, 2);
            let d = p.add(one, s);
            p.div(b, d)
        }
        7 => p.powi(a, 2),
        8 => {
            let (s, c) = (p.sin(a), p.cos(a));
            let (s, c) = (p.powi(s, 2), p.powi(c, 2));
            let s = p.mul(s, b);
            let c = p.mul(c, b);
            p.add(s, c)
        }
        9 => p.call(Func::Exp, a),
        10 | 11 => {
            let (s, one) = (p.powi(a, 2), p.int(1));
            let s = p.add(s, one);
            if kind % 19 == 10 { p.call(Func::Log, s) } else { p.pow(s, b) }
        }
        12 | 13 => p.add(a, b),
        14 | 15 => p.sub(a, b),
        _ => p.mul(a, b),
    }
}

fn random_expression(p: &mut Pool, steps: &[(u32, usize, usize)]) -> Expr {
    let mut made: Vec<Expr> = ["x", "y", "z"].map(|n| p.var(n)).to_vec();
    made.extend([p.int(2), p.ratio(-1, 3)]);
    for &(kind, a, b) in steps {
        let (a, b) = (made[made.len() - 1 - a % made.len().min(6)], made[b % made.len()]);
        let e = step(p, kind, a, b);
        made.push(e);
    }
    made[made.len() - 1]
}

/// Compares at one point, relative to the largest number on the way.
fn assert_same_value(p: &mut Pool, a: Expr, b: Expr, x: [f64; 3]) {
    let arguments = ["x", "y", "z"].map(|n| p.symbol(n));
    let tape = Tape::compile(p, &arguments, &[a, b]).unwrap();
    let (mut work, mut out) = (Vec::new(), [0.0; 2]);
    tape.eval(&x, &mut work, &mut out);
    let largest = work.iter().fold(1.0f64, |m, v| m.max(v.abs()));
    if largest < 1e6 {
        assert!((out[0] - out[1]).abs() <= 1e-9 * largest, "{} ≠ {} at {x:?}: {out:?}", p.text(a), p.text(b));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn simplify_keeps_the_value_is_idempotent_and_never_enlarges(
        steps in prop::collection::vec((any::<u32>(), 0usize..100, 0usize..100), 1..22),
        points in prop::collection::vec(prop::array::uniform3(-1.5f64..1.5), 4),
    ) {
        let mut p = Pool::new();
        let e = random_expression(&mut p, &steps);
        let s = p.simplify(e);
        for x in points {
            assert_same_value(&mut p, e, s, x);
        }
        prop_assert_eq!(p.simplify(s), s, "{} then {}", p.text(e), p.text(s));
        prop_assert!(p.reachable(&[s]).len() <= p.reachable(&[e]).len());
    }

    #[test]
    fn expand_keeps_the_value(
        steps in prop::collection::vec((any::<u32>(), 0usize..100, 0usize..100), 1..14),
        points in prop::collection::vec(prop::array::uniform3(-1.5f64..1.5), 4),
    ) {
        let mut p = Pool::new();
        let e = random_expression(&mut p, &steps);
        let s = p.expand(e);
        for x in points {
            assert_same_value(&mut p, e, s, x);
        }
    }

    #[test]
    fn the_printed_result_does_not_depend_on_what_was_made_before(
        steps in prop::collection::vec((any::<u32>(), 0usize..100, 0usize..100), 1..16),
        before in prop::collection::vec((any::<u32>(), 0usize..100, 0usize..100), 0..16),
    ) {
        let mut fresh = Pool::new();
        let e = random_expression(&mut fresh, &steps);
        let s = fresh.simplify(e);
        let mut used = Pool::new();
        for n in ["z", "y", "x"] {
            used.var(n);
        }
        random_expression(&mut used, &before);
        let f = random_expression(&mut used, &steps);
        let t = used.simplify(f);
        prop_assert_eq!(fresh.text(s), used.text(t));
    }
}

#[test]
fn nested_products_of_sums_are_not_written_out() {
    let mut p = Pool::new();
    let (x, y, z) = (p.var("x"), p.var("y"), p.var("z"));
    let third = p.ratio(1, 3);
    let mut e = x;
    // Each level uses the one before twice: written out it would have 2^60 parts.
    for _ in 0..60 {
        let twice = p.add(e, e);
        let (a, b) = (p.add(twice, y), p.add(e, x));
        let ab = p.mul(a, b);
        let scaled = p.mul(third, z);
        e = p.mul(scaled, ab);
    }
    let s = p.simplify(e);
    assert!(p.reachable(&[s]).len() <= p.reachable(&[e]).len());
    assert_eq!(p.simplify(s), s);
}
