//! Solving one equation for one unknown, in closed form.

use bracketry_symbolic::{Expr, Func, Func2, Node, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::rational::readable::tidy;

/// A solution of an equation, by how safe it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Quality {
    /// Linear with a constant slope.
    Constant,
    /// Linear with a slope that may vanish.
    Linear,
    /// By an inverse function or a root: one of several branches.
    Branch,
}

/// s = value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub(crate) value: Expr,
    pub(crate) quality: Quality,
}

/// Solutions s of e = 0 in closed form; several where there are branches, none where none is seen.
pub(crate) fn roots(pool: &mut Pool, e: Expr, s: Symbol, unknowns: &[Symbol]) -> Vec<Root> {
    if !pool.depends_on(e, s) {
        return Vec::new();
    }
    let slope = pool.diff(e, s);
    let slope = tidy(pool, slope);
    if !pool.depends_on(slope, s) {
        let x = pool.sym(s);
        let Some(value) = linear_root(pool, e, x, slope) else { return Vec::new() };
        let constant = !pool.symbols_of(&[slope]).iter().any(|t| unknowns.contains(t));
        let quality = if constant { Quality::Constant } else { Quality::Linear };
        return vec![Root { value, quality }];
    }
    let mut kernels = Vec::new();
    if !kernels_of(pool, e, s, &mut kernels) {
        return Vec::new();
    }
    let values = match kernels[..] {
        [kernel] => by_kernel(pool, e, kernel, s),
        [a, b] => by_angle(pool, e, [a, b], s),
        _ => Vec::new(),
    };
    values.into_iter().map(|value| Root { value, quality: Quality::Branch }).collect()
}

/// x of e = 0, where e is linear in it.
fn linear_root(pool: &mut Pool, e: Expr, x: Expr, slope: Expr) -> Option<Expr> {
    if pool.is_zero(slope) {
        return None;
    }
    let zero = pool.int(0);
    let rest = pool.substitute(e, &std::iter::once((x, zero)).collect());
    let quotient = pool.div(rest, slope);
    let value = pool.neg(quotient);
    Some(tidy(pool, value))
}

/// The functions of s of which e is a polynomial; false if it is not one of at most two.
fn kernels_of(pool: &Pool, e: Expr, s: Symbol, list: &mut Vec<Expr>) -> bool {
    if !pool.depends_on(e, s) {
        return true;
    }
    match pool.node(e) {
        Node::Add(a, b) | Node::Mul(a, b) => kernels_of(pool, a, s, list) && kernels_of(pool, b, s, list),
        Node::Pow(b, k) if pool.integer(k).is_some_and(|k| k > 0) => kernels_of(pool, b, s, list),
        Node::Call2(..) => false,
        _ => {
            if !list.contains(&e) {
                list.push(e);
            }
            list.len() <= 2
        }
    }
}

/// Stands for a kernel. No model can use the name.
const KERNEL: [&str; 2] = ["a kernel", "another kernel"];

/// Solutions of a polynomial of degree one or two in a single function of s.
fn by_kernel(pool: &mut Pool, e: Expr, kernel: Expr, s: Symbol) -> Vec<Expr> {
    let symbol = pool.symbol(KERNEL[0]);
    let w = pool.sym(symbol);
    let inside = pool.substitute(e, &std::iter::once((kernel, w)).collect());
    if pool.depends_on(inside, s) {
        return Vec::new();
    }
    let slope = pool.diff(inside, symbol);
    let slope = tidy(pool, slope);
    let values = if pool.depends_on(slope, symbol) {
        quadratic(pool, inside, slope, symbol)
    } else {
        linear_root(pool, inside, w, slope).into_iter().collect()
    };
    values.into_iter().flat_map(|v| undo(pool, kernel, v, s)).collect()
}

/// Both roots of a w² + b w + c.
fn quadratic(pool: &mut Pool, e: Expr, slope: Expr, w: Symbol) -> Vec<Expr> {
    let second = pool.diff(slope, w);
    let second = tidy(pool, second);
    if pool.depends_on(second, w) || pool.is_zero(second) {
        return Vec::new();
    }
    let (zero, x) = (pool.int(0), pool.sym(w));
    let at_zero = std::iter::once((x, zero)).collect();
    let (b, c) = (pool.substitute(slope, &at_zero), pool.substitute(e, &at_zero));
    // w = (−b ± √(b² − 2 e″ c))/e″
    let (square, product, two) = (pool.powi(b, 2), pool.mul(second, c), pool.int(2));
    let product = pool.mul(two, product);
    let inside = pool.sub(square, product);
    let inside = tidy(pool, inside);
    let root = pool.sqrt(inside);
    [false, true]
        .map(|minus| {
            let root = if minus { pool.neg(root) } else { root };
            let top = pool.sub(root, b);
            let value = pool.div(top, second);
            tidy(pool, value)
        })
        .into()
}

