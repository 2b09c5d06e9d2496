//! Products of a function of one input and a function of another that are written as a sum.

use bracketry_symbolic::{Bindings, Expr, Rational, Symbol};
use rustc_hash::FxHashMap;

use crate::images::{Images, number};
use crate::interval::Interval;

/// Simple values of an input at which a product is split, those in its interval.
const PLACES: [(i64, i64); 5] = [(0, 1), (1, 1), (-1, 1), (1, 2), (-1, 2)];

/// Parts of a closed interval at which a product is split where no simple value lies in it.
const PARTS: [(i64, i64); 3] = [(1, 2), (1, 3), (3, 4)];

impl Images<'_> {
    /// The image of e(u, w) = e(u, w₀) e(u₀, w)/e(u₀, w₀), which are independent factors; `None` for another function.
    pub(crate) fn of_separable(&mut self, e: Expr, [u, w]: [Symbol; 2]) -> Option<Interval> {
        let (x, y) = (self.place(e, u, w)?, self.place(e, w, u)?);
        let [at_u, at_w] = [(u, x), (w, y)].map(|(s, value)| FxHashMap::from_iter([(self.pool.sym(s), value)]));
        let (of_w, of_u) = (self.pool.substitute(e, &at_u), self.pool.substitute(e, &at_w));
        let here = self.pool.substitute(of_w, &at_w);
        number(self.pool, here).filter(|v| v.abs() > 1e-6)?;
        let (left, right) = (self.pool.mul(e, here), self.pool.mul(of_u, of_w));
        let difference = self.pool.sub(left, right);
        if !self.pool.zero_test(difference, &Bindings::default()).is_zero() {
            return None;
        }
        let scaled = self.pool.div(of_u, here);
        let scaled = self.pool.simplify(scaled);
        let (a, b) = (self.of(scaled).ok()?, self.of(of_w).ok()?);
        a.product(self.pool, &b)
    }

    /// A simple value of `u` in its interval at which `e` is no constant in the other input.
    fn place(&mut self, e: Expr, u: Symbol, other: Symbol) -> Option<Expr> {
        let on = self.domain[&u].clone();
        let rational = |(p, q): (i64, i64)| Rational::from(p) / Rational::from(q);
        let mut places: Vec<Rational> = PLACES.map(rational).into();
        let ends = [&on.lower, &on.upper].map(|end| end.exact.and_then(|x| self.pool.number(x).cloned()));
        if let [Some(lower), Some(upper)] = ends {
            places.extend(PARTS.map(|part| &lower + (&upper - &lower) * rational(part)));
        }
        for value in places {
            if !on.holds(value.to_f64().value()) {
                continue;
            }
            let value = self.pool.rational(value);
            let variable = self.pool.sym(u);
            let there = self.pool.substitute(e, &FxHashMap::from_iter([(variable, value)]));
            if self.pool.depends_on(there, other) {
                return Some(value);
            }
        }
        None
    }
}
