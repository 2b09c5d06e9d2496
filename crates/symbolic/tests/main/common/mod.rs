//! Random expressions for the property tests.

use bracketry_symbolic::{Bindings, Expr, Func, Func2, Node, Pool, Tape, ZeroTest};
use proptest::test_runner::{Config as ProptestConfig, RngSeed};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

/// Which functions a random expression may hold.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    /// Differentiable wherever it has a value.
    Smooth,
    /// `abs`, `sign`, `min`, `max` as well.
    Any,
}

pub(crate) const NAMES: [&str; 3] = ["x", "y", "z"];

/// That many cases, the same ones in every run.
pub(crate) fn cases(n: u32) -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(20_260), failure_persistence: None, ..ProptestConfig::with_cases(n) }
}

pub(crate) fn generator(seed: u64) -> StdRng {
    StdRng::seed_from_u64(seed)
}

/// Random expression in x, y, z whose tree has at most the given depth.
pub(crate) fn random(p: &mut Pool, rng: &mut StdRng, depth: u32, kind: Kind) -> Expr {
    if depth == 0 || rng.random_range(0..8) == 0 {
        return match rng.random_range(0..8) {
            0 => p.int(rng.random_range(-3..5)),
            1 => p.ratio(rng.random_range(-7..8), rng.random_range(1..7)),
            2 => p.pi(),
            _ => p.var(NAMES[rng.random_range(0..3)]),
        };
    }
    let a = random(p, rng, depth - 1, kind);
    match rng.random_range(0..if kind == Kind::Any { 24 } else { 21 }) {
        0..=3 => {
            let b = random(p, rng, depth - 1, kind);
            p.add(a, b)
        }
        4..=7 => {
            let b = random(p, rng, depth - 1, kind);
            p.mul(a, b)
        }
        8 | 9 => {
            let b = random(p, rng, depth - 1, kind);
            p.sub(a, b)
        }
        10 => {
            let b = random(p, rng, depth - 1, kind);
            if p.is_zero(b) { a } else { p.div(a, b) }
        }
        11 => {
            let k = rng.random_range(-3..4);
            if p.is_zero(a) { a } else { p.powi(a, k) }
        }
        12 => {
            let k = p.ratio([1, -1, 3, 1, 2, -2][rng.random_range(0..6)], [2, 2, 2, 3, 3, 3][rng.random_range(0..6)]);
            if p.is_zero(a) { a } else { p.pow(a, k) }
        }
        13 => {
            let b = random(p, rng, depth - 1, kind);
            if p.is_zero(a) { a } else { p.pow(a, b) }
        }
        14 => p.call([Func::Exp, Func::Sinh, Func::Cosh, Func::Tanh][rng.random_range(0..4)], a),
        15 => p.call([Func::Log, Func::Atan, Func::Asin, Func::Acos][rng.random_range(0..4)], a),
        16 => {
            let b = random(p, rng, depth - 1, kind);
            p.call2(Func2::Atan2, a, b)
        }
        17..=20 => p.call([Func::Sin, Func::Cos, Func::Tan][rng.random_range(0..3)], a),
        21 => p.call([Func::Abs, Func::Sign][rng.random_range(0..2)], a),
        _ => {
            let b = random(p, rng, depth - 1, kind);
            p.call2([Func2::Min, Func2::Max][rng.random_range(0..2)], a, b)
        }
    }
}

/// Random arguments.
pub(crate) fn point(rng: &mut StdRng) -> [f64; 3] {
    std::array::from_fn(|_| rng.random_range(0.2..2.5))
}

/// Values of expressions in x, y, z.
pub(crate) fn values(p: &mut Pool, outputs: &[Expr], x: [f64; 3]) -> Vec<f64> {
    let inputs = NAMES.map(|n| p.symbol(n));
    let tape = Tape::compile(p, &inputs, outputs).unwrap();
    let mut out = vec![0.0; outputs.len()];
    tape.eval(&x, &mut Vec::new(), &mut out);
    out
}

/// Value of an expression and the largest of its intermediate results, which bounds the rounding.
pub(crate) fn value_and_size(p: &mut Pool, e: Expr, x: [f64; 3]) -> (f64, f64) {
    let nodes = p.reachable(&[e]);
    let all = values(p, &nodes, x);
    let size = all.iter().fold(1.0_f64, |m, v| if v.is_nan() { f64::NAN } else { m.max(v.abs()) });
    (all[all.len() - 1], size)
}

impl Kind {
    /// What an expression holds.
    pub(crate) fn of(p: &Pool, e: Expr) -> Kind {
        let switches = |&n: &Expr| {
            matches!(p.node(n), Node::Call(Func::Abs | Func::Sign, _) | Node::Call2(Func2::Min | Func2::Max, ..))
        };
        if p.reachable(&[e]).iter().any(switches) { Kind::Any } else { Kind::Smooth }
    }
}

/// Whether an expression, given as text, is zero.
pub(crate) fn test(text: &str) -> ZeroTest {
    let mut p = Pool::new();
    let e = p.parse(text).unwrap();
    p.zero_test(e, &Bindings::new())
}
