//! Printing and parsing are inverse: what is printed reads back as the same expression.

use crate::common::{Kind, cases, generator, point, random, value_and_size};
use bracketry_symbolic::{Bindings, Pool};
use proptest::prelude::*;

proptest! {
    #![proptest_config(cases(500))]

    /// A multiplied-out expression reads back as itself: the same node of the same pool.
    #[test]
    fn parsing_what_was_printed_is_the_identity(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 5, Kind::Any);
        let s = p.expand(e);
        // A quotient by zero has no text that is allowed.
        let Ok(again) = p.parse(&p.text(s)) else {
            prop_assert!(p.text(s).contains("/0") || p.text(s).contains("0^"), "{}", p.text(s));
            return Ok(());
        };
        prop_assert_eq!(p.expand(again), s, "{}", p.text(s));
        // And printing what was parsed gives the same text, whatever pool it is read in.
        let mut q = Pool::new();
        let other = q.parse(&p.text(s)).unwrap();
        let other = q.expand(other);
        prop_assert_eq!(q.text(other), p.text(s));
    }

    /// Any expression reads back as one with the same multiplied-out form and the same values.
    #[test]
    fn any_text_reads_back_up_to_the_order_of_operations(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 5, Kind::Any);
        let Ok(again) = p.parse(&p.text(e)) else {
            prop_assert!(p.text(e).contains("/0") || p.text(e).contains("0^"), "{}", p.text(e));
            return Ok(());
        };
        prop_assert_eq!(p.expand(again), p.expand(e), "{}", p.text(e));
        let x = point(&mut rng);
        let (v, size) = value_and_size(&mut p, e, x);
        if size < 1e6 && Kind::of(&p, e) == Kind::Smooth {
            let (w, _) = value_and_size(&mut p, again, x);
            prop_assert!((v - w).abs() <= 1e-9 * size * size, "{}: {v} {w}", p.text(e));
        }
    }

    /// The size that is found from the structure is that of what is printed.
    #[test]
    fn the_size_of_a_text_is_known_without_it(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 6, Kind::Any);
        for e in [e, p.expand(e), p.simplify(e)] {
            let (size, text) = (p.text_size(e), p.text(e));
            let found = (size.length as usize, size.quotients as usize, size.negative);
            prop_assert_eq!(found, (text.len(), text.matches('/').count(), text.starts_with('-')), "{}", text);
        }
    }

    /// LaTeX is balanced, names no internal node, and depends on the structure only.
    #[test]
    fn latex_is_well_formed(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 5, Kind::Any);
        let s = p.latex(e);
        let mut depth = 0;
        for c in s.replace("\\{", "").replace("\\}", "").chars() {
            depth += i32::from(c == '{') - i32::from(c == '}');
            prop_assert!(depth >= 0, "{}", s);
        }
        prop_assert_eq!(depth, 0, "{}", s);
        prop_assert_eq!(s.matches("\\left").count(), s.matches("\\right").count(), "{}", s);
        for wrong in ["--", "+ -", "- -", "{}", "^{1}", " 1 ", "\\frac{}{"] {
            prop_assert!(!s.contains(wrong), "{} in {}", wrong, s);
        }
        let mut q = Pool::new();
        let f = q.import(&p.export(&[e])).unwrap()[0];
        prop_assert_eq!(q.latex(f), s);
    }
}

#[test]
fn what_is_shared_is_measured_once() {
    let mut p = Pool::new();
    let (mut e, one) = (p.var("x"), p.int(1));
    for _ in 0..200 {
        let next = p.add(e, one);
        e = p.call(bracketry_symbolic::Func::Sin, next);
        e = p.mul(e, next);
    }
    assert!(p.text_size(e).length > 1 << 60);
}

#[test]
fn awkward_forms_read_back() {
    for text in [
        "-x^2",
        "(-x)^2",
        "-(x + y)^2",
        "2^-x",
        "x^-2",
        "x^(-2/3)",
        "(-8)^(1/3)",
        "(-2)^x",
        "(1/3)^x",
        "0.1^x",
        "x^y^z",
        "(x^y)^z",
        "1/(x*y)",
        "x/y/z",
        "x/(y/z)",
        "-x/y",
        "-(x/y)",
        "x - (y - z)",
        "-(-x)",
        "1 - x",
        "-1 - x",
        "2/3 - x",
        "x*-3",
        "x/-3",
        "-1/x",
        "-2/(3*x)",
        "sqrt(x)/sqrt(y)",
        "1/sqrt(x)",
        "x^(3/2)",
        "x^(-1/2)",
        "pi^2/6",
        "-pi",
        "exp(-x^2)",
        "atan2(-y, -x)",
        "min(-x, max(y, 3))",
        "sign(-x)",
        "1e-9*x",
        "123456789.000001*x",
        "x/7e3",
        "exp(1)^x",
        "(x + 1)^(y + 1)",
        "((x + y)*(x - y))^2",
        "sin(x)^2*cos(x)^-2",
        "abs(x)^3",
        "-sin(-x)",
    ] {
        let mut p = Pool::new();
        let e = p.parse(text).unwrap();
        let printed = p.text(e);
        let again = p.parse(&printed).unwrap();
        assert_eq!(p.expand(again), p.expand(e), "{text} prints as {printed}");
        let d = p.sub(e, again);
        assert!(!p.zero_test(d, &Bindings::new()).is_nonzero(), "{text} prints as {printed}");
    }
}

#[test]
fn what_is_nested_deeply_is_written_once() {
    // A level that is written twice would take 2^150 steps.
    for text in [
        format!("{}x{}", "(".repeat(150), " + 1)^2".repeat(150)),
        format!("{}x{}", "sqrt(".repeat(150), " + 1)".repeat(150)),
    ] {
        let mut p = Pool::new();
        let e = p.parse(&text).unwrap();
        let printed = p.text(e);
        assert_eq!(p.parse(&printed).unwrap(), e);
    }
}

#[test]
fn constants_that_grow_without_end_are_refused() {
    // Kept exactly, the products of the first would fill 60 gigabytes, the sums of the second a gigabyte and more.
    let mut p = Pool::new();
    for text in [vec!["9e300"; 30_000].join("*"), format!("{}{}", "9".repeat(20_000), " + 1".repeat(100_000))] {
        let e = p.parse(&text).unwrap_err();
        assert!(e.message.contains("binary digits") && !e.remedy.is_empty(), "{e}");
    }
    assert!(p.len() < 1000);
    // Beyond the numbers of f64 there is room for what cancels.
    let e = p.parse("9e300^5/9e300^4 - 9e300 + x").unwrap();
    assert_eq!(p.text(e), "x");
}
