//! Readable rational functions: one fraction, common factors cancelled, products kept as products.

mod form;
mod polynomial;

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

use polynomial::{Budget, Monomial, Polynomial};

/// Products of terms that one expression may take.
const MAX_PRODUCTS: usize = 30_000;
/// Terms of a sum that is written out.
const MAX_TERMS: usize = 250;
/// Larger expressions are left to `Pool::simplify`.
const MAX_NODES: usize = 1500;
/// Larger expressions are only looked at as fractions.
const MAX_COMPARED_NODES: usize = 150;
/// A further quotient weighs as much as this many characters.
const QUOTIENT: usize = 20;

/// An equal expression that reads well: a product of powers where it factors, one fraction, common
/// factors cancelled, sin² + cos² = 1 used where it shortens. Equal wherever both have a value.
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
        let text = pool.text(*e);
        text.len() + QUOTIENT * text.matches('/').count().saturating_sub(1)
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

type Factors = Vec<(Polynomial, i32)>;

/// `coefficient · Π polynomial^exponent`; polynomials are primitive, and atoms stand alone.
#[derive(Clone)]
struct Product {
    coefficient: Rational,
    factors: Factors,
}

/// What an expression is as a product, in the ring of its atoms.
struct Factored {
    ring: Ring,
    coefficient: Rational,
    factors: Factors,
}

impl Factored {
    fn expression(&self, pool: &mut Pool) -> Expr {
        self.ring.product(pool, &self.coefficient, &self.factors)
    }
}

/// The functions and symbols that polynomials are formed of.
#[derive(Default)]
struct Ring {
    atoms: Vec<Expr>,
    index: FxHashMap<Expr, usize>,
    /// Atoms (sin a, cos a).
    circles: Vec<(usize, usize)>,
    /// Atom √p and the polynomial p.
    roots: Vec<(usize, Polynomial)>,
}

