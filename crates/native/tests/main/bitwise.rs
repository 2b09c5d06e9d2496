//! Machine code, the tape and Rust's own arithmetic give the same bits.

use bracketry_native::{Backend, Function, Workspace};
use bracketry_symbolic::{Expr, Func, Func2, Pool, Tape};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng, rngs::StdRng};

const SPECIAL: [f64; 17] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -2.5,
    3.0e-5,
    1e300,
    -1e300,
    f64::MIN_POSITIVE,
    5e-324,
    -1e-310,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    std::f64::consts::PI,
    f64::MAX,
];

fn native(tape: &Tape) -> Function {
    let f = Function::with_backend(tape.clone(), Backend::Native).unwrap();
    assert_eq!(f.backend(), Backend::Native);
    f
}

fn assert_same_bits(a: f64, b: f64, context: impl Fn() -> String) {
    assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "{a:?} and {b:?}: {}", context());
}

fn assert_equals_tape(tape: &Tape, f: &Function, x: &[f64]) {
    let (mut expected, mut got) = (vec![0.0; tape.n_outputs()], vec![1.25; tape.n_outputs()]);
    tape.eval(x, &mut Vec::new(), &mut expected);
    f.call(x, &mut Workspace::default(), &mut got);
    for (k, (e, g)) in expected.iter().zip(&got).enumerate() {
        assert_same_bits(*e, *g, || format!("result {k} at {x:?}"));
    }
}

/// One of every operation on earlier expressions.
fn step(p: &mut Pool, kind: u32, a: Expr, b: Expr) -> Expr {
    match kind % 24 {
        0..13 => p.call(Func::ALL[kind as usize % 24].0, a),
        13 => p.call2(Func2::Atan2, a, b),
        14 => p.call2(Func2::Min, a, b),
        15 => p.call2(Func2::Max, a, b),
        16 | 17 => p.add(a, b),
        18 => p.sub(a, b),
        19 | 20 => p.mul(a, b),
        21 => p.div(a, b),
        22 => p.sqrt(a),
        _ => p.pow(a, b),
    }
}

/// Expressions of `x`, `y`, `z`, the last `outputs` of a random sequence of operations.
fn random_tape(steps: &[(u32, usize, usize)], outputs: usize) -> Tape {
    let mut p = Pool::new();
    let arguments = ["x", "y", "z"].map(|n| p.symbol(n));
    let mut made: Vec<Expr> = arguments.iter().map(|&s| p.sym(s)).collect();
    made.extend([p.int(0), p.int(2), p.ratio(-1, 3), p.pi()]);
    for &(kind, a, b) in steps {
        // Near the end, so that expressions get deep.
        let (a, b) = (made[made.len() - 1 - a % made.len().min(12)], made[b % made.len()]);
        let e = step(&mut p, kind, a, b);
        made.push(e);
    }
    let outputs = &made[made.len() - outputs.min(made.len())..];
    Tape::compile(&p, &arguments, outputs).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_expressions_equal_the_tape(
        steps in prop::collection::vec((any::<u32>(), 0usize..1000, 0usize..1000), 0..60),
        outputs in 1usize..12,
        points in prop::collection::vec(prop::array::uniform3(any::<f64>()), 4),
        near in prop::collection::vec(prop::array::uniform3(-4.0f64..4.0), 8),
        special in prop::collection::vec(prop::array::uniform3(prop::sample::select(SPECIAL.to_vec())), 12),
    ) {
        let tape = random_tape(&steps, outputs);
        let f = native(&tape);
        for x in points.iter().chain(&near).chain(&special) {
            assert_equals_tape(&tape, &f, x);
        }
    }
}

