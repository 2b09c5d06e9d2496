//! Normal forms: identities become visible, values stay.

use crate::common::{Kind, cases, generator, point, random, value_and_size};
use bracketry_symbolic::{Bindings, Expr, Pool};
use proptest::prelude::*;

type Form = fn(&mut Pool, Expr) -> Expr;

/// The forms that must not change the value.
const FORMS: [(&str, Form); 6] = [
    ("simplify", Pool::simplify),
    ("expand", Pool::expand),
    ("trig_form", Pool::trig_form),
    ("exp_form", Pool::exp_form),
    ("factor_common", Pool::factor_common),
    ("collect_terms", |p, e| {
        let s = [p.symbol("x"), p.symbol("y")];
        p.collect_terms(e, &s)
    }),
];

proptest! {
    #![proptest_config(cases(150))]

    /// Equal where both have values, in floating point and, where that decides, exactly.
    #[test]
    fn forms_preserve_the_value(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 4, Kind::Any);
        for (name, form) in FORMS {
            let f = form(&mut p, e);
            let d = p.sub(e, f);
            prop_assert!(!p.zero_test(d, &Bindings::new()).is_nonzero(), "{}: {} → {}", name, p.text(e), p.text(f));
            for _ in 0..4 {
                let x = point(&mut rng).map(|v| if seed.is_multiple_of(2) { v } else { v - 1.4 });
                let (v, size) = value_and_size(&mut p, e, x);
                let (w, other) = value_and_size(&mut p, f, x);
                let size = size + other;
                // Where switching functions decide on rounded values, either side is right.
                if size < 1e4 && Kind::of(&p, e) == Kind::Smooth {
                    prop_assert!((v - w).abs() <= 1e-9 * size * size, "{}: {} → {}: {v} {w}", name, p.text(e), p.text(f));
                }
                // A form has a value wherever the expression has one.
                if size.is_nan() && other.is_nan() && v.is_finite() {
                    prop_assert!(w.is_finite() || !value_and_size(&mut p, e, x).1.is_finite(), "{}: {}", name, p.text(e));
                }
            }
        }
    }

    /// Simplifying never adds nodes, and is done after one call.
    #[test]
    fn simplify_is_shorter_and_idempotent(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 4, Kind::Any);
        let s = p.simplify(e);
        prop_assert!(p.reachable(&[s]).len() <= p.reachable(&[e]).len(), "{} → {}", p.text(e), p.text(s));
        prop_assert_eq!(p.simplify(s), s, "{} → {}", p.text(e), p.text(s));
    }

    /// A trigonometric polynomial is zero if and only if its Fourier form is 0.
    #[test]
    fn fourier_forms_are_unique(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let (e, f) = (trigonometric(&mut p, &mut rng, 4), trigonometric(&mut p, &mut rng, 2));
        // The same function written differently: (e + f)² = (e − f)² + 4 e f.
        let (s, d) = (p.add(e, f), p.sub(e, f));
        let (s, d) = (p.powi(s, 2), p.powi(d, 2));
        let four = p.int(4);
        let ef = p.mul(e, f);
        let product = p.mul(four, ef);
        let right = p.add(d, product);
        let zero = p.sub(s, right);
        let zero = p.trig_form(zero);
        prop_assert!(p.is_zero(zero), "{} and {}: {}", p.text(e), p.text(f), p.text(zero));
        let difference = p.sub(e, f);
        let form = p.trig_form(difference);
        prop_assert_eq!(p.is_zero(form), p.zero_test(difference, &Bindings::new()).is_zero());
    }
}

/// Random polynomial of sines and cosines of sums of x, y and multiples of π/6 and π/4.
fn trigonometric(p: &mut Pool, rng: &mut rand::rngs::StdRng, depth: u32) -> Expr {
    use rand::RngExt;
    if depth == 0 {
        let (a, b) = (p.int(rng.random_range(-2..3)), p.int(rng.random_range(-2..3)));
        let (x, y, pi) = (p.var("x"), p.var("y"), p.pi());
        let (ax, by, k) = (p.mul(a, x), p.mul(b, y), p.ratio(rng.random_range(0..24), [6, 4][rng.random_range(0..2)]));
        let (angle, phase) = (p.add(ax, by), p.mul(k, pi));
        let angle = p.add(angle, phase);
        return if rng.random_range(0..2) == 0 { p.sin(angle) } else { p.cos(angle) };
    }
    let (a, b) = (trigonometric(p, rng, depth - 1), trigonometric(p, rng, depth.min(2) - 1));
    match rng.random_range(0..3) {
        0 => p.add(a, b),
        1 => p.sub(a, b),
        _ => p.mul(a, b),
    }
}

fn shown(form: Form, text: &str) -> String {
    let mut p = Pool::new();
    let e = p.parse(text).unwrap();
    let f = form(&mut p, e);
    p.text(f)
}

