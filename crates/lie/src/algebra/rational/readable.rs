//! Readable rational functions: one fraction, common factors canceled, products kept as products.

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

use super::polynomial::Budget;
use super::ring::{Factors, MAX_PRODUCTS, Product, Ring, product_of};

/// Larger expressions are left to `Pool::simplify`.
const MAX_NODES: usize = 1500;

/// Larger expressions are only looked at as fractions.
const MAX_COMPARED_NODES: usize = 150;

/// A further quotient weighs as much as this many characters.
const QUOTIENT: u64 = 20;

/// An equal expression that reads well: a product of powers where it factors, one fraction, common
/// factors canceled, sin² + cos² = 1 used where it shortens. Equal wherever both have a value.
pub(crate) fn tidy(pool: &mut Pool, e: Expr) -> Expr {
    let nodes = pool.reachable(&[e]).len();
    if nodes < 3 {
        return e;
    }
    let Some(f) = factored(pool, e) else { return pool.simplify(e) };
    let fraction = f.expression(pool);
    let plain = if nodes > MAX_COMPARED_NODES { fraction } else { pool.simplify(e) };
    let collected = pool.simplify(fraction);
    // The first of the shortest, where every quotient but one takes some reading.
    let length = |e: &Expr| {
        let size = pool.text_size(*e);
        size.length.saturating_add(QUOTIENT * size.quotients.saturating_sub(1))
    };
    [collected, fraction, plain].into_iter().min_by_key(length).unwrap_or(plain)
}

/// The factors of the numerator of `e` that vanish somewhere, as far as is seen: not constants,
/// nor sums of squares with a positive term. `None` if `e` is too large to be factored.
pub(crate) fn vanishing_factors(pool: &mut Pool, e: Expr, states: &[Symbol], bindings: &Bindings) -> Option<Vec<Expr>> {
    let f = factored(pool, e)?;
    let mut list = Vec::new();
    for (p, k) in &f.factors {
        if *k > 0 && !f.ring.never_zero(pool, p, states, bindings) {
            let factor = f.ring.shortest(pool, p);
            list.push(pool.simplify(factor));
        }
    }
    Some(list)
}

/// The largest product of powers, of those that depend on the `states`, that divides all of
/// `list`; `None` if there is none or an expression is too large.
pub(crate) fn common_factor(pool: &mut Pool, list: &[Expr], states: &[Symbol]) -> Option<Expr> {
    let mut common: Option<Vec<(Expr, i32)>> = None;
    for &e in list {
        let f = factored(pool, e)?;
        let mut powers = Vec::new();
        for (p, k) in &f.factors {
            let base = f.ring.shortest(pool, p);
            powers.push((pool.simplify(base), *k));
        }
        let exponent = |list: &[(Expr, i32)], b: Expr| list.iter().find(|x| x.0 == b).map_or(0, |x| x.1);
        common = Some(match common {
            None => powers,
            Some(old) => {
                let both = old.iter().map(|&(b, k)| (b, k.min(exponent(&powers, b))));
                let new = powers.iter().filter(|x| exponent(&old, x.0) == 0).map(|&(b, k)| (b, k.min(0)));
                both.chain(new).filter(|x| x.1 != 0).collect()
            }
        });
    }
    let mut product = pool.int(1);
    for (b, k) in common? {
        if states.iter().any(|&s| pool.depends_on(b, s)) {
            let power = pool.powi(b, i64::from(k));
            product = pool.mul(product, power);
        }
    }
    (!pool.is_one(product)).then_some(product)
}

/// The square root of an expression that is the square of a product of powers; `None` if it is not seen to be one.
pub(crate) fn square_root(pool: &mut Pool, e: Expr) -> Option<Expr> {
    if pool.is_zero(e) {
        return Some(e);
    }
    let f = factored(pool, e)?;
    let size = Rational::simplest_from_f64(f.coefficient.to_f64().value().sqrt())?;
    if &size * &size != f.coefficient {
        return None;
    }
    let mut root = pool.rational(size);
    for (p, k) in &f.factors {
        if k % 2 != 0 {
            return None;
        }
        let base = f.ring.shortest(pool, p);
        let power = pool.powi(base, i64::from(k / 2));
        root = pool.mul(root, power);
    }
    Some(pool.simplify(root))
}

/// What an expression is as a product, in the ring of its atoms.
pub(super) struct Factored {
    pub(super) ring: Ring,
    pub(super) coefficient: Rational,
    pub(super) factors: Factors,
}

impl Factored {
    fn expression(&self, pool: &mut Pool) -> Expr {
        self.ring.product(pool, &self.coefficient, &self.factors)
    }
}

fn factored(pool: &mut Pool, e: Expr) -> Option<Factored> {
    factored_in(pool, Ring::default(), e)
}

