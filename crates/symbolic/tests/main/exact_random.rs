//! Random expressions: verdicts against floating-point values, and ranks of random products.

use bracketry_symbolic::{Bindings, Expr, Func, Func2, Node, Pool, Tape, ZeroTest};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

/// Random expression in x, y, z whose tree has at most the given depth.
fn random(p: &mut Pool, rng: &mut StdRng, depth: u32) -> Expr {
    if depth == 0 || rng.random_range(0..8) == 0 {
        return match rng.random_range(0..5) {
            0 => p.int(rng.random_range(1..5)),
            1 => p.ratio(rng.random_range(1..5), rng.random_range(1..4)),
            _ => p.var(["x", "y", "z"][rng.random_range(0..3)]),
        };
    }
    let a = random(p, rng, depth - 1);
    match rng.random_range(0..16) {
        0..=2 => {
            let b = random(p, rng, depth - 1);
            p.add(a, b)
        }
        3..=5 => {
            let b = random(p, rng, depth - 1);
            p.mul(a, b)
        }
        6 => {
            let b = random(p, rng, depth - 1);
            p.sub(a, b)
        }
        7 => {
            let b = random(p, rng, depth - 1);
            p.div(a, b)
        }
        8 => p.powi(a, rng.random_range(-2..4)),
        9 => p.sqrt(a),
        10 => p.call([Func::Exp, Func::Tanh][rng.random_range(0..2)], a),
        11 => p.call(Func::Log, a),
        12 => p.call([Func::Atan, Func::Atan, Func::Asin, Func::Acos][rng.random_range(0..4)], a),
        13 => {
            let b = random(p, rng, depth - 1);
            p.call2(Func2::Atan2, a, b)
        }
        _ => p.call([Func::Sin, Func::Cos, Func::Tan][rng.random_range(0..3)], a),
    }
}

/// The same function of positive arguments, written differently.
fn rewritten(p: &mut Pool, rng: &mut StdRng, e: Expr) -> Expr {
    let v = loop {
        let v = random(p, rng, 1);
        if p.zero_test(v, &Bindings::new()).is_nonzero() {
            break v;
        }
    };
    match p.node(e) {
        Node::Call(Func::Sin, u) => {
            let w = p.sub(u, v);
            let (a, b, c, d) = (p.sin(w), p.cos(v), p.cos(w), p.sin(v));
            let (l, r) = (p.mul(a, b), p.mul(c, d));
            p.add(l, r)
        }
        Node::Call(Func::Cos, u) => {
            let h = p.ratio(1, 2);
            let w = p.mul(h, u);
            let (c, s) = (p.cos(w), p.sin(w));
            let (c, s) = (p.powi(c, 2), p.powi(s, 2));
            p.sub(c, s)
        }
        Node::Call(Func::Tan, u) => {
            let (s, c) = (p.sin(u), p.cos(u));
            p.div(s, c)
        }
        Node::Call(Func::Exp, u) => {
            let w = p.sub(u, v);
            let (a, b) = (p.call(Func::Exp, w), p.call(Func::Exp, v));
            p.mul(a, b)
        }
        Node::Call(Func::Tanh, u) => {
            let (s, c) = (p.call(Func::Sinh, u), p.call(Func::Cosh, u));
            p.div(s, c)
        }
        Node::Call(Func::Log, u) => {
            let w = p.mul(u, v);
            let (a, b) = (p.call(Func::Log, w), p.call(Func::Log, v));
            p.sub(a, b)
        }
        Node::Pow(u, _) => {
            // √u-like powers of positive u v
            let Node::Pow(_, k) = p.node(e) else { unreachable!() };
            let w = p.mul(u, v);
            let (a, b) = (p.pow(w, k), p.pow(v, k));
            p.div(a, b)
        }
        Node::Mul(a, b) => {
            // a b = ((a + b)² − (a − b)²)/4
            let (s, d) = (p.add(a, b), p.sub(a, b));
            let (s, d) = (p.powi(s, 2), p.powi(d, 2));
            let q = p.ratio(1, 4);
            let g = p.sub(s, d);
            p.mul(q, g)
        }
        _ => {
            // e = (e² − v²)/(e − v) − v
            let d = p.sub(e, v);
            if !p.zero_test(d, &Bindings::new()).is_nonzero() {
                return e;
            }
            let (s, t) = (p.powi(e, 2), p.powi(v, 2));
            let n = p.sub(s, t);
            let q = p.div(n, d);
            p.sub(q, v)
        }
    }
}

/// The same function with several sub-expressions rewritten.
fn disguised(p: &mut Pool, rng: &mut StdRng, e: Expr) -> Expr {
    let mut e = e;
    for _ in 0..3 {
        let nodes = p.reachable(&[e]);
        let node = nodes[rng.random_range(0..nodes.len())];
        let new = rewritten(p, rng, node);
        e = p.substitute(e, &[(node, new)].into_iter().collect());
    }
    e
}

