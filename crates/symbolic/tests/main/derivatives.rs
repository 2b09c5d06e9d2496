//! Derivatives against finite differences and dual numbers, and the rules they obey.

use crate::common::{Kind, NAMES, cases, generator, point, random, value_and_size, values};
use bracketry_symbolic::{Bindings, Expr, Func, Func2, Node, Pool, Symbol};
use proptest::prelude::*;
use rustc_hash::FxHashMap;

/// a + b ε with ε² = 0 (Clifford 1873): arithmetic of values with their derivatives.
#[derive(Clone, Copy, Debug)]
struct Dual(f64, f64);

/// e with its derivative along `direction`, by dual arithmetic over the nodes.
fn dual(p: &Pool, e: Expr, x: [f64; 3], direction: [f64; 3]) -> Dual {
    let mut known: FxHashMap<Expr, Dual> = FxHashMap::default();
    for n in p.reachable(&[e]) {
        let d = match p.node(n) {
            Node::Num(_) => Dual(p.number(n).unwrap().to_f64().value(), 0.0),
            Node::Pi => Dual(std::f64::consts::PI, 0.0),
            Node::Sym(s) => {
                let i = NAMES.iter().position(|n| *n == p.name(s)).unwrap();
                Dual(x[i], direction[i])
            }
            Node::Add(a, b) => Dual(known[&a].0 + known[&b].0, known[&a].1 + known[&b].1),
            Node::Mul(a, b) => {
                let (a, b) = (known[&a], known[&b]);
                Dual(a.0 * b.0, a.0 * b.1 + a.1 * b.0)
            }
            Node::Pow(a, b) => {
                let (a, b) = (known[&a], known[&b]);
                let v = a.0.powf(b.0);
                let base = if a.1 == 0.0 { 0.0 } else { b.0 * a.0.powf(b.0 - 1.0) * a.1 };
                let exponent = if b.1 == 0.0 { 0.0 } else { v * a.0.ln() * b.1 };
                Dual(v, base + exponent)
            }
            Node::Call(f, a) => {
                let Dual(v, d) = known[&a];
                let slope = match f {
                    Func::Sin => v.cos(),
                    Func::Cos => -v.sin(),
                    Func::Tan => v.cos().powi(-2),
                    Func::Asin => (1.0 - v * v).sqrt().recip(),
                    Func::Acos => -(1.0 - v * v).sqrt().recip(),
                    Func::Atan => (1.0 + v * v).recip(),
                    Func::Sinh => v.cosh(),
                    Func::Cosh => v.sinh(),
                    Func::Tanh => v.cosh().powi(-2),
                    Func::Exp => v.exp(),
                    Func::Log => v.recip(),
                    Func::Abs => v.signum(),
                    Func::Sign => 0.0,
                };
                Dual(f.eval(v), if d == 0.0 { 0.0 } else { slope * d })
            }
            Node::Call2(f, a, b) => {
                let (a, b) = (known[&a], known[&b]);
                match f {
                    Func2::Atan2 => Dual(a.0.atan2(b.0), (b.0 * a.1 - a.0 * b.1) / (a.0 * a.0 + b.0 * b.0)),
                    Func2::Min => {
                        if a.0 < b.0 {
                            a
                        } else {
                            b
                        }
                    }
                    Func2::Max => {
                        if a.0 > b.0 {
                            a
                        } else {
                            b
                        }
                    }
                }
            }
        };
        known.insert(n, d);
    }
    known[&e]
}

fn names(p: &mut Pool) -> [Symbol; 3] {
    NAMES.map(|n| p.symbol(n))
}

/// True unless the difference is certainly not zero; and zero where both are numbers.
fn same(p: &mut Pool, a: Expr, b: Expr) -> bool {
    let d = p.sub(a, b);
    !p.zero_test(d, &Bindings::new()).is_nonzero()
}

