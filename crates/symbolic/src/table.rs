//! Expressions as a table that can be stored and sent: each entry refers to earlier ones, so sharing is kept.

use dashu_ratio::RBig;
use serde::{Deserialize, Serialize};

use crate::func::{Func, Func2};
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// Longest numerator or denominator that is read, in digits.
const MAX_DIGITS: usize = 10_000;

/// One entry of an [`ExprTable`]; the numbers are those of earlier entries, from 0.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Entry {
    /// A rational number: `"-3/4"`.
    Number(String),
    /// π.
    Pi,
    /// A name.
    Symbol(String),
    /// Sum.
    Add(u32, u32),
    /// Product.
    Mul(u32, u32),
    /// Power: base, exponent.
    Pow(u32, u32),
    /// A function by its name, and its arguments.
    Call(String, Vec<u32>),
}

/// Expressions in a form that outlives their [`Pool`]; made by [`Pool::export`], read by [`Pool::import`].
///
/// ```
/// # use bracketry_symbolic::{ExprTable, Pool};
/// let mut p = Pool::new();
/// let e = p.parse("x*sin(y) - 2/3").unwrap();
/// let json = serde_json::to_string(&p.export(&[e])).unwrap();
/// let table: ExprTable = serde_json::from_str(&json).unwrap();
/// let mut q = Pool::new();
/// let f = q.import(&table).unwrap()[0];
/// assert_eq!(p.text(e), q.text(f));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExprTable {
    /// Operands stand before what uses them.
    pub entries: Vec<Entry>,
    /// The entries that are the expressions.
    pub roots: Vec<u32>,
}

/// A table that is not one of expressions.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// An entry uses one that does not stand before it.
    #[error("entry {entry} uses entry {operand}, which does not precede it")]
    Order {
        /// The entry.
        entry: usize,
        /// What it refers to.
        operand: u32,
    },
    /// A root that is not in the table.
    #[error("root {root} is not in the table of {entries} entries")]
    Root {
        /// The root.
        root: u32,
        /// Length of the table.
        entries: usize,
    },
    /// A text that is no rational number.
    #[error("entry {entry}: `{text}` is not a rational number of at most {MAX_DIGITS} digits, such as -3/4")]
    Number {
        /// The entry.
        entry: usize,
        /// The text, shortened.
        text: String,
    },
    /// An empty name.
    #[error("entry {entry}: a name is empty")]
    Name {
        /// The entry.
        entry: usize,
    },
    /// An unknown function, or one with the wrong number of arguments.
    #[error("entry {entry}: there is no function `{name}` of {arguments} arguments")]
    Function {
        /// The entry.
        entry: usize,
        /// Its name.
        name: String,
        /// Number of arguments given.
        arguments: usize,
    },
}

impl Pool {
    /// The given expressions and all that they use, once each.
    pub fn export(&self, roots: &[Expr]) -> ExprTable {
        let nodes = self.reachable(roots);
        // Ascending ids: operands stand before their users.
        let at = |e: Expr| nodes.binary_search(&e).map_or(u32::MAX, |i| i as u32);
        let entries = nodes
            .iter()
            .map(|&n| match self.node(n) {
                Node::Num(_) => Entry::Number(self.number(n).map(RBig::to_string).unwrap_or_default()),
                Node::Pi => Entry::Pi,
                Node::Sym(s) => Entry::Symbol(self.name(s).to_owned()),
                Node::Add(a, b) => Entry::Add(at(a), at(b)),
                Node::Mul(a, b) => Entry::Mul(at(a), at(b)),
                Node::Pow(a, b) => Entry::Pow(at(a), at(b)),
                Node::Call(f, a) => Entry::Call(f.name().to_owned(), vec![at(a)]),
                Node::Call2(f, a, b) => Entry::Call(f.name().to_owned(), vec![at(a), at(b)]),
            })
            .collect();
        ExprTable { entries, roots: roots.iter().map(|&r| at(r)).collect() }
    }

    /// The expressions of a table, made in this pool. What the pool holds already is found again: importing what the
    /// same pool has exported gives the same [`Expr`]s.
    ///
    /// # Errors
    /// [`TableError`] names the entry that is at fault.
    pub fn import(&mut self, table: &ExprTable) -> Result<Vec<Expr>, TableError> {
        let mut made: Vec<Expr> = Vec::with_capacity(table.entries.len());
        for (entry, content) in table.entries.iter().enumerate() {
            let get = |operand: u32| made.get(operand as usize).copied().ok_or(TableError::Order { entry, operand });
            let e = match content {
                Entry::Number(text) => {
                    let value = rational(text)
                        .ok_or_else(|| TableError::Number { entry, text: text.chars().take(40).collect() })?;
                    self.rational(value)
                }
                Entry::Pi => self.pi(),
                Entry::Symbol(name) if name.is_empty() => return Err(TableError::Name { entry }),
                Entry::Symbol(name) => self.var(name),
                Entry::Add(a, b) => self.restored(Node::Add(get(*a)?, get(*b)?)),
                Entry::Mul(a, b) => self.restored(Node::Mul(get(*a)?, get(*b)?)),
                Entry::Pow(a, b) => self.restored(Node::Pow(get(*a)?, get(*b)?)),
                Entry::Call(name, arguments) => {
                    let unary = Func::ALL.iter().find(|(_, n)| n == name).map(|(f, _)| *f);
                    let binary = Func2::ALL.iter().find(|(_, n)| n == name).map(|(f, _)| *f);
                    match (arguments.as_slice(), unary, binary) {
                        ([a], Some(f), _) => self.restored(Node::Call(f, get(*a)?)),
                        ([a, b], _, Some(f)) => self.restored(Node::Call2(f, get(*a)?, get(*b)?)),
                        _ => {
                            let (name, arguments) = (name.clone(), arguments.len());
                            return Err(TableError::Function { entry, name, arguments });
                        }
                    }
                }
            };
            made.push(e);
        }
        let root = |&r: &u32| made.get(r as usize).copied();
        table.roots.iter().map(|r| root(r).ok_or(TableError::Root { root: *r, entries: made.len() })).collect()
    }

    /// The node as it was, if the pool could hold it; simplified by the local rules if it could not.
    fn restored(&mut self, node: Node) -> Expr {
        if let Some(e) = self.find(node) {
            return e;
        }
        let made = self.make(node);
        // Canonical sums and products order their operands for reading, not by age.
        match (node, self.node(made)) {
            (Node::Add(a, b), Node::Add(x, y)) | (Node::Mul(a, b), Node::Mul(x, y)) if (a, b) == (y, x) => {
                self.intern(node)
            }
            _ => made,
        }
    }
}

fn rational(text: &str) -> Option<RBig> {
    let (p, q) = text.split_once('/').unwrap_or((text, "1"));
    let digits = |s: &str| !s.is_empty() && s.len() <= MAX_DIGITS && s.bytes().all(|c| c.is_ascii_digit());
    if !digits(p.strip_prefix('-').unwrap_or(p)) || !digits(q) {
        return None;
    }
    let q = q.parse::<dashu_int::UBig>().ok().filter(|q| *q != dashu_int::UBig::ZERO)?;
    Some(RBig::from_parts(p.parse().ok()?, q))
}
