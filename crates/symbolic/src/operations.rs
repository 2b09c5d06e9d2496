//! The operations: constructors with light local rules.

use dashu_ratio::RBig;

use crate::func::{Func, Func2};
use crate::node::{Expr, Node};
use crate::pool::{MINUS_ONE, ONE, Pool, ZERO};

/// Numeric powers are folded up to this exponent; beyond it they stay symbolic.
const MAX_FOLDED_EXPONENT: i64 = 256;

impl Pool {
    /// Splits `c·rest` into the rational `c` and `rest` (1 for a plain number).
    pub(crate) fn coefficient(&mut self, e: Expr) -> (RBig, Expr) {
        match self.node(e) {
            Node::Num(i) => (self.numbers[i as usize].clone(), self.int(1)),
            Node::Mul(a, b) => match self.number(a) {
                Some(c) => (c.clone(), b),
                None => (RBig::ONE, e),
            },
            _ => (RBig::ONE, e),
        }
    }

    /// What a node stands for, by the local rules.
    pub(crate) fn make(&mut self, node: Node) -> Expr {
        match node {
            Node::Num(_) | Node::Pi | Node::Sym(_) => self.intern(node),
            Node::Add(a, b) => self.add(a, b),
            Node::Mul(a, b) => self.mul(a, b),
            Node::Pow(a, b) => self.pow(a, b),
            Node::Call(f, a) => self.call(f, a),
            Node::Call2(f, a, b) => self.call2(f, a, b),
        }
    }

    /// `a + b`
    pub fn add(&mut self, a: Expr, b: Expr) -> Expr {
        let (a, b) = self.ordered(a, b);
        if let Node::Num(x) = self.node(a) {
            if x == ZERO {
                return b;
            }
            match self.node(b) {
                Node::Num(y) => return self.sum_of_numbers(x, y),
                // x + (y + rest) = (x + y) + rest
                Node::Add(p, q) => {
                    if let Node::Num(y) = self.node(p) {
                        let s = self.sum_of_numbers(x, y);
                        return self.add(s, q);
                    }
                }
                _ => {}
            }
            return self.intern(Node::Add(a, b));
        }
        let ((ca, ra), (cb, rb)) = (self.term(a), self.term(b));
        if ra == rb {
            let c = self.sum_of_numbers(ca, cb);
            return self.mul(c, ra);
        }
        // Keep a number in front of the whole sum.
        if let Node::Add(p, q) = self.node(b)
            && self.is_number(p)
        {
            let s = self.add(a, q);
            return self.add(p, s);
        }
        if let Node::Add(p, q) = self.node(a)
            && self.is_number(p)
        {
            let s = self.add(q, b);
            return self.add(p, s);
        }
        self.intern(Node::Add(a, b))
    }

    /// Splits `c·rest` into the number `c` and `rest`, for anything but a number itself.
    fn term(&self, e: Expr) -> (u32, Expr) {
        if let Node::Mul(a, b) = self.node(e)
            && let Node::Num(c) = self.node(a)
        {
            return (c, b);
        }
        (ONE, e)
    }

    fn is_number(&self, e: Expr) -> bool {
        matches!(self.node(e), Node::Num(_))
    }

    /// `a - b`
    pub fn sub(&mut self, a: Expr, b: Expr) -> Expr {
        let n = self.neg(b);
        self.add(a, n)
    }

    /// `-a`
    pub fn neg(&mut self, a: Expr) -> Expr {
        let m = self.numbered(MINUS_ONE);
        self.mul(m, a)
    }

    /// `a · b`
    pub fn mul(&mut self, a: Expr, b: Expr) -> Expr {
        let (a, b) = self.ordered(a, b);
        if let Node::Num(x) = self.node(a) {
            if x == ZERO {
                return a;
            }
            if x == ONE {
                return b;
            }
            match self.node(b) {
                Node::Num(y) => return self.product_of_numbers(x, y),
                Node::Mul(p, q) => {
                    if let Node::Num(y) = self.node(p) {
                        let c = self.product_of_numbers(x, y);
                        return self.mul(c, q);
                    }
                }
                _ => {}
            }
            return self.intern(Node::Mul(a, b));
        }
        let ((pa, ea), (pb, eb)) = (self.numeric_power(a), self.numeric_power(b));
        if pa == pb {
            let e = self.sum_of_numbers(ea, eb);
            return self.pow(pa, e);
        }
        if let Node::Mul(p, q) = self.node(a)
            && self.is_number(p)
        {
            let s = self.mul(q, b);
            return self.mul(p, s);
        }
        if let Node::Mul(p, q) = self.node(b)
            && self.is_number(p)
        {
            let s = self.mul(a, q);
            return self.mul(p, s);
        }
        self.intern(Node::Mul(a, b))
    }

