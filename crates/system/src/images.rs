//! The question which values an expression takes on a box of inputs.

use bracketry_symbolic::{Expr, Function, Node, Pool, Symbol, Tape};
use rustc_hash::FxHashMap;

use crate::interval::{End, Interval};
use crate::system::System;
use crate::unknown_range::UnknownRange;

/// The interval of every input.
pub(crate) type Domain = FxHashMap<Symbol, Interval>;

/// The intervals that the model gives its inputs; all real numbers for those without.
pub(crate) fn input_domain(system: &mut System) -> Domain {
    let ranges = system.input_ranges.clone();
    let pool = &mut system.pool;
    let mut interval = |u: &Symbol| {
        let mut on = Interval::all();
        if let Some(range) = ranges.iter().find(|r| r.input == *u) {
            for (end, limit) in [(&mut on.lower, &range.min), (&mut on.upper, &range.max)] {
                if let Some(limit) = limit {
                    *end = End::rational(pool, limit, true);
                }
            }
        }
        on
    };
    system.inputs.iter().map(|u| (*u, interval(u))).collect()
}

/// Images formed in one question.
const MAX_EFFORT: usize = 2000;

/// Images of expressions on a box of inputs.
pub(crate) struct Images<'p> {
    pub(crate) pool: &'p mut Pool,
    /// The interval of every input.
    pub(crate) domain: Domain,
    /// Images that may still be formed.
    pub(crate) effort: usize,
}

impl<'p> Images<'p> {
    pub(crate) fn new(pool: &'p mut Pool, domain: Domain) -> Self {
        Images { pool, domain, effort: MAX_EFFORT }
    }

    /// The inputs that an expression uses.
    pub(crate) fn inputs_of(&self, e: Expr) -> Vec<Symbol> {
        self.pool.symbols_of(&[e]).into_iter().filter(|s| self.domain.contains_key(s)).collect()
    }

    /// The value of an expression without names.
    pub(crate) fn constant(&mut self, e: Expr) -> Result<Interval, UnknownRange> {
        if let Some(s) = self.pool.symbols_of(&[e]).first() {
            return Err(UnknownRange::Free(self.pool.name(*s).to_owned()));
        }
        match number(self.pool, e) {
            Some(v) => Ok(Interval::point(v, e)),
            None => Err(UnknownRange::NoValue(Function::new(self.pool, e))),
        }
    }
}

/// The terms of a sum, or the factors of a product.
pub(crate) fn flattened(pool: &Pool, e: Expr, sum: bool) -> Vec<Expr> {
    let mut out = Vec::new();
    let mut stack = vec![e];
    while let Some(e) = stack.pop() {
        match pool.node(e) {
            Node::Add(a, b) if sum => stack.extend([b, a]),
            Node::Mul(a, b) if !sum => stack.extend([b, a]),
            _ => out.push(e),
        }
    }
    out
}

/// The numerical value of an expression without names.
pub(crate) fn number(pool: &Pool, e: Expr) -> Option<f64> {
    let tape = Tape::compile(pool, &[], &[e]).ok()?;
    let mut out = [f64::NAN];
    tape.eval(&[], &mut Vec::new(), &mut out);
    out[0].is_finite().then_some(out[0])
}
