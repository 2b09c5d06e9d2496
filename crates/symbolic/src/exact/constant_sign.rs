//! Signs and values of constants: intervals with ends of growing precision, and the zero test where they do not leave 0.

use std::cmp::Ordering;

use dashu_ratio::RBig;

use super::interval::Interval;
use super::{Bindings, ZeroTest};
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// Bits of the ends, one attempt after the other.
const BITS: [usize; 5] = [64, 128, 256, 512, 1024];
/// Larger expressions are not looked at.
pub(super) const MAX_NODES: usize = 20_000;

impl Pool {
    /// The sign of a constant; `None` where 1024 bits do not tell it from zero and the zero test finds it nonzero or is undecided,
    /// or where it has symbols without values, or no value.
    ///
    /// ```
    /// use bracketry_symbolic::{Bindings, Pool};
    /// let mut p = Pool::new();
    /// let mut sign = |e: &str| {
    ///     let e = p.parse(e).unwrap();
    ///     p.constant_sign(e, &Bindings::new())
    /// };
    /// assert_eq!(sign("sqrt(2)*sqrt(3) - sqrt(6)"), Some(std::cmp::Ordering::Equal));
    /// // Nearer to zero than floating-point numbers can tell.
    /// assert_eq!(sign("exp(pi*sqrt(163)) - 262537412640768744"), Some(std::cmp::Ordering::Less));
    /// assert_eq!(sign("x - x^2"), None);
    /// ```
    pub fn constant_sign(&mut self, e: Expr, bindings: &Bindings) -> Option<Ordering> {
        if let Some(q) = self.number(e) {
            return Some(q.cmp(&RBig::ZERO));
        }
        self.enclosed(e, bindings, Interval::sign)
    }

    /// The value of a constant that is seen to be rational: where simplification gives a number, or it is zero.
    pub fn constant_rational(&mut self, e: Expr) -> Option<RBig> {
        let e = self.simplify(e);
        if let Some(q) = self.number(e) {
            return Some(q.clone());
        }
        (self.constant_sign(e, &Bindings::new()) == Some(Ordering::Equal)).then_some(RBig::ZERO)
    }

    /// The value of a constant as the nearest `f64` or one beside it, whatever cancels; `None` where it has no value, or as for
    /// [`Pool::constant_sign`].
    ///
    /// ```
    /// use bracketry_symbolic::{Bindings, Pool};
    /// let mut p = Pool::new();
    /// let e = p.parse("(1 - cos(x))/x^2 - 1/2").unwrap();
    /// let (x, small) = (p.var("x"), p.parse("10^(-10)").unwrap());
    /// let e = p.substitute(e, &[(x, small)].into_iter().collect());
    /// // −x²/24; floating-point numbers give −1/2.
    /// let value = p.constant_value(e, &Bindings::new()).unwrap();
    /// assert!((value * 24e20 + 1.0).abs() < 1e-15);
    /// ```
    pub fn constant_value(&mut self, e: Expr, bindings: &Bindings) -> Option<f64> {
        if let Some(q) = self.number(e) {
            return Some(q.to_f64().value()).filter(|v| v.is_finite());
        }
        self.enclosed(e, bindings, Interval::value)
    }

    /// What the first of growing intervals tells that tells enough; what it tells of 0 where the constant is zero.
    fn enclosed<T>(&mut self, e: Expr, bindings: &Bindings, tell: impl Fn(&Interval) -> Option<T>) -> Option<T> {
        let nodes = self.reachable(&[e]);
        let is_open = |n: &Expr| matches!(self.node(*n), Node::Sym(s) if bindings.get(s).is_none());
        if nodes.len() > MAX_NODES || nodes.iter().any(is_open) {
            return None;
        }
        for (attempt, bits) in BITS.into_iter().enumerate() {
            if self.reached_limit().is_some() {
                return None;
            }
            let found = Interval::of_constant(self, &nodes, bindings, bits);
            if let Some(told) = found.as_ref().filter(|i| !i.holds_zero()).and_then(&tell) {
                return Some(told);
            }
            if attempt == 0 && found.as_ref().is_none_or(Interval::holds_zero) {
                match self.zero_test(e, bindings) {
                    ZeroTest::Zero(_) => return found.and_then(|_| tell(&Interval::of(&RBig::ZERO, bits))),
                    ZeroTest::NonZero | ZeroTest::Unknown(_) => {}
                }
            }
        }
        None
    }
}
