//! Old inputs as functions of the new ones, in closed form where there is one.

use bracketry_symbolic::{Bindings, Expr, Func, Func2, Function, Node, Pool, Rational, Symbol, Tape};
use rustc_hash::FxHashMap;

use crate::images::{flattened, input_domain};
use crate::system::System;

/// Each old input that is found, with its function of the new inputs and the states, such that w of them is the new
/// input. Where there are several solutions, one of them.
pub(crate) fn inverse(system: &mut System, functions: &[Expr], new: &[Symbol]) -> Vec<(String, Function)> {
    let mut known: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut found = Vec::new();
    // One function after the other, as long as one has a single unknown input.
    let mut open: Vec<usize> = (0..functions.len()).collect();
    loop {
        let step = open.iter().enumerate().find_map(|(at, &k)| {
            let w = system.pool.substitute(functions[k], &known);
            let uses = system.pool.symbols_of(&[w]);
            let mut unknown =
                system.inputs.iter().copied().filter(|u| uses.contains(u) && !known.contains_key(&system.pool.sym(*u)));
            let (Some(u), None) = (unknown.next(), unknown.next()) else { return None };
            let v = system.pool.sym(new[k]);
            // An input that keeps its name is its own inverse.
            let e = if u == new[k] { v } else { in_range(system, w, u, v)? };
            Some((at, u, e))
        });
        let Some((at, u, e)) = step else { break };
        let k = open.swap_remove(at);
        let unknown = system.pool.sym(u);
        let e = system.pool.simplify(e);
        let solution = std::iter::once((unknown, e)).chain(known.iter().map(|(&a, &b)| (a, b))).collect();
        if u != new[k] && !holds(system, functions, new, k, &solution) {
            continue;
        }
        known.insert(unknown, e);
        if u != new[k] {
            found.push((system.pool.name(u).to_owned(), Function::new(&system.pool, e)));
        }
    }
    if found.is_empty() {
        found = polar(system, functions, new);
    }
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}

/// The solution of w(u) = v that lies in the range of u, where that has one and one of the two branches does.
fn in_range(system: &mut System, w: Expr, u: Symbol, v: Expr) -> Option<Expr> {
    let upper = solve(&mut system.pool, w, u, v, Branch::Upper)?;
    let domain = input_domain(system);
    let (a, b) = (domain[&u].lower.value, domain[&u].upper.value);
    if a == f64::NEG_INFINITY && b == f64::INFINITY {
        return Some(upper);
    }
    // On its branch, the solution for v = w(u) is u.
    let middle = if a.is_finite() && b.is_finite() {
        f64::midpoint(a, b)
    } else if a.is_finite() {
        a + 1.0
    } else {
        b - 1.0
    };
    let returns = |system: &mut System, solution: Expr| {
        let there = system.pool.substitute(solution, &FxHashMap::from_iter([(v, w)]));
        let value = system.with_values(&[there])[0];
        let others: Vec<Symbol> = system.pool.symbols_of(&[value]).into_iter().filter(|s| *s != u).collect();
        let arguments: Vec<Symbol> = std::iter::once(u).chain(others).collect();
        let Ok(tape) = Tape::compile(&system.pool, &arguments, &[value]) else { return false };
        let at: Vec<f64> = (0..arguments.len()).map(|k| if k == 0 { middle } else { 0.7 + 0.1 * k as f64 }).collect();
        let mut out = [f64::NAN];
        tape.eval(&at, &mut Vec::new(), &mut out);
        (out[0] - middle).abs() <= 1e-9 * (1.0 + middle.abs())
    };
    if !returns(system, upper)
        && let Some(lower) = solve(&mut system.pool, w, u, v, Branch::Lower)
        && returns(system, lower)
    {
        return Some(lower);
    }
    Some(upper)
}

/// Which of two roots is taken.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Branch {
    Upper,
    Lower,
}

