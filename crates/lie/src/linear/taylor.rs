//! Taylor polynomials.

use bracketry_symbolic::{Expr, Func, Node, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

use crate::linear::polynomial::MultivariatePolynomial;

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
        let used: Vec<usize> = (0..symbols.len()).filter(|&i| pool.depends_on(e, symbols[i])).collect();
        let zero = pool.int(0);
        let origin: FxHashMap<Expr, Expr> = symbols.iter().map(|&s| (pool.sym(s), zero)).collect();
        if used.len() > MAX_VARIABLES || pool.tree_size(e) > MAX_TREE || !is_analytic(pool, e, &origin) {
            return None;
        }
        let mut p = Self::default();
        // Derivatives with their exponents and the product of factorials; each symbol only from the last one used on.
        let mut level = vec![(e, vec![0u32; symbols.len()], Rational::ONE, 0)];
        for order in 0..=degree {
            let mut next = Vec::new();
            for (d, m, factorial, from) in level {
                if pool.reached_limit().is_some() {
                    return None;
                }
                let at = pool.substitute(d, &origin);
                let value = pool.constant_rational(at)?;
                p.add_term(m.clone(), value / &factorial);
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
        Some(p)
    }
}

/// Whether nothing in the function is seen to fail at the origin: denominators do not vanish there, roots and logarithms have
/// positive arguments, and other functions than those analytic everywhere do not occur.
pub(crate) fn is_analytic(pool: &mut Pool, e: Expr, origin: &FxHashMap<Expr, Expr>) -> bool {
    let value = |pool: &mut Pool, e: Expr| {
        let at = pool.substitute(e, origin);
        let at = pool.simplify(at);
        pool.number(at).cloned()
    };
    pool.reachable(&[e]).into_iter().all(|e| match pool.node(e) {
        Node::Pow(base, k) => match (pool.integer(k), pool.number(k).is_some()) {
            (Some(k), _) if k >= 0 => true,
            (Some(_), _) => value(pool, base).is_some_and(|v| v != Rational::ZERO),
            (None, true) => value(pool, base).is_some_and(|v| v > Rational::ZERO),
            (None, false) => false,
        },
        Node::Call(Func::Log, a) => value(pool, a).is_some_and(|v| v > Rational::ZERO),
        Node::Call(Func::Tan, a) => value(pool, a) == Some(Rational::ZERO),
        Node::Num(_)
        | Node::Pi
        | Node::Sym(_)
        | Node::Add(..)
        | Node::Mul(..)
        | Node::Call(Func::Sin | Func::Cos | Func::Exp | Func::Sinh | Func::Cosh | Func::Tanh | Func::Atan, _) => true,
        Node::Call(..) | Node::Call2(..) => false,
    })
}
