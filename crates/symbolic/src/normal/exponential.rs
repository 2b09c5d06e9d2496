//! Exponential normal form: hyperbolic functions and powers as exponentials, one exponential per product.

use std::collections::BTreeMap;

use dashu_base::UnsignedAbs;
use dashu_ratio::RBig;

use super::{Form, MAX_TERMS, accumulate, normal_form};
use crate::func::Func;
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// Integers under logarithms are factored by trial division up to this.
const TRIAL: u64 = 1000;

impl Pool {
    /// `e` with hyperbolic functions written as exponentials, the exponentials and the powers of each product joined
    /// into one, and logarithms of products and powers taken apart where that holds for all values of the factors.
    ///
    /// Equal to `e` wherever `e` has a value. What would become very long stays as it is.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let mut form = |t: &str| {
    ///     let e = p.parse(t).unwrap();
    ///     let f = p.exp_form(e);
    ///     p.text(f)
    /// };
    /// assert_eq!(form("exp(a)*exp(b)"), "exp(a + b)");
    /// assert_eq!(form("cosh(x)^2 - sinh(x)^2"), "1");
    /// assert_eq!(form("tanh(x)^2 + 1/cosh(x)^2"), "1");
    /// assert_eq!(form("x^a*x^b"), "x^(a + b)");
    /// assert_eq!(form("log(6*exp(x)) - log(2)"), "x + log(3)");
    /// // x and y could both be negative.
    /// assert_eq!(form("log(x*y)"), "log(x*y)");
    /// ```
    pub fn exp_form(&mut self, e: Expr) -> Expr {
        normal_form::<Exponential>(self, e, MAX_TERMS)
    }

    /// (exp(2u) − 1, exp(2u) + 1)
    fn tanh_parts(&mut self, u: Expr) -> (Expr, Expr) {
        let (two, one, minus) = (self.int(2), self.int(1), self.int(-1));
        let v = self.mul(two, u);
        let v = self.expand(v);
        let e = self.call(Func::Exp, v);
        (self.add(e, minus), self.add(e, one))
    }

    /// Logarithm of a product, as far as it can be taken apart without knowing signs.
    fn logarithm_of_product(&mut self, a: Expr) -> Expr {
        let a = self.factor_common(a);
        let (coefficient, powers) = self.factored(a);
        let mut sum = Vec::new();
        let mut open = Vec::new();
        for (base, k) in powers {
            match self.node(base) {
                Node::Call(Func::Exp, u) => {
                    let k = self.rational(k);
                    sum.push(self.mul(k, u));
                }
                _ if self.is_positive(base) => {
                    let (k, l) = (self.rational(k), self.call(Func::Log, base));
                    sum.push(self.mul(k, l));
                }
                _ => open.push((base, k)),
            }
        }
        let mut rest = self.int(1);
        if coefficient > RBig::ZERO {
            sum.extend(self.logarithm_of_number(&coefficient));
        } else {
            rest = self.rational(coefficient.clone());
        }
        match open.as_slice() {
            // log(b^k) = k log b where b^k is positive only if b is, and k log |b| for even k.
            [(base, k)] if coefficient > RBig::ZERO => {
                let even = k.is_int() && k.numerator().trailing_zeros() != Some(0);
                let inside = if even { self.call(Func::Abs, *base) } else { *base };
                let (k, l) = (self.rational(k.clone()), self.call(Func::Log, inside));
                sum.push(self.mul(k, l));
            }
            [] if self.is_one(rest) => {}
            _ => {
                for (base, k) in open {
                    let k = self.rational(k);
                    let f = self.pow(base, k);
                    rest = self.mul(rest, f);
                }
                let rest = self.collected(rest);
                sum.push(self.call(Func::Log, rest));
            }
        }
        self.sum(sum)
    }

    /// The logarithms of the prime factors of a positive number, with their multiplicities.
    fn logarithm_of_number(&mut self, q: &RBig) -> Vec<Expr> {
        let mut out = Vec::new();
        for (mut n, sign) in [(q.numerator().clone().unsigned_abs(), 1), (q.denominator().clone(), -1)] {
            for p in 2..TRIAL {
                let mut k = 0;
                while (&n % p) == 0 {
                    n /= p;
                    k += 1;
                }
                if k > 0 {
                    let (k, p) = (self.int(sign * k), self.rational(RBig::from(p)));
                    let l = self.call(Func::Log, p);
                    out.push(self.mul(k, l));
                }
            }
            if n != dashu_int::UBig::ONE {
                let (k, n) = (self.int(sign), self.rational(RBig::from(n)));
                let l = self.call(Func::Log, n);
                out.push(self.mul(k, l));
            }
        }
        out
    }