/// Whether w of the solution is v: exactly, or, where functions of their inverses are beyond the exact test, in numbers
/// (each step of the solution is the inverse of a step of w, so that only the branch can be wrong).
fn holds(system: &System, functions: &[Expr], new: &[Symbol], k: usize, solution: &FxHashMap<Expr, Expr>) -> bool {
    let mut check = system.clone();
    let image = check.pool.substitute(functions[k], solution);
    let v = check.pool.sym(new[k]);
    let difference = check.pool.sub(image, v);
    let simple = check.pool.simplify(difference);
    if check.pool.is_zero(simple) || check.pool.zero_test(simple, &Bindings::default()).is_zero() {
        return true;
    }
    let forward: FxHashMap<Expr, Expr> =
        new.iter().map(|&s| check.pool.sym(s)).zip(functions.iter().copied()).collect();
    let round_trip = check.pool.substitute(simple, &forward);
    let values = check.with_values(&[round_trip, functions[k]]);
    let arguments: Vec<Symbol> = check.states.iter().chain(&check.inputs).copied().collect();
    let Ok(tape) = Tape::compile(&check.pool, &arguments, &values) else { return false };
    let mut seen = 0;
    for sample in 0..12 {
        let at: Vec<f64> = (0..arguments.len()).map(|j| (1.0 + sample as f64 + 3.0 * j as f64).sin() * 1.4).collect();
        let mut out = [f64::NAN; 2];
        tape.eval(&at, &mut Vec::new(), &mut out);
        if !out[0].is_finite() {
            continue;
        }
        if out[0].abs() > 1e-9 * (1.0 + out[1].abs()) {
            return false;
        }
        seen += 1;
    }
    seen >= 3
}

/// A solution u of w(u) = v in closed form, the principal branch of inverse functions and roots; `None` if none was found. `v` must
/// not depend on `u`; whether the solution holds where it is used has to be checked.
///
/// ```
/// use bracketry_symbolic::Pool;
/// let mut p = Pool::new();
/// let (w, u, v) = (p.parse("2*tan(u) + 1").unwrap(), p.symbol("u"), p.var("v"));
/// let solution = bracketry_system::solved_for(&mut p, w, u, v).unwrap();
/// assert_eq!(p.text(solution), "atan(0.5*v - 0.5)");
/// ```
pub fn solved_for(pool: &mut Pool, w: Expr, u: Symbol, v: Expr) -> Option<Expr> {
    let solution = solve(pool, w, u, v, Branch::Upper)?;
    Some(pool.simplify(solution))
}

/// u from w(u) = v.
fn solve(pool: &mut Pool, w: Expr, u: Symbol, v: Expr, branch: Branch) -> Option<Expr> {
    let depends = |pool: &Pool, e: Expr| pool.depends_on(e, u);
    match pool.node(w) {
        Node::Sym(s) if s == u => Some(v),
        Node::Add(a, b) | Node::Mul(a, b) if depends(pool, a) != depends(pool, b) => {
            let (inner, other) = if depends(pool, a) { (a, b) } else { (b, a) };
            let rest = if matches!(pool.node(w), Node::Add(..)) { pool.sub(v, other) } else { pool.div(v, other) };
            solve(pool, inner, u, rest, branch)
        }
        Node::Add(..) => quadratic(pool, w, u, v, branch),
        Node::Mul(..) => signed_power(pool, w, u, v),
        Node::Pow(a, k) => {
            let k = pool.number(k)?.clone();
            let inverse = pool.rational(Rational::ONE / k.clone());
            if k == -Rational::ONE {
                let reciprocal = pool.pow(v, inverse);
                return solve(pool, a, u, reciprocal, branch);
            }
            let k_is_even = k.is_int() && (k.clone() / Rational::from(2)).is_int();
            let odd = k.is_int() && !k_is_even;
            let mut root = if odd { odd_root(pool, v, inverse) } else { pool.pow(v, inverse) };
            if k_is_even && branch == Branch::Lower {
                root = pool.neg(root);
            }
            solve(pool, a, u, root, branch)
        }
        Node::Call(f, a) => {
            let mut inner = undo(pool, f, v)?;
            if branch == Branch::Lower && matches!(f, Func::Abs | Func::Cosh | Func::Cos) {
                inner = pool.neg(inner);
            }
            solve(pool, a, u, inner, branch)
        }
        _ => None,
    }
}

/// sign(v)·|v|^k
fn odd_root(pool: &mut Pool, v: Expr, k: Expr) -> Expr {
    let (sign, size) = (pool.call(Func::Sign, v), pool.call(Func::Abs, v));
    let root = pool.pow(size, k);
    pool.mul(sign, root)
}

fn undo(pool: &mut Pool, f: Func, v: Expr) -> Option<Expr> {
    let simple = match f {
        Func::Sin => Func::Asin,
        Func::Cos => Func::Acos,
        Func::Tan => Func::Atan,
        Func::Asin => Func::Sin,
        Func::Acos => Func::Cos,
        Func::Atan => Func::Tan,
        Func::Exp => Func::Log,
        Func::Log => Func::Exp,
        Func::Abs => return Some(v),
        Func::Sign => return None,
        Func::Sinh | Func::Cosh => {
            // log(v + √(v² ± 1))
            let one = pool.int(if f == Func::Sinh { 1 } else { -1 });
            let square = pool.powi(v, 2);
            let inside = pool.add(square, one);
            let root = pool.sqrt(inside);
            let sum = pool.add(v, root);
            return Some(pool.call(Func::Log, sum));
        }
        Func::Tanh => {
            // log((1 + v)/(1 − v))/2
            let (one, half) = (pool.int(1), pool.ratio(1, 2));
            let (up, down) = (pool.add(one, v), pool.sub(one, v));
            let ratio = pool.div(up, down);
            let log = pool.call(Func::Log, ratio);
            return Some(pool.mul(half, log));
        }
    };
    Some(pool.call(simple, v))
}

