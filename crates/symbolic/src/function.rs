//! Expressions that outlive the computation that found them.

use std::fmt;
use std::sync::Arc;

use serde::{Serialize, Serializer};

use crate::node::Expr;
use crate::pool::Pool;

/// An expression with the pool that it belongs to. Its text, also that in JSON, names an expression of more than 4000
/// characters by its size.
#[derive(Clone)]
pub struct Function {
    pool: Arc<Pool>,
    expr: Expr,
}

/// Longer expressions are not written into a report.
const MAX_TEXT: u64 = 4000;

impl Function {
    /// A copy of `e`, which belongs to `pool`.
    pub fn new(pool: &Pool, e: Expr) -> Self {
        let mut own = Pool::new();
        let expr = own.adopt(pool, e);
        Function { pool: Arc::new(own), expr }
    }

    /// The same for each of a list.
    pub fn list(pool: &Pool, list: &[Expr]) -> Vec<Self> {
        list.iter().map(|&e| Function::new(pool, e)).collect()
    }

    /// The pool of [`Function::expr`].
    pub fn pool(&self) -> &Pool {
        &self.pool
    }

    /// The expression, in [`Function::pool`].
    pub fn expr(&self) -> Expr {
        self.expr
    }

    /// The same expression in another pool.
    pub fn copied_into(&self, pool: &mut Pool) -> Expr {
        pool.adopt(&self.pool, self.expr)
    }

    /// The text without a limit on its length.
    pub fn text(&self) -> String {
        self.pool.text(self.expr)
    }
}

impl Pool {
    /// An expression of another pool.
    fn adopt(&mut self, from: &Pool, e: Expr) -> Expr {
        let copied = self.import(&from.export(&[e])).ok().and_then(|roots| roots.first().copied());
        // A table that a pool has exported can be read.
        copied.unwrap_or_else(|| self.int(0))
    }
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.pool.text_size(self.expr).length <= MAX_TEXT {
            f.write_str(&self.text())
        } else {
            write!(f, "<{} nodes, not shown>", self.pool.reachable(&[self.expr]).len())
        }
    }
}

impl fmt::Debug for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Equal as expressions, node by node.
impl PartialEq for Function {
    fn eq(&self, other: &Self) -> bool {
        let mut pool = (*self.pool).clone();
        pool.import(&other.pool.export(&[other.expr])).is_ok_and(|roots| roots == [self.expr])
    }
}

impl Eq for Function {}

impl PartialEq<&str> for Function {
    fn eq(&self, text: &&str) -> bool {
        self.to_string() == **text
    }
}

impl Serialize for Function {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
