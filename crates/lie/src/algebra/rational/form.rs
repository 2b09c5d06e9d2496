//! The form in which a polynomial of atoms is printed.

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Rational, Symbol};

use super::polynomial::{Budget, Monomial, Polynomial};
use super::ring::{Factors, MAX_PRODUCTS, Ring};

impl Ring {
    pub(super) fn expression(&self, pool: &mut Pool, p: &Polynomial) -> Expr {
        let mut sum = pool.int(0);
        for (m, c) in p.terms() {
            let mut term = pool.rational(c.clone());
            for (i, &k) in m.iter().enumerate().filter(|x| *x.1 > 0) {
                let power = pool.powi(self.atoms[i], i64::from(k));
                term = pool.mul(term, power);
            }
            sum = pool.add(sum, term);
        }
        sum
    }

    pub(super) fn shortest(&self, pool: &mut Pool, p: &Polynomial) -> Expr {
        let form = self.fewest_terms(p, &mut Budget::new(MAX_PRODUCTS)).unwrap_or_else(|| p.clone());
        self.expression(pool, &form)
    }

    pub(super) fn product(&self, pool: &mut Pool, coefficient: &Rational, factors: &Factors) -> Expr {
        let mut e = pool.rational(coefficient.clone());
        for (p, k) in factors {
            let base = self.shortest(pool, p);
            let base = pool.simplify(base);
            let power = pool.powi(base, i64::from(*k));
            e = pool.mul(e, power);
        }
        e
    }

    /// Whether p is seen to have no zero: it holds no state, or all its terms are squares times
    /// positive constants and one of them is positive itself.
    pub(super) fn never_zero(&self, pool: &Pool, p: &Polynomial, states: &[Symbol], bindings: &Bindings) -> bool {
        let moves = |e: Expr| pool.symbols_of(&[e]).iter().any(|s| states.contains(s));
        if p.support().iter().all(|&i| !moves(self.atoms[i])) {
            return true;
        }
        // The sign of a constant that is known, or of a function that has only one.
        let positive = |e: Expr| match pool.node(e) {
            Node::Sym(s) => bindings.get(s).is_some_and(|v| *v > Rational::ZERO),
            Node::Call(Func::Exp | Func::Cosh, _) | Node::Pi => true,
            _ => false,
        };
        let negative = |e: Expr| match pool.node(e) {
            Node::Sym(s) => bindings.get(s).is_some_and(|v| *v < Rational::ZERO),
            _ => false,
        };
        let forms = [true, false].map(|sines| self.on_circles(p, sines, &mut Budget::new(MAX_PRODUCTS)));
        [Some(p.clone())].into_iter().chain(forms).flatten().any(|q| {
            let mut definite = false;
            let sign = |m: &Monomial, c: &Rational| {
                let mut sign = if *c > Rational::ZERO { 1 } else { -1 };
                let mut strict = true;
                for (i, &k) in m.iter().enumerate().filter(|x| *x.1 > 0) {
                    let atom = self.atoms[i];
                    if positive(atom) {
                    } else if negative(atom) {
                        sign *= if k % 2 == 0 { 1 } else { -1 };
                    } else if k % 2 == 0 {
                        strict = false;
                    } else {
                        return None;
                    }
                }
                Some((sign, strict))
            };
            let signs: Option<Vec<(i32, bool)>> = q.terms().map(|(m, c)| sign(m, c)).collect();
            signs.is_some_and(|list| {
                definite |= list.iter().any(|s| s.1);
                definite && list.iter().all(|s| s.0 == list[0].0)
            })
        })
    }
}