/// Solutions of kernel(s) = value.
fn undo(pool: &mut Pool, kernel: Expr, value: Expr, s: Symbol) -> Vec<Expr> {
    let (argument, values) = match pool.node(kernel) {
        Node::Sym(t) if t == s => return vec![value],
        Node::Call(f, a) => (a, inverse_values(pool, f, value)),
        Node::Pow(a, k) => {
            let Some(k) = pool.number(k).cloned() else { return Vec::new() };
            let inverse = pool.rational(bracketry_symbolic::Rational::ONE / k);
            let power = pool.pow(value, inverse);
            (a, vec![power])
        }
        _ => return Vec::new(),
    };
    let mut list = Vec::new();
    for v in values {
        let difference = pool.sub(argument, v);
        list.extend(roots(pool, difference, s, &[s]).into_iter().map(|r| r.value));
    }
    list
}

/// The arguments at which f takes the value, on the branches next to the principal one.
fn inverse_values(pool: &mut Pool, f: Func, v: Expr) -> Vec<Expr> {
    let pi = pool.pi();
    let two = pool.int(2);
    let turn = pool.mul(two, pi);
    match f {
        Func::Sin => {
            let a = pool.call(Func::Asin, v);
            let other = pool.sub(pi, a);
            let below = pool.neg(pi);
            let below = pool.sub(below, a);
            vec![a, other, below]
        }
        Func::Cos => {
            let a = pool.call(Func::Acos, v);
            let (other, beyond) = (pool.neg(a), pool.sub(turn, a));
            vec![a, other, beyond]
        }
        Func::Tan => {
            let a = pool.call(Func::Atan, v);
            let (up, down) = (pool.add(a, pi), pool.sub(a, pi));
            vec![a, up, down]
        }
        Func::Asin => vec![pool.sin(v)],
        Func::Acos => vec![pool.cos(v)],
        Func::Atan => vec![pool.call(Func::Tan, v)],
        Func::Exp => vec![pool.call(Func::Log, v)],
        Func::Log => vec![pool.call(Func::Exp, v)],
        Func::Sinh => {
            let (one, square) = (pool.int(1), pool.powi(v, 2));
            let inside = pool.add(square, one);
            let root = pool.sqrt(inside);
            let sum = pool.add(v, root);
            vec![pool.call(Func::Log, sum)]
        }
        Func::Tanh => {
            let (one, half) = (pool.int(1), pool.ratio(1, 2));
            let (up, down) = (pool.add(one, v), pool.sub(one, v));
            let ratio = pool.div(up, down);
            let log = pool.call(Func::Log, ratio);
            vec![pool.mul(half, log)]
        }
        Func::Cosh | Func::Abs | Func::Sign => Vec::new(),
    }
}