/// Values of e and of |e|'s largest intermediate result at random positive points where all is real.
fn values(p: &Pool, e: Expr, rng: &mut StdRng) -> Vec<(f64, f64)> {
    let mut q = p.clone();
    let inputs = [q.symbol("x"), q.symbol("y"), q.symbol("z")];
    let nodes = p.reachable(&[e]);
    let tape = Tape::compile(&q, &inputs, &nodes).unwrap();
    let mut out = Vec::new();
    for _ in 0..40 {
        let x: Vec<f64> = (0..3).map(|_| rng.random_range(0.2..3.0)).collect();
        let mut v = vec![0.0; nodes.len()];
        tape.eval(&x, &mut Vec::new(), &mut v);
        let size = v.iter().fold(1.0_f64, |m, a| m.max(a.abs()));
        // tanh is 1 in floating point far out.
        let far = nodes.iter().any(|&n| match p.node(n) {
            Node::Call(Func::Tanh, a) => nodes.binary_search(&a).is_ok_and(|i| v[i].abs() > 8.0),
            _ => false,
        });
        if v.iter().all(|a| a.is_finite()) && size < 1e5 && !far {
            out.push((v[v.len() - 1], size));
        }
    }
    out
}

/// Zero must look like zero in floating point, and so must not what is called nonzero.
#[test]
fn verdicts_agree_with_floating_point() {
    let (mut zeros, mut nonzeros, mut open) = (0, 0, 0);
    for seed in 0..3000 {
        let mut rng = StdRng::seed_from_u64(seed);
        let mut p = Pool::new();
        let f = random(&mut p, &mut rng, 3);
        let mut g = disguised(&mut p, &mut rng, f);
        let truth = rng.random_range(0..3) > 0;
        if !truth {
            // One leaf or function changed.
            let nodes = p.reachable(&[g]);
            let node = nodes[rng.random_range(0..nodes.len())];
            let new = random(&mut p, &mut rng, 1);
            g = p.substitute(g, &[(node, new)].into_iter().collect());
        }
        let e = p.sub(f, g);
        let text = format!("{} − ({})", p.text(f), p.text(g));
        match p.zero_test(e, &Bindings::new()) {
            ZeroTest::Zero(c) => {
                zeros += 1;
                assert!(c.log10_error < -15.0, "{seed}: {text}: {c}");
                for (v, size) in values(&p, e, &mut rng) {
                    assert!(v.abs() < 1e-7 * size * size, "{seed}: {text} called zero but is {v}");
                }
            }
            ZeroTest::NonZero => {
                nonzeros += 1;
                let v = values(&p, e, &mut rng);
                assert!(!truth || v.is_empty(), "{seed}: {text} called nonzero");
                let seen = v.iter().any(|(v, size)| v.abs() > 1e-11 * size);
                assert!(v.is_empty() || seen, "{seed}: {text} called nonzero but is {v:?}");
            }
            ZeroTest::Unknown(u) => {
                open += 1;
                let _ = u;
            }
        }
    }
    assert!(zeros > 1500 && nonzeros > 600, "{zeros} zero, {nonzeros} nonzero, {open} open");
}

/// rank(A B) for A of m × r, B of r × n with generic entries is r; row operations do not change it.
#[test]
fn ranks_of_products_and_row_operations() {
    for seed in 0..40 {
        let mut rng = StdRng::seed_from_u64(seed);
        let mut p = Pool::new();
        let (m, r, n) = (rng.random_range(1..6), rng.random_range(1..4), rng.random_range(1..6));
        let entry = |p: &mut Pool, rng: &mut StdRng, i: usize, j: usize, name: &str| {
            // A function of its own symbol: entries are algebraically independent.
            let x = p.var(&format!("{name}{i}{j}"));
            match rng.random_range(0..4) {
                0 => p.sin(x),
                1 => p.call(Func::Exp, x),
                2 => p.powi(x, -2),
                _ => x,
            }
        };
        let a: Vec<Vec<Expr>> = (0..m).map(|i| (0..r).map(|j| entry(&mut p, &mut rng, i, j, "a")).collect()).collect();
        let b: Vec<Vec<Expr>> = (0..r).map(|i| (0..n).map(|j| entry(&mut p, &mut rng, i, j, "b")).collect()).collect();
        let mut c: Vec<Vec<Expr>> = a
            .iter()
            .map(|row| {
                (0..n)
                    .map(|j| {
                        let terms: Vec<Expr> = (0..r).map(|k| p.mul(row[k], b[k][j])).collect();
                        p.sum(terms)
                    })
                    .collect()
            })
            .collect();
        let expected = m.min(r).min(n);
        let rank = p.rank(&c, &Bindings::new()).unwrap();
        assert_eq!((rank.rank, rank.independent), (expected, (0..expected).collect()), "{m} × {r} × {n}");
        for _ in 0..3 {
            let (i, j) = (rng.random_range(0..m), rng.random_range(0..m));
            if i != j {
                let f = random(&mut p, &mut rng, 1);
                for k in 0..n {
                    let t = p.mul(f, c[j][k]);
                    c[i][k] = p.add(c[i][k], t);
                }
            }
        }
        assert_eq!(p.rank(&c, &Bindings::new()).unwrap().rank, expected, "{m} × {r} × {n} after row operations");
    }
}