/// Numbers a and b agree, for intermediate results of this size.
fn close(a: f64, b: f64, size: f64) -> bool {
    // Beyond this size, or where there is no value, rounding tells nothing.
    size.is_nan() || size > 1e4 || (a - b).abs() <= 1e-8 * size * size
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn derivatives_agree_with_dual_numbers(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 5, Kind::Any);
        let x = point(&mut rng);
        for (i, s) in names(&mut p).into_iter().enumerate() {
            let d = p.diff(e, s);
            let (v, size) = value_and_size(&mut p, d, x);
            let (_, below) = value_and_size(&mut p, e, x);
            let mut direction = [0.0; 3];
            direction[i] = 1.0;
            let expected = dual(&p, e, x, direction);
            prop_assert!(close(v, expected.1, size + below + expected.1.abs()), "{}: {v} {expected:?}", p.text(e));
        }
    }

    /// Central differences at two widths; where these agree with each other, the derivative agrees with them.
    #[test]
    fn derivatives_agree_with_finite_differences(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let e = random(&mut p, &mut rng, 4, Kind::Smooth);
        let x = point(&mut rng);
        for (i, s) in names(&mut p).into_iter().enumerate() {
            let d = p.diff(e, s);
            let (v, size) = value_and_size(&mut p, d, x);
            let mut slope = |h: f64| {
                let at = |p: &mut Pool, h: f64| {
                    let mut y = x;
                    y[i] += h;
                    values(p, &[e], y)[0]
                };
                (at(&mut p, h) - at(&mut p, -h)) / (2.0 * h)
            };
            let (wide, narrow) = (slope(2e-4), slope(1e-4));
            // Rounding of a large value hides its change.
            let (_, below) = value_and_size(&mut p, e, x);
            if below * f64::EPSILON > 1e-4 * 1e-6 {
                continue;
            }
            if size < 1e3 && (wide - narrow).abs() < 1e-6 * (1.0 + narrow.abs()) {
                prop_assert!((narrow - v).abs() < 1e-4 * (1.0 + size), "{}: {v} {narrow}", p.text(e));
            }
        }
    }

    /// (fg)' = f'g + fg', (f + g)' = f' + g', and partial derivatives commute.
    #[test]
    fn leibniz_rule_and_symmetry(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let (f, g) = (random(&mut p, &mut rng, 3, Kind::Smooth), random(&mut p, &mut rng, 3, Kind::Smooth));
        let [x, y, _] = names(&mut p);
        let (df, dg, fg) = (p.diff(f, x), p.diff(g, x), p.mul(f, g));
        let dfg = p.diff(fg, x);
        let (a, b) = (p.mul(df, g), p.mul(f, dg));
        let sum = p.add(a, b);
        prop_assert!(same(&mut p, dfg, sum), "({})*({})", p.text(f), p.text(g));
        let s = p.add(f, g);
        let (ds, sum) = (p.diff(s, x), p.add(df, dg));
        prop_assert!(same(&mut p, ds, sum));
        let dfy = p.diff(f, y);
        let (xy, yx) = (p.diff(df, y), p.diff(dfy, x));
        prop_assert!(same(&mut p, xy, yx), "{}", p.text(f));
    }

    /// d/dx f(g(x), y) = f_1(g, y) g'.
    #[test]
    fn chain_rule(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let (f, g) = (random(&mut p, &mut rng, 3, Kind::Smooth), random(&mut p, &mut rng, 2, Kind::Smooth));
        let [x, y, z] = names(&mut p);
        // f in x, y; g in x.
        let (ex, ey) = (p.sym(x), p.sym(y));
        let Ok(f) = p.at(f, &[(z, ey)]) else { return Ok(()) };
        let Ok(g) = p.at(g, &[(y, ex), (z, ex)]) else { return Ok(()) };
        let Ok(composed) = p.at(f, &[(x, g)]) else { return Ok(()) };
        let left = p.diff(composed, x);
        let (f1, dg) = (p.diff(f, x), p.diff(g, x));
        let Ok(outer) = p.at(f1, &[(x, g)]) else { return Ok(()) };
        let right = p.mul(outer, dg);
        prop_assert!(same(&mut p, left, right), "({}) after ({})", p.text(f), p.text(g));
    }

    /// L_v e is the derivative along v, is linear over functions, and L_v(fg) = f L_v g + g L_v f.
    #[test]
    fn lie_derivatives(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let s = names(&mut p);
        let (f, g) = (random(&mut p, &mut rng, 3, Kind::Smooth), random(&mut p, &mut rng, 2, Kind::Smooth));
        let v: [Expr; 3] = std::array::from_fn(|_| random(&mut p, &mut rng, 2, Kind::Smooth));
        let l = p.lie_derivative(f, &s, &v);
        // Against dual numbers along the value of the field.
        let x = point(&mut rng);
        let at = values(&mut p, &v, x);
        let (value, size) = value_and_size(&mut p, l, x);
        let (_, below) = value_and_size(&mut p, f, x);
        let expected = dual(&p, f, x, [at[0], at[1], at[2]]);
        prop_assert!(close(value, expected.1, size + below + expected.1.abs()), "{}: {value} {expected:?}", p.text(f));
        let scaled = v.map(|c| p.mul(g, c));
        let (left, right) = (p.lie_derivative(f, &s, &scaled), p.mul(g, l));
        prop_assert!(same(&mut p, left, right));
        let fg = p.mul(f, g);
        let (left, lg) = (p.lie_derivative(fg, &s, &v), p.lie_derivative(g, &s, &v));
        let (a, b) = (p.mul(f, lg), p.mul(g, l));
        let right = p.add(a, b);
        prop_assert!(same(&mut p, left, right), "{} and {}", p.text(f), p.text(g));
    }

    /// The Hessian is the Jacobian of the gradient.
    #[test]
    fn hessians(seed: u64) {
        let (mut p, mut rng) = (Pool::new(), generator(seed));
        let s = names(&mut p);
        let f = random(&mut p, &mut rng, 3, Kind::Smooth);
        let (h, g) = (p.hessian(f, &s), p.gradient(f, &s));
        let j = p.jacobian(&g, &s);
        for i in 0..3 {
            for k in 0..3 {
                prop_assert!(same(&mut p, h[i][k], j[i][k]), "{}", p.text(f));
            }
        }
    }
}