/// The product in a ring that may have atoms already.
pub(super) fn factored_in(pool: &mut Pool, mut ring: Ring, e: Expr) -> Option<Factored> {
    let nodes = pool.reachable(&[e]);
    if nodes.len() > MAX_NODES {
        return None;
    }
    let mut budget = Budget::new(MAX_PRODUCTS);
    let mut image: FxHashMap<Expr, Product> = FxHashMap::default();
    for n in inner_nodes(pool, e) {
        let p = match pool.node(n) {
            Node::Num(_) => Product { coefficient: pool.number(n)?.clone(), factors: Vec::new() },
            Node::Add(a, b) => ring.sum(&image[&a], &image[&b], &mut budget)?,
            Node::Mul(a, b) => product_of(&image[&a], &image[&b]),
            Node::Pow(b, k) if pool.number(k).is_some() => ring.power(pool, n, &image[&b], k)?,
            Node::Call(Func::Sin | Func::Cos | Func::Tan, a) => ring.trigonometric(pool, n, a),
            _ => ring.atom(n),
        };
        image.insert(n, p);
    }
    let p = image.remove(&e)?;
    let (top, bottom): (Factors, Factors) =
        Ring::split(p.factors, &mut budget)?.into_iter().partition(|f| f.1 > 0 && f.0.len() > 1);
    let mut product = Product { coefficient: p.coefficient, factors: bottom };
    for (p, k) in top {
        ring.cancel(&mut product, p, k, &mut budget)?;
    }
    Some(Factored { ring, coefficient: product.coefficient, factors: product.factors })
}

/// The nodes above atoms, operands first.
fn inner_nodes(pool: &Pool, e: Expr) -> Vec<Expr> {
    let mut seen = vec![e];
    let mut stack = vec![e];
    while let Some(x) = stack.pop() {
        let operands: Vec<Expr> = match pool.node(x) {
            Node::Add(a, b) | Node::Mul(a, b) => vec![a, b],
            Node::Pow(b, k) if pool.number(k).is_some() => vec![b],
            _ => Vec::new(),
        };
        for o in operands {
            if !seen.contains(&o) {
                seen.push(o);
                stack.push(o);
            }
        }
    }
    seen.sort_unstable();
    seen
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn tidied(text: &str) -> String {
        let mut p = Pool::new();
        let e = p.parse(text).unwrap();
        let t = tidy(&mut p, e);
        let difference = p.sub(e, t);
        assert!(p.zero_test(difference, &Bindings::new()).is_zero(), "{text} is not {}", p.text(t));
        p.text(t)
    }

    #[test]
    fn common_factors_cancel() {
        assert_eq!(tidied("(a^2 - b^2)/(a - b)"), "a + b");
        assert_eq!(tidied("(x*y + y)/(x + 1)"), "y");
        assert_eq!(tidied("a/(x + y) + b*(x + y)/(x + y)^2"), "(a + b)/(x + y)");
        assert_eq!(tidied("1/(a + 1/b) - b/(a*b + 1)"), "0");
    }

    #[test]
    fn squares_on_the_circle_and_of_roots() {
        assert_eq!(tidied("1/(1 - cos(x)^2)"), "1/sin(x)^2");
        assert_eq!(tidied("(M + m - m*cos(t)^2)/(M + m*sin(t)^2)"), "1");
        assert_eq!(tidied("sqrt(x^2 + 1)^3/(x^2 + 1)"), "sqrt(x^2 + 1)");
        assert_eq!(tidied("tan(x)*cos(x) - sin(x)"), "0");
    }

    #[test]
    fn products_stay_products() {
        assert_eq!(tidied("(a + b)*(c + d)*e/(a + b)"), "e*(c + d)");
        assert_eq!(tidied("-2*c*i/(m*Lc*x^2)"), "-2*c*i/(Lc*m*x^2)");
    }

    #[test]
    fn factors_that_vanish_somewhere() {
        let mut p = Pool::new();
        let (x, m) = (p.symbol("x"), p.symbol("m"));
        let mut bindings = Bindings::new();
        bindings.bind(m, Rational::from(2));
        let mut vanishing = |text: &str| {
            let e = p.parse(text).unwrap();
            let list = vanishing_factors(&mut p, e, &[x], &bindings).unwrap();
            list.into_iter().map(|f| p.text(f)).collect::<Vec<_>>()
        };
        assert_eq!(vanishing("m*x*cos(x)/(x - 1)"), ["cos(x)", "x"]);
        assert!(vanishing("(1 + m*x^2)*exp(x)*(3 - cos(x)^2)").is_empty());
        assert_eq!(vanishing("1 - m*x^2"), ["m*x^2 - 1"]);
    }
}
