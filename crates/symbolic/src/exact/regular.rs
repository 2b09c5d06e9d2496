//! Where expressions have no value or jump.

use std::cmp::Ordering;

use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use super::{Bindings, ZeroTest};
use crate::func::{Func, Func2};
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// What an expression lacks at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Irregular {
    /// This sub-expression has no real value there, as log(x) at 0, or none that floating-point evaluation gives, as powers of negative
    /// numbers with exponents that are not whole.
    NoValue(Expr),
    /// This sub-expression jumps there: atan2 on the negative axis.
    Jump(Expr),
}

impl Pool {
    /// The first sub-expression that has no value or jumps where the keys of `at` take its constant values; `None` where there is none, as far
    /// as signs of constants are known.
    ///
    /// ```
    /// use bracketry_symbolic::{Irregular, Pool};
    /// let mut p = Pool::new();
    /// let e = p.parse("y*log(x)").unwrap();
    /// let (x, minus_one) = (p.var("x"), p.int(-1));
    /// let found = p.irregular_at(&[e], &[(x, minus_one)].into_iter().collect());
    /// assert!(matches!(found, Some(Irregular::NoValue(log)) if p.text(log) == "log(x)"));
    /// ```
    pub fn irregular_at(&mut self, roots: &[Expr], at: &FxHashMap<Expr, Expr>) -> Option<Irregular> {
        for e in self.reachable(roots) {
            let no_value = match self.node(e) {
                Node::Pow(base, k) => {
                    let Some(k) = self.number(k).filter(|k| !k.is_int() || **k < RBig::ZERO).cloned() else { continue };
                    match self.sign_at(base, at) {
                        Some(Ordering::Less) => !k.is_int(),
                        Some(Ordering::Equal) => k < RBig::ZERO,
                        _ => false,
                    }
                }
                Node::Call(Func::Log, a) => matches!(self.sign_at(a, at), Some(Ordering::Less | Ordering::Equal)),
                Node::Call(Func::Tan, a) => {
                    let cosine = self.cos(a);
                    let here = self.substitute(cosine, at);
                    matches!(self.zero_test(here, &Bindings::new()), ZeroTest::Zero(_))
                }
                Node::Call(Func::Asin | Func::Acos, a) => {
                    let (one, square) = (self.int(1), self.powi(a, 2));
                    let rest = self.sub(one, square);
                    self.sign_at(rest, at) == Some(Ordering::Less)
                }
                Node::Call2(Func2::Atan2, y, x) => match (self.sign_at(y, at), self.sign_at(x, at)) {
                    (Some(Ordering::Equal), Some(Ordering::Less)) => return Some(Irregular::Jump(e)),
                    (Some(Ordering::Equal), Some(Ordering::Equal)) => true,
                    _ => false,
                },
                _ => false,
            };
            if no_value {
                return Some(Irregular::NoValue(e));
            }
        }
        None
    }

    /// Functions with values for some real arguments only (roots and other powers that are not whole, logarithms, inverse sines and
    /// cosines) that were made in this pool and that `roots` do not use: after expressions were read, those that cancel in them.
    ///
    /// ```
    /// use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("sqrt(x)^2 + log(y)").unwrap();
    /// assert_eq!(p.text(e), "x + log(y)");
    /// let canceled = p.unused_partial_functions(&[e]);
    /// assert_eq!(canceled.iter().map(|&f| p.text(f)).collect::<Vec<_>>(), ["sqrt(x)"]);
    /// ```
    pub fn unused_partial_functions(&self, roots: &[Expr]) -> Vec<Expr> {
        let used = self.reachable(roots);
        let partial = |e: &Expr| match self.node(*e) {
            Node::Pow(_, k) => self.number(k).is_none_or(|k| !k.is_int()),
            Node::Call(f, _) => matches!(f, Func::Log | Func::Asin | Func::Acos),
            _ => false,
        };
        self.all().filter(partial).filter(|e| used.binary_search(e).is_err()).collect()
    }

    fn sign_at(&mut self, e: Expr, at: &FxHashMap<Expr, Expr>) -> Option<Ordering> {
        let here = self.substitute(e, at);
        self.constant_sign(here, &Bindings::new())
    }
}
