//! The arena: hash-consed binary nodes with light local rules.

use std::hash::BuildHasher;
use std::time::Instant;

use dashu_ratio::RBig;
use hashbrown::HashTable;
use rustc_hash::{FxBuildHasher, FxHashMap};

use crate::node::{Directed, Expr, Node, Symbol};
use crate::stop_flag::{Limit, StopFlag};

/// The numbers 0, 1 and −1 come first in every pool.
pub(crate) const ZERO: u32 = 0;
pub(crate) const ONE: u32 = 1;
pub(crate) const MINUS_ONE: u32 = 2;
/// Stands in the list of small integers for a number that is none.
const NO_SMALL: i64 = i64::MIN;
/// Stands for a node that was not made yet.
const NO_NODE: Expr = Expr(u32::MAX);

/// Owner of expressions. Dropping it frees them all; nothing is global.
///
/// [`Pool::collect`] frees what is no longer needed before that.
#[derive(Clone)]
pub struct Pool {
    pub(crate) nodes: Vec<Node>,
    /// By node: which indeterminates it may use, those with numbers that agree modulo 64 in one bit.
    masks: Vec<u64>,
    table: HashTable<u32>,
    pub(crate) numbers: Vec<RBig>,
    /// The numbers that are integers and fit.
    small: Vec<i64>,
    number_ids: FxHashMap<RBig, u32>,
    small_ids: FxHashMap<i64, u32>,
    /// The nodes of 0, 1 and −1.
    units: [Expr; 3],
    /// Nodes that were freed again.
    freed: usize,
    names: Vec<String>,
    name_ids: FxHashMap<String, u32>,
    pub(crate) derivatives: FxHashMap<(Expr, Symbol), Expr>,
    /// Content and primitive part of canonical sums.
    pub(crate) primitives: FxHashMap<Expr, (RBig, Expr)>,
    /// Squares |σ|² whose unit vectors σ/|σ| are set-valued, with how that is known.
    pub(crate) directed: FxHashMap<Expr, Directed>,
    limit: Limit,
}

fn symbol_bit(s: Symbol) -> u64 {
    1 << (s.0 % 64)
}

fn hash_node(node: &Node) -> u64 {
    FxBuildHasher.hash_one(node)
}

impl Default for Pool {
    fn default() -> Self {
        let mut pool = Pool {
            nodes: Vec::new(),
            masks: Vec::new(),
            table: HashTable::new(),
            numbers: Vec::new(),
            small: Vec::new(),
            number_ids: FxHashMap::default(),
            small_ids: FxHashMap::default(),
            units: [NO_NODE; 3],
            freed: 0,
            names: Vec::new(),
            name_ids: FxHashMap::default(),
            derivatives: FxHashMap::default(),
            primitives: FxHashMap::default(),
            directed: FxHashMap::default(),
            limit: Limit::default(),
        };
        for unit in [0, 1, -1] {
            pool.small_number(unit);
        }
        pool
    }
}

impl Pool {
    /// Says that the unit vector σ/|σ| of `square` = |σ|² is set-valued where σ = 0. Substitution and
    /// [`Pool::extract`] keep this of a square that they change.
    pub fn set_directed(&mut self, square: Expr, how: Directed) {
        let known = self.directed.entry(square).or_insert(how);
        if how == Directed::Written {
            *known = how;
        }
    }

    /// Whether, and how, it is known that the unit vector of `square` is set-valued: [`Pool::set_directed`].
    pub fn directed(&self, square: Expr) -> Option<Directed> {
        self.directed.get(&square).copied()
    }

    /// Whether any unit vector is known to be set-valued.
    pub fn has_directed(&self) -> bool {
        !self.directed.is_empty()
    }

    /// An empty pool.
    pub fn new() -> Self {
        Self::default()
    }

    /// When work on expressions of this pool ends early: exact decisions are then [undecided](crate::Undecided), and expressions are
    /// left as they are instead of being simplified. Clones of the pool share the flag and have the same deadline.
    pub fn limit(&self) -> &Limit {
        &self.limit
    }

