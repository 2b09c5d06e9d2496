//! Derivatives, memoized by node and variable, and substitution.

use rustc_hash::FxHashMap;

use crate::func::{Func, Func2};
use crate::node::{Expr, Node, Symbol};
use crate::pool::{Pool, ZERO};

impl Pool {
    /// ∂e/∂s. The derivative of `sign` is 0 (its value off the switching surface).
    pub fn diff(&mut self, e: Expr, s: Symbol) -> Expr {
        if !self.may_depend_on(e, s) {
            return self.numbered(ZERO);
        }
        if let Some(&d) = self.derivatives.get(&(e, s)) {
            return d;
        }
        // Operands have smaller ids, so one ascending sweep over what is not known yet suffices.
        let mut pending = Vec::new();
        let mut stack = vec![e];
        let mut seen = rustc_hash::FxHashSet::default();
        while let Some(n) = stack.pop() {
            if !self.may_depend_on(n, s) || self.derivatives.contains_key(&(n, s)) || !seen.insert(n) {
                continue;
            }
            pending.push(n);
            stack.extend(self.node(n).operands());
        }
        pending.sort_unstable();
        for n in pending {
            let d = self.diff_node(n, s);
            self.derivatives.insert((n, s), d);
        }
        self.derivatives[&(e, s)]
    }

    /// The derivative of an operand, which is known.
    fn derivative(&mut self, e: Expr, s: Symbol) -> Expr {
        if self.may_depend_on(e, s) { self.derivatives[&(e, s)] } else { self.numbered(ZERO) }
    }

    fn diff_node(&mut self, n: Expr, s: Symbol) -> Expr {
        match self.node(n) {
            Node::Num(_) | Node::Pi => self.int(0),
            Node::Sym(t) => self.int(i64::from(t == s)),
            Node::Add(a, b) => {
                let (da, db) = (self.derivative(a, s), self.derivative(b, s));
                self.add(da, db)
            }
            Node::Mul(a, b) => {
                let (da, db) = (self.derivative(a, s), self.derivative(b, s));
                let p = self.mul(da, b);
                let q = self.mul(a, db);
                self.add(p, q)
            }
            Node::Pow(a, b) => {
                let (da, db) = (self.derivative(a, s), self.derivative(b, s));
                self.diff_power(n, a, b, da, db)
            }
            Node::Call(f, a) => {
                let da = self.derivative(a, s);
                if self.is_zero(da) {
                    return da;
                }
                let outer = self.diff_call(f, a, n);
                self.mul(outer, da)
            }
            Node::Call2(f, a, b) => {
                let (da, db) = (self.derivative(a, s), self.derivative(b, s));
                if self.is_zero(da) && self.is_zero(db) {
                    return da;
                }
                self.diff_call2(f, a, b, da, db)
            }
        }
    }

    fn diff_power(&mut self, n: Expr, a: Expr, b: Expr, da: Expr, db: Expr) -> Expr {
        let mut total = self.int(0);
        if !self.is_zero(da) {
            let m = self.int(-1);
            let k = self.add(b, m);
            let p = self.pow(a, k);
            let q = self.mul(p, da);
            total = self.mul(b, q);
        }
        if !self.is_zero(db) {
            let l = self.call(Func::Log, a);
            let p = self.mul(l, db);
            let q = self.mul(n, p);
            total = self.add(total, q);
        }
        total
    }

