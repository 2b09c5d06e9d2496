//! Products of powers of polynomials in the functions and symbols of an expression.

use bracketry_symbolic::{Expr, Node, Pool, Rational};
use rustc_hash::FxHashMap;

use super::polynomial::{Budget, Monomial, Polynomial};

/// Products of terms that one expression may take.
pub(super) const MAX_PRODUCTS: usize = 30_000;
/// Terms of a sum that is written out.
const MAX_TERMS: usize = 250;
pub(super) type Factors = Vec<(Polynomial, i32)>;

/// `coefficient · Π polynomial^exponent`; polynomials are primitive, and atoms stand alone.
#[derive(Clone)]
pub(super) struct Product {
    pub(super) coefficient: Rational,
    pub(super) factors: Factors,
}

/// The functions and symbols that polynomials are formed of.
#[derive(Default)]
pub(super) struct Ring {
    pub(super) atoms: Vec<Expr>,
    index: FxHashMap<Expr, usize>,
    /// Atoms (sin a, cos a).
    circles: Vec<(usize, usize)>,
    /// Atom √p and the polynomial p.
    roots: Vec<(usize, Polynomial)>,
}

pub(super) fn product_of(a: &Product, b: &Product) -> Product {
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

    pub(super) fn atom(&mut self, e: Expr) -> Product {
        let i = self.number(e);
        Product { coefficient: Rational::ONE, factors: vec![(Polynomial::atom(i), 1)] }
    }

    /// sin a, cos a, or tan a = sin a / cos a.
    pub(super) fn trigonometric(&mut self, pool: &mut Pool, e: Expr, argument: Expr) -> Product {
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

    pub(super) fn power(&mut self, pool: &mut Pool, e: Expr, base: &Product, exponent: Expr) -> Option<Product> {
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

    pub(super) fn sum(&mut self, a: &Product, b: &Product, budget: &mut Budget) -> Option<Product> {
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
    pub(super) fn cancel(&self, product: &mut Product, p: Polynomial, k: i32, budget: &mut Budget) -> Option<()> {
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
    pub(super) fn split(factors: Factors, budget: &mut Budget) -> Option<Factors> {
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

impl Ring {
    /// The polynomial with every sin² written by cos², or every cos² by sin², and √p² by p.
    pub(super) fn on_circles(&self, p: &Polynomial, sines: bool, budget: &mut Budget) -> Option<Polynomial> {
        let mut p = p.clone();
        for (i, square) in &self.roots {
            p = replace_squares(&p, *i, square, budget)?;
        }
        for &(s, c) in &self.circles {
            p = on_circle(&p, if sines { s } else { c }, if sines { c } else { s }, budget)?;
        }
        Some(p)
    }

    /// The form with the fewest terms, each circle taken for itself.
    pub(super) fn fewest_terms(&self, p: &Polynomial, budget: &mut Budget) -> Option<Polynomial> {
        let mut best = p.clone();
        for (i, square) in &self.roots {
            best = replace_squares(&best, *i, square, budget)?;
        }
        for &(s, c) in &self.circles {
            let forms = [on_circle(&best, s, c, budget)?, on_circle(&best, c, s, budget)?];
            for q in forms {
                if q.len() < best.len() {
                    best = q;
                }
            }
        }
        Some(best)
    }
}

/// The polynomial with a² = 1 − b² used until a stands alone at most.
fn on_circle(p: &Polynomial, a: usize, b: usize, budget: &mut Budget) -> Option<Polynomial> {
    let mut square = Polynomial::constant(&Rational::ONE);
    square.add(&Polynomial::atom(b).pow(2, budget)?, &-Rational::ONE);
    replace_squares(p, a, &square, budget)
}

fn replace_squares(p: &Polynomial, a: usize, square: &Polynomial, budget: &mut Budget) -> Option<Polynomial> {
    if p.degree(a) < 2 {
        return Some(p.clone());
    }
    let mut total = Polynomial::default();
    for (k, c) in p.coefficients(a).into_iter().enumerate() {
        let mut term = c.mul(&square.pow(k as u32 / 2, budget)?, budget)?;
        if k % 2 == 1 {
            term = term.mul(&Polynomial::atom(a), budget)?;
        }
        total.add(&term, &Rational::ONE);
    }
    Some(total)
}