    /// Gives the pool another limit.
    pub fn set_limit(&mut self, limit: Limit) {
        self.limit = limit;
    }

    /// The flag of the [limit](Self::limit).
    pub fn stop_flag(&self) -> &StopFlag {
        &self.limit.stop
    }

    /// Gives the pool another flag.
    pub fn set_stop_flag(&mut self, flag: StopFlag) {
        self.limit.stop = flag;
    }

    /// The deadline of the [limit](Self::limit).
    pub fn deadline(&self) -> Option<Instant> {
        self.limit.deadline
    }

    /// Gives the pool another deadline.
    pub fn set_deadline(&mut self, deadline: Option<Instant>) {
        self.limit.deadline = deadline;
    }

    /// Number of distinct nodes made so far.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Number of nodes made so far, with those that [`Pool::collect`] freed: a measure of the work done.
    pub fn made(&self) -> usize {
        self.nodes.len() + self.freed
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
        let mask = match node {
            Node::Sym(s) => symbol_bit(s),
            _ => node.operands().fold(0, |m, o| m | self.masks[o.index()]),
        };
        self.masks.push(mask);
        let nodes = &self.nodes;
        self.table.insert_unique(hash, id, |&i| hash_node(&nodes[i as usize]));
        Expr(id)
    }

    /// Keeps of the nodes from `from` on only those marked in `keep`, which must hold the operands of what it
    /// holds; `new[i]` becomes the new number of the node `from + i`.
    pub(crate) fn retain(&mut self, from: usize, keep: &[bool]) -> Vec<u32> {
        let mut new = vec![u32::MAX; keep.len()];
        let moved = |e: Expr, new: &[u32]| e.index().checked_sub(from).map_or(e, |i| Expr(new[i]));
        let mut next = from;
        for (i, _) in keep.iter().enumerate().filter(|(_, kept)| **kept) {
            self.nodes[next] = self.nodes[from + i].with_operands(|o| moved(o, &new));
            self.masks[next] = self.masks[from + i];
            new[i] = next as u32;
            next += 1;
        }
        self.freed += self.nodes.len() - next;
        self.nodes.truncate(next);
        self.masks.truncate(next);
        self.nodes.shrink_to_fit();
        self.masks.shrink_to_fit();
        // Those that were freed have no place any more.
        let directed = std::mem::take(&mut self.directed);
        let stays = |e: &Expr| e.index().checked_sub(from).is_none_or(|i| keep[i]);
        self.directed = directed.into_iter().filter(|(e, _)| stays(e)).map(|(e, d)| (moved(e, &new), d)).collect();
        self.renumber();
        self.units = [NO_NODE; 3];
        self.table = HashTable::with_capacity(next);
        for i in 0..next as u32 {
            let nodes = &self.nodes;
            self.table.insert_unique(hash_node(&nodes[i as usize]), i, |&i| hash_node(&nodes[i as usize]));
        }
        new
    }

    /// Forgets the numbers that no node uses.
    fn renumber(&mut self) {
        let old = std::mem::take(&mut self.numbers);
        self.small.clear();
        self.number_ids = FxHashMap::default();
        self.small_ids = FxHashMap::default();
        for unit in [0, 1, -1] {
            self.small_number(unit);
        }
        for i in 0..self.nodes.len() {
            if let Node::Num(id) = self.nodes[i] {
                self.nodes[i] = Node::Num(self.number_id(old[id as usize].clone()));
            }
        }
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

    /// The names of all indeterminates, in the order in which they were made.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
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
        let id = self.number_id(value);
        self.numbered(id)
    }

    /// The node of a number.
    pub(crate) fn numbered(&mut self, id: u32) -> Expr {
        let Some(&known) = self.units.get(id as usize) else { return self.intern(Node::Num(id)) };
        if known != NO_NODE {
            return known;
        }
        let e = self.intern(Node::Num(id));
        self.units[id as usize] = e;
        e
    }

