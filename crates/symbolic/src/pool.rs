//! The arena: hash-consed binary nodes with light local rules.

use std::hash::BuildHasher;

use dashu_ratio::RBig;
use hashbrown::HashTable;
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};

use crate::func::{Func, Func2};

/// An expression: an index into the [`Pool`] that made it.
///
/// Structurally equal expressions of one pool have equal ids. The id of an
/// operand is smaller than that of the node which uses it, so ascending ids
/// are a topological order.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Expr(pub(crate) u32);

impl Expr {
    /// Position in the arena; below [`Pool::len`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A named indeterminate of a [`Pool`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Symbol(pub(crate) u32);

/// What an [`Expr`] stands for.
///
/// Subtraction is `a + (-1)·b`, division `a · b^(-1)`, a square root `a^(1/2)`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    /// An exact rational; see [`Pool::number`].
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
}

/// Numeric powers are folded up to this exponent; beyond it they stay symbolic.
const MAX_FOLDED_EXPONENT: i64 = 256;

/// Owner of expressions. Dropping it frees them all; nothing is global.
#[derive(Clone, Default)]
pub struct Pool {
    nodes: Vec<Node>,
    table: HashTable<u32>,
    numbers: Vec<RBig>,
    number_ids: FxHashMap<RBig, u32>,
    names: Vec<String>,
    name_ids: FxHashMap<String, u32>,
    pub(crate) derivatives: FxHashMap<(Expr, Symbol), Expr>,
    /// Content and primitive part of canonical sums.
    pub(crate) primitives: FxHashMap<Expr, (RBig, Expr)>,
}

fn hash_node(node: &Node) -> u64 {
    FxBuildHasher.hash_one(node)
}

impl Pool {
    /// An empty pool.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of distinct nodes made so far.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// True as long as nothing was made.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// What `e` stands for.
    pub fn node(&self, e: Expr) -> Node {
        self.nodes[e.index()]
    }

    pub(crate) fn intern(&mut self, node: Node) -> Expr {
        let nodes = &self.nodes;
        let hash = hash_node(&node);
        if let Some(&id) = self.table.find(hash, |&i| nodes[i as usize] == node) {
            return Expr(id);
        }
        let id = u32::try_from(self.nodes.len()).expect("an arena of fewer than 2^32 nodes");
        self.nodes.push(node);
        let nodes = &self.nodes;
        self.table.insert_unique(hash, id, |&i| hash_node(&nodes[i as usize]));
        Expr(id)
    }

    /// The expression that is this node, if it was made.
    pub(crate) fn find(&self, node: Node) -> Option<Expr> {
        self.table.find(hash_node(&node), |&i| self.nodes[i as usize] == node).map(|&id| Expr(id))
    }

    /// The indeterminate called `name`, made on first use.
    pub fn symbol(&mut self, name: &str) -> Symbol {
        if let Some(&i) = self.name_ids.get(name) {
            return Symbol(i);
        }
        let i = self.names.len() as u32;
        self.names.push(name.to_owned());
        self.name_ids.insert(name.to_owned(), i);
        Symbol(i)
    }

    /// The indeterminate called `name`, if it was made.
    pub fn find_symbol(&self, name: &str) -> Option<Symbol> {
        self.name_ids.get(name).map(|&i| Symbol(i))
    }

    /// Name of an indeterminate.
    pub fn name(&self, s: Symbol) -> &str {
        &self.names[s.0 as usize]
    }

    /// The expression that is the indeterminate `s`.
    pub fn sym(&mut self, s: Symbol) -> Expr {
        self.intern(Node::Sym(s))
    }

    /// The indeterminate called `name` as an expression.
    pub fn var(&mut self, name: &str) -> Expr {
        let s = self.symbol(name);
        self.sym(s)
    }

    /// π.
    pub fn pi(&mut self) -> Expr {
        self.intern(Node::Pi)
    }

    /// An exact rational constant.
    pub fn rational(&mut self, value: RBig) -> Expr {
        let id = if let Some(&i) = self.number_ids.get(&value) {
            i
        } else {
            let i = self.numbers.len() as u32;
            self.numbers.push(value.clone());
            self.number_ids.insert(value, i);
            i
        };
        self.intern(Node::Num(id))
    }

    /// An integer constant.
    pub fn int(&mut self, value: i64) -> Expr {
        self.rational(RBig::from(value))
    }

    /// The fraction `p/q`; `q` must not be zero.
    pub fn ratio(&mut self, p: i64, q: i64) -> Expr {
        assert!(q != 0, "a fraction needs a denominator other than zero");
        self.rational(RBig::from(p) / RBig::from(q))
    }

    /// The value of `e` if it is a rational constant.
    pub fn number(&self, e: Expr) -> Option<&RBig> {
        match self.node(e) {
            Node::Num(i) => Some(&self.numbers[i as usize]),
            _ => None,
        }
    }

    /// The value of `e` if it is an integer constant that fits.
    pub fn integer(&self, e: Expr) -> Option<i64> {
        let r = self.number(e)?;
        if r.is_int() { i64::try_from(r.numerator()).ok() } else { None }
    }

