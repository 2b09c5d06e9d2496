//! Derivatives, printing and evaluation as statements of mathematics.

use approx::assert_relative_eq;
use bracketry_symbolic::{Pool, Tape};

fn derivative(text: &str) -> String {
    let mut p = Pool::new();
    let e = p.parse(text).unwrap();
    let x = p.symbol("x");
    let d = p.diff(e, x);
    p.text(d)
}

#[test]
fn derivatives_of_elementary_functions() {
    for (f, d) in [
        ("log(x)", "1/x"),
        ("x^3", "3*x^2"),
        ("sin(x)", "cos(x)"),
        ("cos(2*x)", "-2*sin(2*x)"),
        ("exp(x)", "exp(x)"),
        ("sqrt(x)", "1/(2*sqrt(x))"),
        ("atan(x)", "1/(1 + x^2)"),
        ("abs(x)", "sign(x)"),
        ("sign(x)", "0"),
    ] {
        let got = derivative(f);
        let mut p = Pool::new();
        let (a, b) = (p.parse(&got).unwrap(), p.parse(d).unwrap());
        assert_eq!(a, b, "d/dx {f} = {got}, expected {d}");
    }
}

#[test]
fn printed_text_reads_back_with_the_same_value() {
    for t in [
        "x^2*sin(x) - 3*y/(2*z)",
        "-x^2",
        "(-x)^2*y^x",
        "x^(y+1)",
        "2^-1*x",
        "x - (y - z)",
        "1/(x*y)",
        "x/y*z",
        "-(x+y)*z",
        "sqrt(x+1)^3",
        "1/sqrt(x)",
        "0.125*x + 1/3",
        "atan2(y, x)*min(x, y) - max(x, -y)",
        "pi*x**2",
        "1e-3*x",
        "(x+y)^2*(x-y)^-2",
        "exp(-x)/7",
        "-2/3",
        "x^(2/3)",
        "x^(-2/3)",
        "3^x",
        "(1/3)^x",
        "x*-3",
    ] {
        let mut p = Pool::new();
        let e = p.parse(t).unwrap();
        let s = p.text(e);
        let again = p.parse(&s).unwrap();
        assert_eq!(s, p.text(again), "{t} prints as {s}");
        let arguments = ["x", "y", "z"].map(|n| p.symbol(n));
        let tape = Tape::compile(&p, &arguments, &[e, again]).unwrap();
        let mut out = [0.0; 2];
        tape.eval(&[1.3, 0.7, 2.1], &mut Vec::new(), &mut out);
        assert_relative_eq!(out[0], out[1], max_relative = 1e-14);
    }
}

#[test]
fn tape_agrees_with_hand_written_code() {
    let mut p = Pool::new();
    let e = p.parse("x^5/(1+y^2) - sqrt(abs(x*y))*tanh(x - 2*y) + atan2(y, x) + y^-3").unwrap();
    let (x, y) = (p.symbol("x"), p.symbol("y"));
    let tape = Tape::compile(&p, &[x, y], &[e]).unwrap();
    let mut work = Vec::new();
    for (x, y) in [(0.3, -1.7), (2.0, 0.4), (-1.1, -0.2)] {
        let f64s: [f64; 2] = [x, y];
        let mut out = [0.0];
        tape.eval(&f64s, &mut work, &mut out);
        let exact = x.powi(5) / (1.0 + y * y) - (x * y).abs().sqrt() * (x - 2.0 * y).tanh() + y.atan2(x) + y.powi(-3);
        assert_relative_eq!(out[0], exact, max_relative = 1e-13);
    }
}

#[test]
fn batch_lanes_equal_single_evaluations() {
    let mut p = Pool::new();
    let e = p.parse("sin(x)*x^3 - exp(x)/x").unwrap();
    let x = p.symbol("x");
    let tape = Tape::compile(&p, &[x], &[e]).unwrap();
    let points = [0.1, -0.7, 3.0, 1e-3];
    let mut out = [[0.0; 4]];
    tape.eval_batch(&[points], &mut Vec::new(), &mut out);
    for (l, &x) in points.iter().enumerate() {
        let mut single = [0.0];
        tape.eval(&[x], &mut Vec::new(), &mut single);
        assert_eq!(single[0].to_bits(), out[0][l].to_bits());
    }
}

#[test]
fn unbound_names_are_refused_by_name() {
    let mut p = Pool::new();
    let e = p.parse("x + k").unwrap();
    let x = p.symbol("x");
    let err = Tape::compile(&p, &[x], &[e]).unwrap_err();
    assert!(err.to_string().contains("`k`"));
}

#[test]
fn deep_expressions_do_not_exhaust_the_stack() {
    let mut p = Pool::new();
    let x = p.symbol("x");
    let mut e = p.sym(x);
    for _ in 0..50_000 {
        let s = p.sin(e);
        let xs = p.sym(x);
        e = p.add(s, xs);
    }
    let d = p.diff(e, x);
    assert!(Tape::compile(&p, &[x], &[d]).is_ok());
}

#[test]
fn malformed_text_names_place_and_remedy() {
    for (text, offset, word) in [
        ("", 0, "empty"),
        ("x +", 3, "early"),
        ("x + )", 4, "operand"),
        ("(x", 2, "`)`"),
        ("x)", 1, "closed"),
        ("2 x", 2, "operator"),
        ("2x", 0, "number is directly followed"),
        ("x $ y", 2, "not part"),
        ("sin", 0, "is a function"),
        ("sin(x, y)", 0, "takes 1"),
        ("atan2(x)", 0, "takes 2"),
        ("sni(x)", 0, "unknown function"),
        ("1/0", 2, "division by zero"),
        ("0^-1", 2, "zero to a negative"),
        ("1e9999", 0, "out of range"),
        ("x ^", 3, "early"),
        ("1.2.3", 0, "number is directly followed"),
        ("x,y", 1, "unexpected text"),
    ] {
        let e = Pool::new().parse(text).unwrap_err();
        assert_eq!(e.offset, offset, "{text}: {e}");
        assert!(e.message.contains(word), "{text}: {e}");
        assert!(!e.remedy.is_empty());
    }
    let deep = "(".repeat(10_000) + "x" + &")".repeat(10_000);
    assert!(Pool::new().parse(&deep).unwrap_err().message.contains("deep"));
}

#[test]
fn what_sharing_hides_is_not_printed_out() {
    let mut p = Pool::new();
    let mut e = p.parse("x + 1").unwrap();
    for _ in 0..60 {
        let c = p.cos(e);
        let square = p.mul(e, c);
        e = p.add(square, e);
    }
    assert!(!p.is_printable(e));
    assert!(p.text(e).contains("nodes, not shown"));
    assert!(p.latex(e).contains("nodes"));
    let mut deep = p.parse("x").unwrap();
    for _ in 0..100_000 {
        deep = p.sin(deep);
    }
    assert!(p.text(deep).contains("nodes, not shown"));
}
