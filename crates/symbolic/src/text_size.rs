//! How long the text of an expression is, from its structure alone.

use dashu_ratio::RBig;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::node::{Expr, Node};
use crate::pool::Pool;
use crate::text::{Exponent, Strength, factors, fraction, number_text, sum_terms, terms};

/// What [`Pool::text`] would write, were there no limit on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextSize {
    /// Number of bytes.
    pub length: u64,
    /// Number of quotients, those of numbers included.
    pub quotients: u64,
    /// Whether a minus stands in front.
    pub negative: bool,
}

/// A size with the binding strength of the text.
type Part = (TextSize, Strength);

fn plain(length: usize) -> TextSize {
    TextSize { length: length as u64, quotients: 0, negative: false }
}

impl TextSize {
    /// Both in a line.
    fn then(self, other: TextSize) -> TextSize {
        TextSize {
            length: self.length.saturating_add(other.length),
            quotients: self.quotients.saturating_add(other.quotients),
            negative: self.negative,
        }
    }

    fn wrapped(self, strength: Strength, at_least: Strength) -> TextSize {
        if strength < at_least { plain(1).then(self).then(plain(1)) } else { self }
    }

    /// The same without the minus in front, if there is one.
    fn size(self) -> TextSize {
        TextSize { length: self.length - u64::from(self.negative), negative: false, ..self }
    }
}

fn number(x: &RBig) -> Part {
    let (text, atomic) = number_text(x);
    let negative = *x < RBig::ZERO;
    let strength = match (negative, atomic) {
        (true, _) => Strength::Sum,
        (_, true) => Strength::Atom,
        (_, false) => Strength::Product,
    };
    (TextSize { length: text.len() as u64, quotients: u64::from(!atomic), negative }, strength)
}

/// Parts with a separator of this length between them.
fn joined(parts: &[TextSize], between: usize) -> TextSize {
    let rest = parts.iter().skip(1).fold(plain(0), |sum, &p| sum.then(plain(between)).then(p));
    parts.first().map_or(rest, |first| first.then(rest))
}

/// Sizes of the parts of one expression.
struct Sizes<'p> {
    pool: &'p Pool,
    known: FxHashMap<Expr, Part>,
}

impl Sizes<'_> {
    fn of(&self, e: Expr) -> Part {
        match self.pool.node(e) {
            Node::Num(_) => number(self.pool.number(e).unwrap_or(&RBig::ZERO)),
            Node::Pi => (plain(2), Strength::Atom),
            Node::Sym(s) => (plain(self.pool.name(s).len()), Strength::Atom),
            Node::Call(f, a) => (plain(f.name().len() + 2).then(self.known[&a].0), Strength::Atom),
            Node::Call2(f, a, b) => {
                (plain(f.name().len() + 4).then(self.known[&a].0).then(self.known[&b].0), Strength::Atom)
            }
            Node::Add(..) => {
                let terms: Vec<TextSize> = sum_terms(self.pool, e).iter().map(|t| self.known[t].0).collect();
                let signs = terms.iter().enumerate().map(|(i, t)| if i == 0 { *t } else { t.size() });
                (joined(&signs.collect::<Vec<_>>(), 3), Strength::Sum)
            }
            Node::Mul(..) | Node::Pow(..) => self.of_fraction(e),
        }
    }

    fn of_power(&self, base: Expr, k: &Exponent) -> Part {
        let (size, strength) = self.known[&base];
        let half = RBig::from(1) / RBig::from(2);
        let wrapped = size.wrapped(strength, Strength::Atom);
        match k {
            Exponent::Number(k) if *k == RBig::ONE => (size, strength),
            Exponent::Number(k) if *k == half => (plain(6).then(size), Strength::Atom),
            Exponent::Number(k) => {
                let (exponent, strength) = number(k);
                (wrapped.then(plain(1)).then(exponent.wrapped(strength, Strength::Power)), Strength::Power)
            }
            Exponent::Symbolic(k) => {
                let (exponent, strength) = self.known[k];
                (wrapped.then(plain(1)).then(exponent.wrapped(strength, Strength::Atom)), Strength::Power)
            }
        }
    }

    fn of_fraction(&self, e: Expr) -> Part {
        let f = fraction(self.pool, e);
        if f.bottom.is_empty()
            && f.coefficient == RBig::ONE
            && !f.negative
            && let [(base, k)] = f.top.as_slice()
        {
            return self.of_power(*base, k);
        }
        let side = |list: &[(Expr, Exponent)]| -> Vec<TextSize> {
            let powers = list.iter().map(|(base, k)| self.of_power(*base, k));
            powers.map(|(size, strength)| size.wrapped(strength, Strength::Power)).collect()
        };
        let (mut top, mut bottom) = (side(&f.top), side(&f.bottom));
        if f.coefficient != RBig::ONE {
            let (size, strength) = number(&f.coefficient);
            if strength == Strength::Atom {
                top.push(size);
            } else {
                let (above, below) = (f.coefficient.numerator(), f.coefficient.denominator());
                if *above != dashu_int::IBig::ONE || top.is_empty() {
                    top.push(plain(above.to_string().len()));
                }
                bottom.push(plain(below.to_string().len()));
            }
        }
        let mut size = if top.is_empty() { plain(1) } else { joined(&top, 1) };
        if !bottom.is_empty() {
            size = size.then(plain(if bottom.len() > 1 { 3 } else { 1 })).then(joined(&bottom, 1));
            size.quotients += 1;
        }
        if f.negative {
            return (TextSize { negative: true, ..plain(1).then(size) }, Strength::Sum);
        }
        (size, Strength::Product)
    }
}

impl Pool {
    /// The size of the text of an expression, found in a time linear in its nodes, however often they are shared.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("-x/(a*b) + 3*y").unwrap();
    /// let size = p.text_size(e);
    /// assert_eq!((size.length as usize, size.quotients), (p.text(e).len(), 1));
    /// ```
    pub fn text_size(&self, e: Expr) -> TextSize {
        // Sums of sums and products of products are written flat: their inner nodes have no size of their own.
        let nodes = self.reachable(&[e]);
        let mut needed = FxHashSet::from_iter([e]);
        for &n in nodes.iter().rev() {
            if needed.contains(&n) {
                match self.node(n) {
                    Node::Add(..) => needed.extend(terms(self, n)),
                    Node::Mul(..) => needed.extend(factors(self, n)),
                    node => needed.extend(node.operands()),
                }
            }
        }
        let mut sizes = Sizes { pool: self, known: FxHashMap::default() };
        for n in nodes.into_iter().filter(|n| needed.contains(n)) {
            let part = sizes.of(n);
            sizes.known.insert(n, part);
        }
        sizes.known[&e].0
    }
}