#[test]
fn trigonometric_identities_become_visible() {
    for (text, form) in [
        ("sin(x)^2 + cos(x)^2", "1"),
        ("sin(2*x) - 2*sin(x)*cos(x)", "0"),
        ("cos(x)^2 - sin(x)^2", "cos(2*x)"),
        ("sin(x)*cos(x)", "0.5*sin(2*x)"),
        ("m*(cos(a)*cos(b) + sin(a)*sin(b))", "m*cos(a - b)"),
        ("sin(b)*cos(a) - sin(a)*cos(b)", "-sin(a - b)"),
        ("sin(a + b + c) - sin(a + b)*cos(c) - cos(a + b)*sin(c)", "0"),
        ("1 + tan(x)^2 - 1/cos(x)^2", "0"),
        ("tan(x)*cos(x)", "sin(x)"),
        ("tan(x/2) - sin(x)/(1 + cos(x))", "0"),
        ("tan(a + b) - (tan(a) + tan(b))/(1 - tan(a)*tan(b))", "0"),
        ("1/(1 - sin(x)) + 1/(1 + sin(x)) - 2/cos(x)^2", "0"),
        ("sqrt(2)*sin(x + pi/4) - sin(x) - cos(x)", "0"),
        ("cos(x + pi) + cos(x - pi/2)", "sin(x) - cos(x)"),
        ("sin(x) + sin(x + 2*pi/3) + sin(x - 2*pi/3)", "0"),
        ("cos(7*pi/3) + sin(pi/4)^2", "1"),
        ("exp(sin(x)^2 + cos(x)^2)*y", "y*exp(1)"),
        ("sqrt(1 - cos(2*x) - 2*sin(x)^2 + y)", "sqrt(y)"),
        ("x*y + 1", "x*y + 1"),
    ] {
        assert_eq!(shown(Pool::trig_form, text), form, "{text}");
    }
}

#[test]
fn exponential_identities_become_visible() {
    for (text, form) in [
        ("exp(a)*exp(a)", "exp(2*a)"),
        ("exp(a)*exp(b)/exp(a + b)", "1"),
        ("cosh(x)^2 - sinh(x)^2", "1"),
        ("cosh(x) + sinh(x)", "exp(x)"),
        ("tanh(x)^2 + 1/cosh(x)^2", "1"),
        ("tanh(x + y) - (tanh(x) + tanh(y))/(1 + tanh(x)*tanh(y))", "0"),
        ("tanh(2*x) - 2*tanh(x)/(1 + tanh(x)^2)", "0"),
        ("1/(exp(x) + exp(-x)) - exp(x)/(exp(2*x) + 1)", "0"),
        ("x^a*x^b", "x^(a + b)"),
        ("x^(a + 1) - x*x^a", "0"),
        ("exp(2*log(x) + y)", "x^2*exp(y)"),
        ("log(exp(x)*3)", "x + log(3)"),
        ("log(8) - 3*log(2)", "0"),
        ("log(12/5)", "2*log(2) + log(3) - log(5)"),
        ("log(x^3)", "3*log(x)"),
        ("log(x^2)", "2*log(abs(x))"),
        ("log(cosh(x)*y) - log(y)", "log(exp(x) + exp(-x)) - log(2)"),
        ("log(x*y) - log(x) - log(y)", "log(x*y) - log(x) - log(y)"),
        ("log(-x)", "log(-x)"),
    ] {
        assert_eq!(shown(Pool::exp_form, text), form, "{text}");
    }
}

#[test]
fn simplify_takes_the_shortest_form() {
    for (text, form) in [
        ("m*l^2*w*sin(q)*cos(q) - m*l^2*w*sin(2*q)/2", "0"),
        ("l1*l2*m*w^2*(cos(a)*cos(b) + sin(a)*sin(b))", "l1*l2*m*w^2*cos(a - b)"),
        ("sin(x)*cos(x)", "sin(x)*cos(x)"),
        ("cosh(x)^2 - sinh(x)^2 + y", "y + 1"),
        ("tan(x) + 1/tan(x)", "tan(x) + 1/tan(x)"),
        ("(a*sin(q) + b*cos(q))^2 + (a*cos(q) - b*sin(q))^2", "a^2 + b^2"),
        ("log(x*y)", "log(x*y)"),
        ("cos(x)^3", "cos(x)^3"),
    ] {
        assert_eq!(shown(Pool::simplify, text), form, "{text}");
    }
}

#[test]
fn common_factors_come_out() {
    for (text, form) in [
        ("x*y + x*z", "x*(y + z)"),
        ("6*x^2*y - 4*x*y^2", "2*x*y*(3*x - 2*y)"),
        ("x/z + y/z", "(x + y)/z"),
        ("x^2/z^2 + y/z", "(y + x^2/z)/z"),
        ("sin(x*y + x)*a + sin(x*y + x)*b", "sin(x*(y + 1))*(a + b)"),
        ("x + y", "x + y"),
        ("m*g*sin(q) + m*w", "m*(w + g*sin(q))"),
        ("x^3 + x", "x*(x^2 + 1)"),
    ] {
        let mut p = Pool::new();
        let (e, f) = (p.parse(text).unwrap(), p.parse(form).unwrap());
        let got = p.factor_common(e);
        let d = p.sub(got, f);
        assert!(p.zero_test(d, &Bindings::new()).is_zero());
        // The same up to the order of operands.
        let sorted = |s: String| {
            let mut c: Vec<char> = s.chars().collect();
            c.sort_unstable();
            c
        };
        assert_eq!(sorted(p.text(got)), sorted(form.to_owned()), "{text}: {}", p.text(got));
    }
}

/// Long products are left alone rather than written out.
#[test]
fn forms_have_a_bound() {
    let mut p = Pool::new();
    let factors: Vec<String> = (0..20).map(|i| format!("(sin(a{i}) + cos(b{i}))")).collect();
    let e = p.parse(&factors.join("*")).unwrap();
    for (_, form) in FORMS {
        let f = form(&mut p, e);
        assert!(p.reachable(&[f]).len() < 5000);
    }
    let mut deep = p.parse("sin(x)").unwrap();
    for _ in 0..3000 {
        let (s, c) = (p.sin(deep), p.cos(deep));
        deep = p.mul(s, c);
    }
    assert_eq!(p.trig_form(deep), deep);
}
