//! What a pool holds: expressions, their nodes, and indeterminates.

use crate::func::{Func, Func2};

/// An expression: an index into the [`Pool`](crate::Pool) that made it.
///
/// Structurally equal expressions of one pool have equal ids. The id of an
/// operand is smaller than that of the node which uses it, so ascending ids
/// are a topological order.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Expr(pub(crate) u32);

impl Expr {
    /// Position in the arena; below [`Pool::len`](crate::Pool::len).
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A named indeterminate of a [`Pool`](crate::Pool).
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Symbol(pub(crate) u32);

/// What an [`Expr`] stands for.
///
/// Subtraction is `a + (-1)·b`, division `a · b^(-1)`, a square root `a^(1/2)`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    /// An exact rational; see [`Pool::number`](crate::Pool::number).
    Num(u32),
    /// π.
    Pi,
    /// An indeterminate.
    Sym(Symbol),
    /// Sum; a number stands first.
    Add(Expr, Expr),
    /// Product; a number stands first.
    Mul(Expr, Expr),
    /// Power `base ^ exponent`.
    Pow(Expr, Expr),
    /// Function of one argument.
    Call(Func, Expr),
    /// Function of two arguments.
    Call2(Func2, Expr, Expr),
}

impl Node {
    /// Operands, in order.
    pub fn operands(self) -> impl Iterator<Item = Expr> {
        let (a, b) = match self {
            Node::Num(_) | Node::Pi | Node::Sym(_) => (None, None),
            Node::Add(a, b) | Node::Mul(a, b) | Node::Pow(a, b) | Node::Call2(_, a, b) => (Some(a), Some(b)),
            Node::Call(_, a) => (Some(a), None),
        };
        a.into_iter().chain(b)
    }

    /// The same node of other operands.
    pub(crate) fn with_operands(self, mut new: impl FnMut(Expr) -> Expr) -> Node {
        match self {
            Node::Num(_) | Node::Pi | Node::Sym(_) => self,
            Node::Add(a, b) => Node::Add(new(a), new(b)),
            Node::Mul(a, b) => Node::Mul(new(a), new(b)),
            Node::Pow(a, b) => Node::Pow(new(a), new(b)),
            Node::Call(f, a) => Node::Call(f, new(a)),
            Node::Call2(f, a, b) => Node::Call2(f, new(a), new(b)),
        }
    }
}

/// How it is known that the unit vector σ/|σ| of a square |σ|² is set-valued where σ = 0.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Directed {
    /// It was written so, as `unit(…)`.
    Written,
    /// It was found in equations.
    Found,
}
