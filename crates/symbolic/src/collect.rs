//! Keeping only what is needed of a pool: by giving memory back, or in a pool of its own.

use crate::node::Expr;
use crate::pool::Pool;

impl Pool {
    /// Frees the nodes made since the pool had `from` of them ([`Pool::len`]), but for those that `roots` reach,
    /// and the memory of derivatives that they were part of.
    ///
    /// Expressions older than `from` stay valid; `roots` are replaced by their new ids. **Every other expression
    /// made since is invalid afterwards.** With `from = 0` everything but `roots` goes. Symbols stay.
    ///
    /// ```
    /// use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let mut wanted = [p.parse("sin(x*y)").unwrap()];
    /// let before = p.len();
    /// let (x, scratch) = (p.symbol("x"), p.parse("exp(x)*(y + z)^7").unwrap());
    /// let slope = p.diff(scratch, x);
    /// p.collect(0, &mut wanted);
    /// assert_eq!((p.len(), p.text(wanted[0])), (before, "sin(x*y)".to_owned()));
    /// # let _ = slope;
    /// ```
    pub fn collect(&mut self, from: usize, roots: &mut [Expr]) {
        if self.len() <= from {
            return;
        }
        let mut keep = vec![false; self.len() - from];
        for e in self.reachable(roots) {
            if let Some(i) = e.index().checked_sub(from) {
                keep[i] = true;
            }
        }
        if keep.iter().all(|k| *k) {
            return;
        }
        // What the memory of older nodes points to must be older, too.
        self.derivatives.retain(|(e, _), d| e.index() < from && d.index() < from);
        self.derivatives.shrink_to_fit();
        self.primitives.retain(|e, (_, p)| e.index() < from && p.index() < from);
        self.primitives.shrink_to_fit();
        let new = self.retain(from, &keep);
        for e in roots {
            if let Some(i) = e.index().checked_sub(from) {
                *e = Expr(new[i]);
            }
        }
    }

    /// A pool of its own for these expressions, with the same [`Symbol`](crate::Symbol)s and nothing else, and the
    /// expressions in it: a place for work on them that leaves nothing behind here.
    ///
    /// ```
    /// use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let (e, x) = (p.parse("x*sin(y)").unwrap(), p.symbol("x"));
    /// let (mut scratch, roots) = p.extract(&[e]);
    /// let slope = scratch.diff(roots[0], x);
    /// assert_eq!(scratch.text(slope), "sin(y)");
    /// ```
    pub fn extract(&self, roots: &[Expr]) -> (Pool, Vec<Expr>) {
        let nodes = self.reachable(roots);
        let mut pool = Pool::new();
        pool.set_limit(self.limit().clone());
        for name in self.names() {
            pool.symbol(name);
        }
        let mut made: Vec<Expr> = Vec::with_capacity(nodes.len());
        // Ascending ids: operands stand before their users, and equal order of ids keeps the order of operands.
        let at = |e: Expr| nodes.binary_search(&e).unwrap_or_default();
        for &n in &nodes {
            let e = if let Some(value) = self.number(n) {
                pool.rational(value.clone())
            } else {
                let node = self.node(n).with_operands(|o| made[at(o)]);
                pool.intern(node)
            };
            if let Some(how) = self.directed(n) {
                pool.set_directed(e, how);
            }
            made.push(e);
        }
        let roots = roots.iter().map(|&r| made[at(r)]).collect();
        (pool, roots)
    }
}