    /// True if `e` is the number 0. A structural test; see the exact zero test for the mathematical one.
    pub fn is_zero(&self, e: Expr) -> bool {
        self.integer(e) == Some(0)
    }

    /// True if `e` is the number 1.
    pub fn is_one(&self, e: Expr) -> bool {
        self.integer(e) == Some(1)
    }

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

    /// `a + b`
    pub fn add(&mut self, a: Expr, b: Expr) -> Expr {
        let (a, b) = self.ordered(a, b);
        if let Some(x) = self.number(a).cloned() {
            if x == RBig::ZERO {
                return b;
            }
            if let Some(y) = self.number(b) {
                let sum = x + y;
                return self.rational(sum);
            }
            // x + (y + rest) = (x + y) + rest
            if let Node::Add(p, q) = self.node(b)
                && let Some(y) = self.number(p)
            {
                let sum = x + y;
                let s = self.rational(sum);
                return self.add(s, q);
            }
            return self.intern(Node::Add(a, b));
        }
        let (ca, ra) = self.coefficient(a);
        let (cb, rb) = self.coefficient(b);
        if ra == rb {
            let c = self.rational(ca + cb);
            return self.mul(c, ra);
        }
        // Keep a number in front of the whole sum.
        if let Node::Add(p, q) = self.node(b)
            && self.number(p).is_some()
        {
            let s = self.add(a, q);
            return self.add(p, s);
        }
        if let Node::Add(p, q) = self.node(a)
            && self.number(p).is_some()
        {
            let s = self.add(q, b);
            return self.add(p, s);
        }
        self.intern(Node::Add(a, b))
    }

    /// `a - b`
    pub fn sub(&mut self, a: Expr, b: Expr) -> Expr {
        let n = self.neg(b);
        self.add(a, n)
    }

    /// `-a`
    pub fn neg(&mut self, a: Expr) -> Expr {
        let m = self.int(-1);
        self.mul(m, a)
    }

    /// `a · b`
    pub fn mul(&mut self, a: Expr, b: Expr) -> Expr {
        let (a, b) = self.ordered(a, b);
        if let Some(x) = self.number(a).cloned() {
            if x == RBig::ZERO {
                return a;
            }
            if x == RBig::ONE {
                return b;
            }
            if let Some(y) = self.number(b) {
                let product = x * y;
                return self.rational(product);
            }
            if let Node::Mul(p, q) = self.node(b)
                && let Some(y) = self.number(p)
            {
                let product = x * y;
                let c = self.rational(product);
                return self.mul(c, q);
            }
            return self.intern(Node::Mul(a, b));
        }
        let (pa, ea) = self.numeric_power(a);
        let (pb, eb) = self.numeric_power(b);
        if pa == pb {
            let e = self.rational(ea + eb);
            return self.pow(pa, e);
        }
        if let Node::Mul(p, q) = self.node(a)
            && self.number(p).is_some()
        {
            let s = self.mul(q, b);
            return self.mul(p, s);
        }
        if let Node::Mul(p, q) = self.node(b)
            && self.number(p).is_some()
        {
            let s = self.mul(a, q);
            return self.mul(p, s);
        }
        self.intern(Node::Mul(a, b))
    }

    /// Splits `base^k` with a rational `k` into base and exponent (`k = 1` for anything else).
    fn numeric_power(&self, e: Expr) -> (Expr, RBig) {
        if let Node::Pow(b, k) = self.node(e)
            && let Some(k) = self.number(k)
        {
            return (b, k.clone());
        }
        (e, RBig::ONE)
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
        let (c, _) = self.coefficient(a);
        if c < RBig::ZERO {
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
        match (self.number(a).is_some(), self.number(b).is_some()) {
            (true, false) => (a, b),
            (false, true) => (b, a),
            _ if a <= b => (a, b),
            _ => (b, a),
        }
    }

    /// Every node that `roots` use, ascending (operands before users), each once.
    pub fn reachable(&self, roots: &[Expr]) -> Vec<Expr> {
        let mut seen: FxHashSet<Expr> = FxHashSet::default();
        let mut stack = roots.to_vec();
        while let Some(e) = stack.pop() {
            if seen.insert(e) {
                stack.extend(self.node(e).operands());
            }
        }
        let mut all: Vec<Expr> = seen.into_iter().collect();
        all.sort_unstable();
        all
    }

    /// The indeterminates that `roots` use, in order of creation.
    pub fn symbols_of(&self, roots: &[Expr]) -> Vec<Symbol> {
        let mut s: Vec<Symbol> = self
            .reachable(roots)
            .into_iter()
            .filter_map(|e| match self.node(e) {
                Node::Sym(s) => Some(s),
                _ => None,
            })
            .collect();
        s.sort_unstable();
        s
    }

    /// True if `e` uses the indeterminate `s` anywhere (structurally).
    pub fn depends_on(&self, e: Expr, s: Symbol) -> bool {
        self.symbols_of(&[e]).contains(&s)
    }
}
