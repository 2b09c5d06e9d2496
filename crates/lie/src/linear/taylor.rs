//! Taylor polynomials.

use std::cmp::Ordering;

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Rational, Real, Symbol};
use rustc_hash::FxHashMap;

use crate::evidence::Evidence;
use crate::linear::polynomial::{MAX_TERMS, MultivariatePolynomial, RealPolynomial};

/// Most variables.
const MAX_VARIABLES: usize = 6;
/// Larger expressions, written out as trees, are not expanded.
const MAX_TREE: f64 = 500.0;

impl MultivariatePolynomial {
    /// `e` as a polynomial in the symbols, or else its [Taylor polynomial](Self::taylor) of a degree.
    pub(crate) fn of_or_taylor(pool: &mut Pool, e: Expr, symbols: &[Symbol], degree: usize) -> Option<Self> {
        Self::of(pool, e, symbols).or_else(|| Self::taylor(pool, e, symbols, degree))
    }

    /// The Taylor polynomial at the origin of the symbols, up to a degree; `None` if the function is not seen to be analytic there
    /// or a derivative not to be rational, and where a limit is reached.
    pub(crate) fn taylor(pool: &mut Pool, e: Expr, symbols: &[Symbol], degree: usize) -> Option<Self> {
        let mut p = Self::default();
        derivatives(pool, e, symbols, degree, &mut |pool, m, at, factorial| {
            p.add_term(m, pool.constant_rational(at)? / factorial);
            Some(())
        })?;
        Some(p)
    }
}

/// A polynomial whose coefficients are constant expressions over numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Terms(Vec<(Vec<u32>, Expr, Rational)>);

impl Terms {
    /// `e` as a polynomial in the symbols; `None` if it is none.
    pub(crate) fn of(pool: &mut Pool, e: Expr, symbols: &[Symbol]) -> Option<Self> {
        let found = pool.coefficients(e, symbols);
        let constant = |c: Expr| !symbols.iter().any(|&s| pool.depends_on(c, s));
        let all = found.len() <= MAX_TERMS && found.iter().all(|(_, c)| constant(*c));
        all.then(|| Terms(found.into_iter().map(|(m, c)| (m, c, Rational::ONE)).collect()))
    }

    /// As [`MultivariatePolynomial::taylor`].
    pub(crate) fn taylor(pool: &mut Pool, e: Expr, symbols: &[Symbol], degree: usize) -> Option<Self> {
        let mut terms = Self::default();
        derivatives(pool, e, symbols, degree, &mut |pool, m, at, factorial| {
            if !pool.is_zero(at) {
                terms.0.push((m, at, factorial.clone()));
            }
            Some(())
        })?;
        Some(terms)
    }

    pub(crate) fn of_or_taylor(pool: &mut Pool, e: Expr, symbols: &[Symbol], degree: usize) -> Option<Self> {
        Self::of(pool, e, symbols).or_else(|| Self::taylor(pool, e, symbols, degree))
    }

    /// The polynomial with exact coefficients, which do not count as evidence; `None` where one has no exact value.
    pub(crate) fn alone(&self, pool: &mut Pool) -> Option<RealPolynomial> {
        Self::with_values(pool, std::slice::from_ref(self), &mut Evidence::default())?.pop()
    }

    /// Polynomials with exact coefficients; `None` where one has no exact value.
    pub(crate) fn with_values(pool: &mut Pool, list: &[Terms], evidence: &mut Evidence) -> Option<Vec<RealPolynomial>> {
        let constants: Vec<Expr> = list.iter().flat_map(|t| t.0.iter().map(|t| t.1)).collect();
        let mut values = reals(pool, &constants, evidence)?.into_iter();
        let mut polynomials = Vec::new();
        for terms in list {
            let mut p = RealPolynomial::default();
            for (m, _, divisor) in &terms.0 {
                p.add_term(m.clone(), values.next()? / Real::from(divisor.clone()));
            }
            polynomials.push(p);
        }
        Some(polynomials)
    }
}

/// Constants as numbers that belong together.
pub(crate) fn reals(pool: &mut Pool, constants: &[Expr], evidence: &mut Evidence) -> Option<Vec<Real>> {
    let (values, samples) = pool.reals(constants)?;
    if let Some(samples) = samples {
        evidence.add_rank(&samples, constants.len()).ok()?;
    }
    Some(values)
}

/// What takes derivatives.
type Take<'a> = dyn FnMut(&mut Pool, Vec<u32>, Expr, &Rational) -> Option<()> + 'a;

/// The exponents, the value at the origin, and the product of factorials of each derivative up to a degree, as taken by `take`; `None` if
/// the function is not seen to be analytic there, a limit is reached, or `take` gives up.
fn derivatives(pool: &mut Pool, e: Expr, symbols: &[Symbol], degree: usize, take: &mut Take<'_>) -> Option<()> {
    let used: Vec<usize> = (0..symbols.len()).filter(|&i| pool.depends_on(e, symbols[i])).collect();
    let zero = pool.int(0);
    let origin: FxHashMap<Expr, Expr> = symbols.iter().map(|&s| (pool.sym(s), zero)).collect();
    if used.len() > MAX_VARIABLES || pool.tree_size(e) > MAX_TREE || !is_analytic(pool, e, &origin) {
        return None;
    }
    // Derivatives with their exponents and the product of factorials; each symbol only from the last one used on.
    let mut level = vec![(e, vec![0u32; symbols.len()], Rational::ONE, 0)];
    for order in 0..=degree {
        let mut next = Vec::new();
        for (d, m, factorial, from) in level {
            if pool.reached_limit().is_some() {
                return None;
            }
            let at = pool.substitute(d, &origin);
            take(pool, m.clone(), at, &factorial)?;
            if order < degree {
                for (k, &i) in used.iter().enumerate().skip(from) {
                    let mut m = m.clone();
                    m[i] += 1;
                    let factorial = factorial.clone() * Rational::from(m[i]);
                    let d = pool.diff(d, symbols[i]);
                    if !pool.is_zero(d) {
                        next.push((d, m, factorial, k));
                    }
                }
            }
        }
        level = next;
    }
    Some(())
}

/// Whether nothing in the function is seen to fail at the origin: denominators do not vanish there, roots and logarithms have
/// positive arguments, and other functions than those analytic everywhere do not occur.
pub(crate) fn is_analytic(pool: &mut Pool, e: Expr, origin: &FxHashMap<Expr, Expr>) -> bool {
    let sign = |pool: &mut Pool, e: Expr| {
        let at = pool.substitute(e, origin);
        let at = pool.simplify(at);
        pool.constant_sign(at, &Bindings::new())
    };
    pool.reachable(&[e]).into_iter().all(|e| match pool.node(e) {
        Node::Pow(base, k) => match (pool.integer(k), pool.number(k).is_some()) {
            (Some(k), _) if k >= 0 => true,
            (Some(_), _) => sign(pool, base).is_some_and(|s| s != Ordering::Equal),
            (None, true) => sign(pool, base) == Some(Ordering::Greater),
            (None, false) => false,
        },
        Node::Call(Func::Log, a) => sign(pool, a) == Some(Ordering::Greater),
        Node::Call(Func::Tan, a) => sign(pool, a) == Some(Ordering::Equal),
        Node::Num(_)
        | Node::Pi
        | Node::Sym(_)
        | Node::Add(..)
        | Node::Mul(..)
        | Node::Call(Func::Sin | Func::Cos | Func::Exp | Func::Sinh | Func::Cosh | Func::Tanh | Func::Atan, _) => true,
        Node::Call(..) | Node::Call2(..) => false,
    })
}