    fn number_id(&mut self, value: RBig) -> u32 {
        if value.is_int()
            && let Ok(small) = i64::try_from(value.numerator())
            && small != NO_SMALL
        {
            return self.small_number(small);
        }
        if let Some(&i) = self.number_ids.get(&value) {
            return i;
        }
        let i = self.numbers.len() as u32;
        self.numbers.push(value.clone());
        self.small.push(NO_SMALL);
        self.number_ids.insert(value, i);
        i
    }

    fn small_number(&mut self, value: i64) -> u32 {
        if let Some(&i) = self.small_ids.get(&value) {
            return i;
        }
        let i = self.numbers.len() as u32;
        self.numbers.push(RBig::from(value));
        self.small.push(value);
        self.small_ids.insert(value, i);
        i
    }

    /// The sum of two numbers.
    pub(crate) fn sum_of_numbers(&mut self, a: u32, b: u32) -> Expr {
        let id = match (self.small_value(a), self.small_value(b)) {
            (Some(x), Some(y)) if x.checked_add(y).is_some_and(|s| s != NO_SMALL) => self.small_number(x + y),
            _ => self.number_id(&self.numbers[a as usize] + &self.numbers[b as usize]),
        };
        self.numbered(id)
    }

    /// The product of two numbers.
    pub(crate) fn product_of_numbers(&mut self, a: u32, b: u32) -> Expr {
        let id = match (self.small_value(a), self.small_value(b)) {
            (Some(x), Some(y)) if x.checked_mul(y).is_some_and(|p| p != NO_SMALL) => self.small_number(x * y),
            _ => self.number_id(&self.numbers[a as usize] * &self.numbers[b as usize]),
        };
        self.numbered(id)
    }

    fn small_value(&self, id: u32) -> Option<i64> {
        let value = self.small[id as usize];
        (value != NO_SMALL).then_some(value)
    }

    /// An integer constant.
    pub fn int(&mut self, value: i64) -> Expr {
        if value == NO_SMALL {
            return self.rational(RBig::from(value));
        }
        let id = self.small_number(value);
        self.numbered(id)
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
        match self.node(e) {
            // The one that has no place among the small ones.
            Node::Num(i) if self.small[i as usize] == NO_SMALL => i64::try_from(self.numbers[i as usize].clone()).ok(),
            Node::Num(i) => Some(self.small[i as usize]),
            _ => None,
        }
    }

    /// True if `e` is the number 0. A structural test; see the exact zero test for the mathematical one.
    pub fn is_zero(&self, e: Expr) -> bool {
        self.node(e) == Node::Num(ZERO)
    }

    /// True if `e` is the number 1.
    pub fn is_one(&self, e: Expr) -> bool {
        self.node(e) == Node::Num(ONE)
    }

    /// Every node, ascending.
    pub(crate) fn all(&self) -> impl Iterator<Item = Expr> {
        (0..self.len()).map(|i| Expr(i as u32))
    }

    /// Every node that `roots` use, ascending (operands before users), each once.
    pub fn reachable(&self, roots: &[Expr]) -> Vec<Expr> {
        let Some(last) = roots.iter().max() else { return Vec::new() };
        let mut seen = vec![0u64; last.index() / 64 + 1];
        let mut stack = Vec::with_capacity(64);
        let mut count = 0;
        for &root in roots {
            stack.push(root);
            while let Some(e) = stack.pop() {
                let (word, bit) = (&mut seen[e.index() / 64], 1 << (e.index() % 64));
                if *word & bit == 0 {
                    *word |= bit;
                    count += 1;
                    stack.extend(self.node(e).operands());
                }
            }
        }
        let mut all = Vec::with_capacity(count);
        for (i, mut word) in seen.into_iter().enumerate() {
            while word != 0 {
                all.push(Expr((i * 64) as u32 + word.trailing_zeros()));
                word &= word - 1;
            }
        }
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
        self.may_depend_on(e, s) && self.symbols_of(&[e]).contains(&s)
    }

    /// False only if `e` does not use the indeterminate `s`.
    pub(crate) fn may_depend_on(&self, e: Expr, s: Symbol) -> bool {
        self.masks[e.index()] & symbol_bit(s) != 0
    }
}