    /// Splits `base^k` with a number `k` into base and exponent (`k = 1` for anything else).
    fn numeric_power(&self, e: Expr) -> (Expr, u32) {
        if let Node::Pow(b, k) = self.node(e)
            && let Node::Num(k) = self.node(k)
        {
            return (b, k);
        }
        (e, ONE)
    }

    /// `a / b`
    pub fn div(&mut self, a: Expr, b: Expr) -> Expr {
        let m = self.int(-1);
        let inverse = self.pow(b, m);
        self.mul(a, inverse)
    }

    /// `a ^ b`. `0^(-1)` stays as it is: it has no value and no zero test will give it one.
    pub fn pow(&mut self, a: Expr, b: Expr) -> Expr {
        if self.is_zero(b) {
            return self.int(1);
        }
        if self.is_one(b) || self.is_one(a) {
            return a;
        }
        if let Some(k) = self.integer(b) {
            if let Some(x) = self.number(a).cloned() {
                if x == RBig::ZERO {
                    return if k > 0 { a } else { self.intern(Node::Pow(a, b)) };
                }
                if k.abs() <= MAX_FOLDED_EXPONENT {
                    let p = x.pow(k.unsigned_abs() as isize);
                    return self.rational(if k < 0 { RBig::ONE / p } else { p });
                }
            }
            match self.node(a) {
                // (u^c)^k = u^(c k) holds for integer k whatever c is.
                Node::Pow(u, c) => {
                    let e = self.mul(c, b);
                    return self.pow(u, e);
                }
                Node::Mul(c, u) if self.number(c).is_some() => {
                    let ck = self.pow(c, b);
                    let uk = self.pow(u, b);
                    return self.mul(ck, uk);
                }
                _ => {}
            }
        }
        self.intern(Node::Pow(a, b))
    }

    /// `a ^ k` for an integer `k`.
    pub fn powi(&mut self, a: Expr, k: i64) -> Expr {
        let k = self.int(k);
        self.pow(a, k)
    }

    /// `a^(1/2)`
    pub fn sqrt(&mut self, a: Expr) -> Expr {
        let h = self.ratio(1, 2);
        self.pow(a, h)
    }

    /// `f(a)`; known values at 0 and parities are applied.
    pub fn call(&mut self, f: Func, a: Expr) -> Expr {
        if let Some(x) = self.number(a) {
            let s = x.cmp(&RBig::ZERO);
            if s == std::cmp::Ordering::Equal {
                match f {
                    Func::Cos | Func::Cosh | Func::Exp => return self.int(1),
                    Func::Acos | Func::Log => {}
                    _ => return a,
                }
            }
            match f {
                Func::Log if *x == RBig::ONE => return self.int(0),
                Func::Abs => {
                    let v = if s == std::cmp::Ordering::Less { -x.clone() } else { x.clone() };
                    return self.rational(v);
                }
                Func::Sign => return self.int(s as i64),
                _ => {}
            }
        }
        let (c, _) = if let Node::Num(c) = self.node(a) { (c, a) } else { self.term(a) };
        if c != ONE && self.numbers[c as usize] < RBig::ZERO {
            match f {
                Func::Cos | Func::Cosh | Func::Abs => {
                    let p = self.neg(a);
                    return self.call(f, p);
                }
                Func::Sin | Func::Tan | Func::Asin | Func::Atan | Func::Sinh | Func::Tanh | Func::Sign => {
                    let p = self.neg(a);
                    let v = self.call(f, p);
                    return self.neg(v);
                }
                _ => {}
            }
        }
        match (f, self.node(a)) {
            (Func::Exp, Node::Call(Func::Log, x)) | (Func::Log, Node::Call(Func::Exp, x)) => x,
            _ => self.intern(Node::Call(f, a)),
        }
    }

    /// `f(a, b)`
    pub fn call2(&mut self, f: Func2, a: Expr, b: Expr) -> Expr {
        if matches!(f, Func2::Min | Func2::Max) {
            if a == b {
                return a;
            }
            if let (Some(x), Some(y)) = (self.number(a), self.number(b)) {
                return if (x < y) == (f == Func2::Min) { a } else { b };
            }
        }
        self.intern(Node::Call2(f, a, b))
    }

    /// Sine.
    pub fn sin(&mut self, a: Expr) -> Expr {
        self.call(Func::Sin, a)
    }

    /// Cosine.
    pub fn cos(&mut self, a: Expr) -> Expr {
        self.call(Func::Cos, a)
    }

    /// Sum of all terms; 0 for none.
    pub fn sum(&mut self, terms: impl IntoIterator<Item = Expr>) -> Expr {
        let mut total = self.int(0);
        for t in terms {
            total = self.add(total, t);
        }
        total
    }

    /// Numbers first, then by id, so that commuting operands meet.
    fn ordered(&self, a: Expr, b: Expr) -> (Expr, Expr) {
        match (self.is_number(a), self.is_number(b)) {
            (true, false) => (a, b),
            (false, true) => (b, a),
            _ if a <= b => (a, b),
            _ => (b, a),
        }
    }
}