/// A root of a u² + b u + c = v: for a > 0, the larger one on the upper branch.
fn quadratic(pool: &mut Pool, w: Expr, u: Symbol, v: Expr, branch: Branch) -> Option<Expr> {
    let zero = pool.int(0);
    let at_zero = |pool: &mut Pool, e: Expr| {
        let x = pool.sym(u);
        pool.substitute(e, &std::iter::once((x, zero)).collect())
    };
    let first = pool.diff(w, u);
    let second = pool.diff(first, u);
    let second = pool.simplify(second);
    if pool.depends_on(second, u) || !pool.zero_test(second, &Bindings::default()).is_nonzero() {
        return None;
    }
    let (b, c) = (at_zero(pool, first), at_zero(pool, w));
    // u = (−b + √(b² + 2 w″ (v − c)))/w″
    let (gap, square) = (pool.sub(v, c), pool.powi(b, 2));
    let product = pool.mul(second, gap);
    let two = pool.int(2);
    let product = pool.mul(two, product);
    let inside = pool.add(square, product);
    let mut root = pool.sqrt(inside);
    if branch == Branch::Lower {
        root = pool.neg(root);
    }
    let numerator = pool.sub(root, b);
    Some(pool.div(numerator, second))
}

/// u from c·|u|^k·u^j or c·sign(u)·u^j with k + j > 0, where that is odd and increasing.
fn signed_power(pool: &mut Pool, w: Expr, u: Symbol, v: Expr) -> Option<Expr> {
    let x = pool.sym(u);
    let mut scale = pool.int(1);
    let (mut degree, mut odd) = (Rational::ZERO, false);
    for f in flattened(pool, w, false) {
        let (base, k) = match pool.node(f) {
            Node::Pow(a, k) => (a, pool.number(k).cloned()?),
            _ => (f, Rational::ONE),
        };
        match pool.node(base) {
            _ if !pool.depends_on(f, u) => scale = pool.mul(scale, f),
            Node::Sym(_) if k.is_int() => {
                odd ^= !(k.clone() / Rational::from(2)).is_int();
                degree += k;
            }
            Node::Call(Func::Abs, a) if a == x => degree += k,
            Node::Call(Func::Sign, a) if a == x && k == Rational::ONE => odd = !odd,
            _ => return None,
        }
    }
    if !odd || degree <= Rational::ZERO {
        return None;
    }
    let k = pool.rational(Rational::ONE / degree);
    let v = pool.div(v, scale);
    Some(odd_root(pool, v, k))
}

/// Cartesian to polar: u1 = √(v1² + v2²), u2 = atan2(v2, v1), for v1 = u1 cos u2 and v2 = u1 sin u2.
fn polar(system: &mut System, functions: &[Expr], new: &[Symbol]) -> Vec<(String, Function)> {
    let [v, w] = functions[..] else { return Vec::new() };
    let pool = &mut system.pool;
    for (radius, angle) in [(0, 1), (1, 0)] {
        let (Some(&r), Some(&a)) = (system.inputs.get(radius), system.inputs.get(angle)) else { continue };
        let (r, a) = (pool.sym(r), pool.sym(a));
        let (cos, sin) = (pool.cos(a), pool.sin(a));
        for (x, y) in [(0, 1), (1, 0)] {
            let pair = [v, w];
            let (p, q) = (pool.mul(r, cos), pool.mul(r, sin));
            if pair[x] != p || pair[y] != q {
                continue;
            }
            let (vx, vy) = (pool.sym(new[x]), pool.sym(new[y]));
            let (xx, yy) = (pool.powi(vx, 2), pool.powi(vy, 2));
            let sum = pool.add(xx, yy);
            let length = pool.sqrt(sum);
            let direction = pool.call2(Func2::Atan2, vy, vx);
            let found = |k: usize, e: Expr| (pool.name(system.inputs[k]).to_owned(), Function::new(pool, e));
            return vec![found(radius, length), found(angle, direction)];
        }
    }
    Vec::new()
}