/// Solutions of A sin a + B cos a + C = 0.
fn by_angle(pool: &mut Pool, e: Expr, kernels: [Expr; 2], s: Symbol) -> Vec<Expr> {
    let (mut sine, mut cosine) = (None, None);
    for k in kernels {
        match pool.node(k) {
            Node::Call(Func::Sin, a) => sine = Some((k, a)),
            Node::Call(Func::Cos, a) => cosine = Some((k, a)),
            _ => {}
        }
    }
    let (Some((sine, angle)), Some((cosine, other))) = (sine, cosine) else { return Vec::new() };
    if angle != other {
        return Vec::new();
    }
    let symbols = KERNEL.map(|name| pool.symbol(name));
    let [x, y] = symbols.map(|t| pool.sym(t));
    let inside = pool.substitute(e, &[(sine, x), (cosine, y)].into_iter().collect());
    if pool.depends_on(inside, s) {
        return Vec::new();
    }
    let [a, b] = symbols.map(|t| {
        let slope = pool.diff(inside, t);
        tidy(pool, slope)
    });
    if [a, b].iter().any(|&c| symbols.iter().any(|&t| pool.depends_on(c, t))) {
        return Vec::new();
    }
    let zero = pool.int(0);
    let c = pool.substitute(inside, &[(x, zero), (y, zero)].into_iter().collect());
    let c = tidy(pool, c);
    let minus_b = pool.neg(b);
    let values = if pool.is_zero(c) {
        // (cos a, sin a) is along ±(A, −B).
        let minus_a = pool.neg(a);
        let mut list = vec![pool.call2(Func2::Atan2, minus_b, a), pool.call2(Func2::Atan2, b, minus_a)];
        // Around π, where those jump.
        let ratio = pool.div(minus_b, a);
        let angle = pool.call(Func::Atan, ratio);
        let pi = pool.pi();
        list.extend([pool.add(angle, pi), pool.sub(angle, pi)]);
        list
    } else {
        // A sin a + B cos a = √(A² + B²) cos(a − atan2(A, B))
        let (aa, bb) = (pool.powi(a, 2), pool.powi(b, 2));
        let sum = pool.add(aa, bb);
        let size = pool.sqrt(sum);
        let ratio = pool.div(c, size);
        let ratio = pool.neg(ratio);
        let offset = pool.call(Func::Acos, ratio);
        let start = pool.call2(Func2::Atan2, a, b);
        vec![pool.add(start, offset), pool.sub(start, offset)]
    };
    let mut list = Vec::new();
    for v in values {
        let difference = pool.sub(angle, v);
        list.extend(roots(pool, difference, s, &[s]).into_iter().map(|r| r.value));
    }
    list
}

/// Circular functions of inverse circular functions as algebraic ones.
pub(crate) fn fold(pool: &mut Pool, e: Expr) -> Expr {
    let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
    for n in pool.reachable(&[e]) {
        let new = pool.rebuild(n, |o| image[&o]);
        let folded = match pool.node(new) {
            Node::Call(f @ (Func::Sin | Func::Cos | Func::Tan), a) => {
                circle_point(pool, a).map(|(cosine, sine)| match f {
                    Func::Sin => sine,
                    Func::Cos => cosine,
                    _ => pool.div(sine, cosine),
                })
            }
            _ => None,
        };
        image.insert(n, folded.unwrap_or(new));
    }
    image[&e]
}

/// π or −π.
fn is_half_turn(pool: &Pool, e: Expr) -> bool {
    match pool.node(e) {
        Node::Pi => true,
        Node::Mul(c, p) => pool.integer(c) == Some(-1) && pool.node(p) == Node::Pi,
        _ => false,
    }
}

/// Cosine and sine of an inverse circular function, turned by π or not.
fn circle_point(pool: &mut Pool, a: Expr) -> Option<(Expr, Expr)> {
    let one = pool.int(1);
    let beside = |pool: &mut Pool, w: Expr| {
        let square = pool.powi(w, 2);
        let inside = pool.sub(one, square);
        pool.sqrt(inside)
    };
    match pool.node(a) {
        Node::Call(Func::Asin, w) => Some((beside(pool, w), w)),
        Node::Call(Func::Acos, w) => Some((w, beside(pool, w))),
        Node::Call(Func::Atan, w) => {
            let square = pool.powi(w, 2);
            let sum = pool.add(one, square);
            let root = pool.sqrt(sum);
            Some((pool.div(one, root), pool.div(w, root)))
        }
        Node::Call2(Func2::Atan2, y, x) => {
            let (xx, yy) = (pool.powi(x, 2), pool.powi(y, 2));
            let sum = pool.add(xx, yy);
            let sum = tidy(pool, sum);
            let root = pool.sqrt(sum);
            Some((pool.div(x, root), pool.div(y, root)))
        }
        // cos(π + a) = −cos a, sin(π + a) = −sin a
        Node::Add(b, c) if is_half_turn(pool, b) || is_half_turn(pool, c) => {
            let inner = if is_half_turn(pool, b) { c } else { b };
            let (cosine, sine) = circle_point(pool, inner)?;
            Some((pool.neg(cosine), pool.neg(sine)))
        }
        Node::Mul(c, inner) if pool.integer(c) == Some(-1) => {
            let (cosine, sine) = circle_point(pool, inner)?;
            Some((cosine, pool.neg(sine)))
        }
        _ => None,
    }
}