    /// f'(a), where `n` is f(a).
    fn diff_call(&mut self, f: Func, a: Expr, n: Expr) -> Expr {
        let one = self.int(1);
        match f {
            Func::Sin => self.call(Func::Cos, a),
            Func::Cos => {
                let s = self.call(Func::Sin, a);
                self.neg(s)
            }
            Func::Tan => {
                let q = self.powi(n, 2);
                self.add(one, q)
            }
            Func::Asin | Func::Acos => {
                let q = self.powi(a, 2);
                let d = self.sub(one, q);
                let e = self.ratio(-1, 2);
                let r = self.pow(d, e);
                if f == Func::Asin { r } else { self.neg(r) }
            }
            Func::Atan => {
                let q = self.powi(a, 2);
                let d = self.add(one, q);
                self.powi(d, -1)
            }
            Func::Sinh => self.call(Func::Cosh, a),
            Func::Cosh => self.call(Func::Sinh, a),
            Func::Tanh => {
                let q = self.powi(n, 2);
                self.sub(one, q)
            }
            Func::Exp => n,
            Func::Log => self.powi(a, -1),
            Func::Abs => self.call(Func::Sign, a),
            Func::Sign => self.int(0),
        }
    }

    fn diff_call2(&mut self, f: Func2, a: Expr, b: Expr, da: Expr, db: Expr) -> Expr {
        match f {
            // d atan2(y, x) = (x dy − y dx) / (x² + y²)
            Func2::Atan2 => {
                let p = self.mul(b, da);
                let q = self.mul(a, db);
                let top = self.sub(p, q);
                let aa = self.powi(a, 2);
                let bb = self.powi(b, 2);
                let bottom = self.add(aa, bb);
                self.div(top, bottom)
            }
            // min, max = (a + b ∓ |a − b|)/2
            Func2::Min | Func2::Max => {
                let gap = self.sub(a, b);
                let sgn = self.call(Func::Sign, gap);
                let sgn = if f == Func2::Min { self.neg(sgn) } else { sgn };
                let dgap = self.sub(da, db);
                let jump = self.mul(sgn, dgap);
                let mean = self.add(da, db);
                let twice = self.add(mean, jump);
                let half = self.ratio(1, 2);
                self.mul(half, twice)
            }
        }
    }

    /// Gradient of `e` along `variables`.
    pub fn gradient(&mut self, e: Expr, variables: &[Symbol]) -> Vec<Expr> {
        variables.iter().map(|&s| self.diff(e, s)).collect()
    }

    /// Jacobian, row by row: entry `[i][j]` is ∂f_i/∂v_j.
    pub fn jacobian(&mut self, f: &[Expr], variables: &[Symbol]) -> Vec<Vec<Expr>> {
        f.iter().map(|&e| self.gradient(e, variables)).collect()
    }

    /// Σ_i ∂e/∂x_i · field_i, the derivative of `e` along a vector field.
    pub fn lie_derivative(&mut self, e: Expr, variables: &[Symbol], field: &[Expr]) -> Expr {
        let mut total = self.int(0);
        for (&s, &v) in variables.iter().zip(field) {
            if self.is_zero(v) || !self.may_depend_on(e, s) {
                continue;
            }
            let d = self.diff(e, s);
            let p = self.mul(d, v);
            total = self.add(total, p);
        }
        total
    }

    /// Replaces whole sub-expressions at once (replacements are not searched).
    pub fn substitute(&mut self, e: Expr, map: &FxHashMap<Expr, Expr>) -> Expr {
        self.substitute_all(&[e], map)[0]
    }

    /// [`Pool::substitute`] for many expressions, sharing the work.
    pub fn substitute_all(&mut self, roots: &[Expr], map: &FxHashMap<Expr, Expr>) -> Vec<Expr> {
        let mut new: FxHashMap<Expr, Expr> = FxHashMap::default();
        for e in self.reachable(roots) {
            let r = if let Some(&r) = map.get(&e) { r } else { self.rebuild(e, |x| new[&x]) };
            if let Some(how) = self.directed(e).filter(|_| r != e) {
                self.set_directed(r, how);
            }
            new.insert(e, r);
        }
        roots.iter().map(|e| new[e]).collect()
    }

    /// The node of `e` rebuilt from the images of its operands.
    pub fn rebuild(&mut self, e: Expr, image: impl Fn(Expr) -> Expr) -> Expr {
        let node = self.node(e);
        if node.operands().all(|o| image(o) == o) {
            return e;
        }
        self.make(node.with_operands(image))
    }
}
