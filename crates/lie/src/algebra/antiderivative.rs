//! Antiderivatives of elementary functions of one variable, confirmed by differentiation.

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Rational, Symbol};

use crate::algebra::span::vanishes;

/// F with dF/dy = e, term by term; `None` where no rule applies. `near` is a value of y that tells log(q) from log(−q).
///
/// Terms are products of a constant with y^k and one of (a y + b)^p, sin, cos, exp, sinh, cosh, tan, tanh of a y + b.
pub(crate) fn antiderivative(pool: &mut Pool, e: Expr, y: Symbol, near: f64) -> Option<Expr> {
    let expanded = pool.expand(e);
    let mut terms = Vec::new();
    summands(pool, expanded, &mut terms);
    let mut sum = pool.int(0);
    for t in terms {
        let part = term(pool, t, y, near)?;
        sum = pool.add(sum, part);
    }
    let sum = pool.simplify(sum);
    let derivative = pool.diff(sum, y);
    let difference = pool.sub(derivative, e);
    vanishes(pool, difference, &Bindings::new()).then_some(sum)
}

fn summands(pool: &Pool, e: Expr, list: &mut Vec<Expr>) {
    match pool.node(e) {
        Node::Add(a, b) => {
            summands(pool, a, list);
            summands(pool, b, list);
        }
        _ => list.push(e),
    }
}

fn factors(pool: &Pool, e: Expr, list: &mut Vec<Expr>) {
    match pool.node(e) {
        Node::Mul(a, b) => {
            factors(pool, a, list);
            factors(pool, b, list);
        }
        _ => list.push(e),
    }
}

fn term(pool: &mut Pool, e: Expr, y: Symbol, near: f64) -> Option<Expr> {
    let mut list = Vec::new();
    factors(pool, e, &mut list);
    let mut constant = pool.int(1);
    let (mut power, mut function) = (Rational::ZERO, None);
    for f in list {
        if !pool.depends_on(f, y) {
            constant = pool.mul(constant, f);
            continue;
        }
        match pool.node(f) {
            Node::Sym(_) => power += Rational::ONE,
            Node::Pow(b, k) if pool.node(b) == Node::Sym(y) && pool.number(k).is_some() => {
                power += pool.number(k)?.clone();
            }
            _ if function.is_none() => function = Some(f),
            _ => return None,
        }
    }
    let inner = match function {
        None => {
            let x = pool.sym(y);
            power_of(pool, x, x, y, &power, near)?
        }
        Some(f) if matches!(pool.node(f), Node::Add(..)) => {
            let x = pool.sym(y);
            let exponent = pool.rational(power);
            let power = pool.pow(x, exponent);
            let mut parts = Vec::new();
            summands(pool, f, &mut parts);
            let mut sum = pool.int(0);
            for part in parts {
                let product = pool.mul(power, part);
                let whole = term(pool, product, y, near)?;
                sum = pool.add(sum, whole);
            }
            sum
        }
        Some(f) => with_function(pool, f, &power, y, near)?,
    };
    Some(pool.mul(constant, inner))
}

/// ∫ q^k for q linear in y.
fn power_of(pool: &mut Pool, q: Expr, x: Expr, y: Symbol, k: &Rational, near: f64) -> Option<Expr> {
    let slope = slope(pool, q, y)?;
    let raised = k.clone() + Rational::ONE;
    let whole = if raised == Rational::ZERO {
        let at = pool.rational(Rational::simplest_from_f64(near)?);
        let value = pool.substitute(q, &std::iter::once((x, at)).collect());
        let value = pool.simplify(value);
        let negative = pool.number(value).is_some_and(|v| *v < Rational::ZERO);
        let inside = if negative { pool.neg(q) } else { q };
        pool.call(Func::Log, inside)
    } else {
        let exponent = pool.rational(raised.clone());
        let power = pool.pow(q, exponent);
        let factor = pool.rational(Rational::ONE / raised);
        pool.mul(factor, power)
    };
    Some(pool.div(whole, slope))
}

/// The slope of an expression that is linear in y.
fn slope(pool: &mut Pool, q: Expr, y: Symbol) -> Option<Expr> {
    let d = pool.diff(q, y);
    let d = pool.simplify(d);
    (!pool.depends_on(d, y) && !pool.is_zero(d)).then_some(d)
}

/// ∫ y^k f(a y + b), by parts for k > 0.
fn with_function(pool: &mut Pool, f: Expr, k: &Rational, y: Symbol, near: f64) -> Option<Expr> {
    let x = pool.sym(y);
    if let Node::Pow(q, p) = pool.node(f)
        && let Some(p) = pool.number(p).cloned()
    {
        if let Node::Call(g, a) = pool.node(q) {
            return (*k == Rational::ZERO).then(|| square(pool, g, a, &p, y)).flatten();
        }
        return if *k == Rational::ZERO { power_of(pool, q, x, y, &p, near) } else { None };
    }
    let Node::Call(g, a) = pool.node(f) else { return None };
    let slope = slope(pool, a, y)?;
    let whole = match g {
        Func::Sin => {
            let c = pool.cos(a);
            pool.neg(c)
        }
        Func::Cos => pool.sin(a),
        Func::Exp => f,
        Func::Sinh => pool.call(Func::Cosh, a),
        Func::Cosh => pool.call(Func::Sinh, a),
        Func::Tan if *k == Rational::ZERO => {
            let c = pool.cos(a);
            let log = pool.call(Func::Log, c);
            pool.neg(log)
        }
        Func::Tanh if *k == Rational::ZERO => {
            let c = pool.call(Func::Cosh, a);
            pool.call(Func::Log, c)
        }
        _ => return None,
    };
    let whole = pool.div(whole, slope);
    if *k == Rational::ZERO {
        return Some(whole);
    }
    if *k < Rational::ZERO || !k.is_int() || *k > Rational::from(6) {
        return None;
    }
    // y^k F − k ∫ y^(k−1) F
    let exponent = pool.rational(k.clone());
    let power = pool.pow(x, exponent);
    let first = pool.mul(power, whole);
    let lower = pool.rational(k.clone() - Rational::ONE);
    let lower = pool.pow(x, lower);
    let rest = pool.mul(lower, whole);
    let rest = pool.mul(exponent, rest);
    let rest = antiderivative(pool, rest, y, near)?;
    Some(pool.sub(first, rest))
}

/// ∫ of sin², cos², and 1/cos² of a y + b.
fn square(pool: &mut Pool, g: Func, a: Expr, p: &Rational, y: Symbol) -> Option<Expr> {
    let slope = slope(pool, a, y)?;
    let x = pool.sym(y);
    if g == Func::Cos && *p == Rational::from(-2) {
        let t = pool.call(Func::Tan, a);
        return Some(pool.div(t, slope));
    }
    if *p != Rational::from(2) || !matches!(g, Func::Sin | Func::Cos) {
        return None;
    }
    let (s, c) = (pool.sin(a), pool.cos(a));
    let product = pool.mul(s, c);
    let product = pool.div(product, slope);
    let sum = if g == Func::Cos { pool.add(x, product) } else { pool.sub(x, product) };
    let half = pool.ratio(1, 2);
    Some(pool.mul(half, sum))
}