    /// exp of a sum, where multiples of logarithms become powers: exp(u + a log v) = v^a exp(u).
    fn exponential_of_sum(&mut self, sum: Expr) -> Expr {
        let mut powers: BTreeMap<Expr, Vec<Expr>> = BTreeMap::new();
        let mut rest = Vec::new();
        for t in self.expanded_terms(sum) {
            let (coefficient, factors) = self.factored(t);
            let log = factors.iter().find_map(|(b, k)| match self.node(*b) {
                Node::Call(Func::Log, v) if *k == RBig::ONE => Some((*b, v)),
                _ => None,
            });
            let Some((log, v)) = log else {
                rest.push(t);
                continue;
            };
            let mut exponent = self.rational(coefficient);
            for (base, k) in factors.into_iter().filter(|(b, _)| *b != log) {
                let k = self.rational(k);
                let f = self.pow(base, k);
                exponent = self.mul(exponent, f);
            }
            powers.entry(v).or_default().push(exponent);
        }
        let rest = self.sum(rest);
        let rest = self.collected(rest);
        let mut product = self.call(Func::Exp, rest);
        for (v, exponents) in powers {
            let exponent = self.sum(exponents);
            let exponent = self.collected(exponent);
            let f = self.pow(v, exponent);
            product = self.mul(product, f);
        }
        product
    }
}

pub(super) struct Exponential;

impl Form for Exponential {
    fn function(pool: &mut Pool, e: Expr) -> Expr {
        match pool.node(e) {
            Node::Call(f @ (Func::Sinh | Func::Cosh), u) => {
                let minus = pool.neg(u);
                let minus = pool.expand(minus);
                let (a, b, half) = (pool.call(Func::Exp, u), pool.call(Func::Exp, minus), pool.ratio(1, 2));
                let s = if f == Func::Sinh { pool.sub(a, b) } else { pool.add(a, b) };
                pool.mul(half, s)
            }
            Node::Call(Func::Tanh, u) => {
                let (top, bottom) = pool.tanh_parts(u);
                pool.div(top, bottom)
            }
            Node::Call(Func::Log, a) => pool.logarithm_of_product(a),
            _ => e,
        }
    }

    fn concerns(pool: &Pool, base: Expr) -> bool {
        matches!(pool.node(base), Node::Add(..))
            && pool.reachable(&[base]).iter().any(|&n| matches!(pool.node(n), Node::Call(Func::Exp, _)))
    }

    fn polynomial(pool: &mut Pool, e: Expr, limit: usize) -> Option<BTreeMap<Expr, RBig>> {
        let all = pool.expanded_terms(e);
        if all.len() > limit {
            return None;
        }
        let mut sum = BTreeMap::new();
        for t in all {
            let (coefficient, powers) = pool.factored(t);
            let mut exponent = Vec::new();
            let mut factor = pool.int(1);
            let symbolic: Vec<Expr> = powers
                .iter()
                .filter_map(|(b, _)| if let Node::Pow(b, _) = pool.node(*b) { Some(b) } else { None })
                .collect();
            for (base, k) in powers {
                let k = pool.rational(k);
                match pool.node(base) {
                    Node::Call(Func::Exp, u) => exponent.push(pool.mul(k, u)),
                    // x·x^a = x^(a + 1), as exp((a + 1) log x).
                    Node::Pow(b, r) => {
                        let l = pool.call(Func::Log, b);
                        let v = pool.mul(r, l);
                        exponent.push(pool.mul(k, v));
                    }
                    _ if symbolic.contains(&base) => {
                        let l = pool.call(Func::Log, base);
                        exponent.push(pool.mul(k, l));
                    }
                    _ => {
                        let p = pool.pow(base, k);
                        factor = pool.mul(factor, p);
                    }
                }
            }
            let exponent = pool.sum(exponent);
            let power = pool.exponential_of_sum(exponent);
            let product = pool.mul(factor, power);
            let product = pool.collected(product);
            let (c, product) = pool.coefficient(product);
            accumulate(&mut sum, product, &(coefficient * c));
        }
        Some(sum)
    }
}