#[test]
fn single_operations_equal_rust() {
    type Reference = (&'static str, fn(f64, f64) -> f64);
    let cases: [Reference; 26] = [
        ("x + y", |x, y| x + y),
        ("x - y", |x, y| x - y),
        ("x*y", |x, y| x * y),
        ("x/y", |x, y| x / y),
        ("-x", |x, _| -x),
        ("sqrt(x)", |x, _| x.sqrt()),
        ("x^2", |x, _| x * x),
        ("x^y", f64::powf),
        ("abs(x)", |x, _| x.abs()),
        ("sign(x)", |x, _| if x == 0.0 || x.is_nan() { x } else { x.signum() }),
        ("min(x, y)", |x, y| if x.is_nan() || x < y { x } else { y }),
        ("max(x, y)", |x, y| if x.is_nan() || x > y { x } else { y }),
        ("atan2(x, y)", f64::atan2),
        ("sin(x)", |x, _| x.sin()),
        ("cos(x)", |x, _| x.cos()),
        ("tan(x)", |x, _| x.tan()),
        ("asin(x)", |x, _| x.asin()),
        ("acos(x)", |x, _| x.acos()),
        ("atan(x)", |x, _| x.atan()),
        ("sinh(x)", |x, _| x.sinh()),
        ("cosh(x)", |x, _| x.cosh()),
        ("tanh(x)", |x, _| x.tanh()),
        ("exp(x)", |x, _| x.exp()),
        ("log(x)", |x, _| x.ln()),
        ("pi", |_, _| std::f64::consts::PI),
        ("x", |x, _| x),
    ];
    for (text, reference) in cases {
        let mut p = Pool::new();
        let arguments = [p.symbol("x"), p.symbol("y")];
        let e = p.parse(text).unwrap();
        let f = native(&Tape::compile(&p, &arguments, &[e]).unwrap());
        for x in SPECIAL {
            for y in SPECIAL {
                let mut out = [0.0];
                f.call(&[x, y], &mut Workspace::default(), &mut out);
                assert_same_bits(reference(x, y), out[0], || format!("{text} at {x:?}, {y:?}"));
            }
        }
    }
}

#[test]
fn products_and_sums_are_not_fused() {
    let mut p = Pool::new();
    let arguments = [p.symbol("x"), p.symbol("y"), p.symbol("z")];
    let e = p.parse("x*y + z").unwrap();
    let f = native(&Tape::compile(&p, &arguments, &[e]).unwrap());
    let x: f64 = 1.0 + f64::EPSILON;
    let mut out = [0.0];
    f.call(&[x, x, -(x * x)], &mut Workspace::default(), &mut out);
    assert_ne!(x.mul_add(x, -(x * x)), 0.0);
    assert_eq!(out[0], 0.0);
}

#[test]
fn results_may_be_arguments_constants_and_repeated() {
    let mut p = Pool::new();
    let arguments = [p.symbol("x"), p.symbol("y")];
    let [x, e, c] = ["x", "x*y + 2", "0.1"].map(|t| p.parse(t).unwrap());
    let f = native(&Tape::compile(&p, &arguments, &[c, x, e, x, e]).unwrap());
    let mut out = [0.0; 5];
    f.call(&[3.0, 5.0], &mut Workspace::default(), &mut out);
    assert_eq!(out, [0.1, 3.0, 17.0, 3.0, 17.0]);
    let nothing = native(&Tape::compile(&p, &[], &[]).unwrap());
    nothing.call(&[], &mut Workspace::default(), &mut []);
}

#[test]
fn a_tape_of_many_chunks_equals_the_tape() {
    let mut rng = StdRng::seed_from_u64(7);
    let steps: Vec<_> =
        (0..9000).map(|_| (rng.random_range(13..23), rng.random_range(0..1000), rng.random_range(0..9000))).collect();
    let tape = random_tape(&steps, 400);
    assert!(tape.code().len() > 5000, "{} instructions", tape.code().len());
    let f = native(&tape);
    for x in [[0.3, -1.2, 2.0], [1e-3, 4.0, -0.0], [f64::NAN, 1.0, f64::INFINITY]] {
        assert_equals_tape(&tape, &f, &x);
    }
}