fn factored(pool: &mut Pool, e: Expr) -> Option<Factored> {
    let nodes = pool.reachable(&[e]);
    if nodes.len() > MAX_NODES {
        return None;
    }
    let mut ring = Ring::default();
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

fn product_of(a: &Product, b: &Product) -> Product {
    let mut factors = a.factors.clone();
    for (p, k) in &b.factors {
        multiply(&mut factors, p, *k);
    }
    Product { coefficient: &a.coefficient * &b.coefficient, factors }.without_zero()
}

fn multiply(factors: &mut Factors, p: &Polynomial, k: i32) {
    match factors.iter_mut().find(|f| f.0 == *p) {
        Some(f) => f.1 += k,
        None => factors.push((p.clone(), k)),
    }
    factors.retain(|f| f.1 != 0);
}

impl Product {
    /// Zero has no factors.
    fn without_zero(mut self) -> Self {
        if self.coefficient == Rational::ZERO {
            self.factors.clear();
        }
        self
    }
}

impl Ring {
    fn number(&mut self, e: Expr) -> usize {
        if let Some(&i) = self.index.get(&e) {
            return i;
        }
        self.atoms.push(e);
        self.index.insert(e, self.atoms.len() - 1);
        self.atoms.len() - 1
    }

    fn atom(&mut self, e: Expr) -> Product {
        let i = self.number(e);
        Product { coefficient: Rational::ONE, factors: vec![(Polynomial::atom(i), 1)] }
    }

    /// sin a, cos a, or tan a = sin a / cos a.
    fn trigonometric(&mut self, pool: &mut Pool, e: Expr, argument: Expr) -> Product {
        let (s, c) = (pool.sin(argument), pool.cos(argument));
        let (i, j) = (self.number(s), self.number(c));
        if !self.circles.contains(&(i, j)) {
            self.circles.push((i, j));
        }
        let factors = if e == s {
            vec![(Polynomial::atom(i), 1)]
        } else if e == c {
            vec![(Polynomial::atom(j), 1)]
        } else {
            vec![(Polynomial::atom(i), 1), (Polynomial::atom(j), -1)]
        };
        Product { coefficient: Rational::ONE, factors }
    }

    fn power(&mut self, pool: &mut Pool, e: Expr, base: &Product, exponent: Expr) -> Option<Product> {
        let Some(k) = pool.number(exponent).cloned() else { return Some(self.atom(e)) };
        if k.is_int() {
            let k = i32::try_from(k.numerator().clone()).ok().filter(|k| k.abs() <= 40)?;
            if base.coefficient == Rational::ZERO && k < 0 {
                return None;
            }
            let c = base.coefficient.pow(k.unsigned_abs() as isize);
            let coefficient = if k < 0 { Rational::ONE / c } else { c };
            return Some(Product {
                coefficient,
                factors: base.factors.iter().map(|(p, n)| (p.clone(), n * k)).collect(),
            });
        }
        let two = Rational::from(2);
        let twice = &k * &two;
        if !twice.is_int() {
            return Some(self.atom(e));
        }
        let times = i32::try_from(twice.numerator().clone()).ok().filter(|k| k.abs() <= 40)?;
        let Node::Pow(inside, _) = pool.node(e) else { return None };
        let root = pool.sqrt(inside);
        let i = self.number(root);
        // (√p)² = p, where p is a polynomial.
        if let [(p, 1)] = base.factors.as_slice()
            && !self.roots.iter().any(|r| r.0 == i)
        {
            self.roots.push((i, p.scaled(&base.coefficient)));
        }
        Some(Product { coefficient: Rational::ONE, factors: vec![(Polynomial::atom(i), times)] })
    }

    fn sum(&mut self, a: &Product, b: &Product, budget: &mut Budget) -> Option<Product> {
        if a.coefficient == Rational::ZERO {
            return Some(b.clone());
        }
        if b.coefficient == Rational::ZERO {
            return Some(a.clone());
        }
        let exponent = |list: &Factors, p: &Polynomial| list.iter().find(|f| f.0 == *p).map_or(0, |f| f.1);
        let mut common: Factors = Vec::new();
        for (p, k) in &a.factors {
            multiply(&mut common, p, (*k).min(exponent(&b.factors, p)));
        }
        for (p, k) in &b.factors {
            if exponent(&a.factors, p) == 0 {
                multiply(&mut common, p, (*k).min(0));
            }
        }
        let mut total = Polynomial::default();
        for side in [a, b] {
            let mut rest = side.factors.clone();
            for (p, k) in &common {
                multiply(&mut rest, p, -k);
            }
            let mut expanded = Polynomial::constant(&side.coefficient);
            for (p, k) in rest {
                expanded = expanded.mul(&p.pow(u32::try_from(k).ok()?, budget)?, budget)?;
            }
            total.add(&expanded, &Rational::ONE);
        }
        if total.len() > MAX_TERMS {
            return None;
        }
        let (coefficient, top) = self.without_content(&total, budget)?;
        if coefficient == Rational::ZERO {
            return Some(Product { coefficient, factors: Vec::new() });
        }
        let mut product = Product { coefficient, factors: common };
        for (p, k) in top {
            self.cancel(&mut product, p, k, budget)?;
        }
        Some(product)
    }

    /// Multiplies `product` by p^k, k > 0, and cancels what p has in common with the denominator.
    fn cancel(&self, product: &mut Product, p: Polynomial, k: i32, budget: &mut Budget) -> Option<()> {
        let known = product.factors.iter().any(|f| f.0 == p);
        if known || k != 1 || p.len() == 1 {
            multiply(&mut product.factors, &p, k);
            return Some(());
        }
        let mut p = p;
        let bottom: Vec<Polynomial> = product.factors.iter().filter(|f| f.1 < 0).map(|f| f.0.clone()).collect();
        for d in bottom {
            if d.len() == 1 {
                continue;
            }
            for sines in [true, false] {
                let (x, y) = (self.on_circles(&p, sines, budget)?, self.on_circles(&d, sines, budget)?);
                let g = x.gcd(&y, budget)?;
                if g.is_constant() {
                    continue;
                }
                let (c, top) = x.exact_quotient(&g, budget)?.primitive();
                let (e, rest) = y.exact_quotient(&g, budget)?.primitive();
                product.coefficient = &product.coefficient * &c / &e;
                multiply(&mut product.factors, &d, 1);
                if !rest.is_constant() {
                    multiply(&mut product.factors, &rest, -1);
                }
                p = top;
                break;
            }
            if p.is_constant() {
                return Some(());
            }
        }
        let (c, factors) = self.without_content(&p, budget)?;
        product.coefficient = &product.coefficient * &c;
        for (q, k) in factors {
            multiply(&mut product.factors, &q, k);
        }
        Some(())
    }

    /// A rational number, powers of atoms and one primitive polynomial.
    fn without_content(&self, p: &Polynomial, budget: &mut Budget) -> Option<(Rational, Factors)> {
        let p = self.fewest_terms(p, budget)?;
        if p.is_zero() {
            return Some((Rational::ZERO, Vec::new()));
        }
        let content = p.monomial_content();
        let (c, p) = p.divided_by_monomial(&content)?.primitive();
        let mut factors: Factors = powers(&content);
        if !p.is_constant() {
            factors.push((p, 1));
        }
        Some((c, factors))
    }

    /// Splits off factors that leave out an atom.
    fn split(factors: Factors, budget: &mut Budget) -> Option<Factors> {
        let mut done: Factors = Vec::new();
        let mut open = factors;
        while let Some((p, k)) = open.pop() {
            let divisor = p.support().into_iter().find_map(|v| {
                let c = p.content_in(v, budget)?;
                (!c.is_constant()).then_some(c)
            });
            match divisor {
                Some(c) if p.len() > 1 && c != p => {
                    open.push((p.exact_quotient(&c, budget)?.primitive().1, k));
                    open.push((c.primitive().1, k));
                }
                _ => multiply(&mut done, &p, k),
            }
        }
        Some(done)
    }
}

fn powers(m: &Monomial) -> Factors {
    m.iter().enumerate().filter(|x| *x.1 > 0).map(|(i, &k)| (Polynomial::atom(i), k as i32)).collect()
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
