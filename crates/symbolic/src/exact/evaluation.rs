//! Values at one point, of expressions that are asked for one after the other.

use super::field::Residue;
use super::lower::is_generator;
use super::{Bindings, SEED, Samples, Undecided};
use crate::node::{Expr, Node};
use crate::pool::Pool;
use crate::table::ExprTable;

/// One point modulo the prime 2^61 − `C`: what its values of transcendental constants and of free symbols are, stays.
///
/// Values from two calls of [`Pool::sample`] must not be compared: in each, e^(1/3) or cos(1/2) are other residues.
///
/// ```
/// use bracketry_symbolic::{Bindings, Evaluation, Pool};
/// let mut p = Pool::new();
/// let [a, b] = ["cos(1/3) + x", "x"].map(|e| p.parse(e).unwrap());
/// let both = p.parse("cos(1/3)").unwrap();
/// let mut point = Evaluation::<1>::new(Bindings::new());
/// let a = p.evaluate(&mut point, &[a]).unwrap().values[0][0];
/// let b = p.evaluate(&mut point, &[b]).unwrap().values[0][0];
/// assert_eq!(p.evaluate(&mut point, &[both]).unwrap().values[0][0], a - b);
/// ```
#[derive(Clone, Debug)]
pub struct Evaluation<const C: u64 = 1> {
    bindings: Bindings,
    /// Symbols and functions met so far, in the order in which they became generators, and their values. A table, because a pool
    /// may renumber what no expression of its caller uses.
    met: ExprTable,
    values: Vec<Residue<C>>,
    /// What the generators are.
    point: Vec<Residue<C>>,
}

impl<const C: u64> Evaluation<C> {
    /// A point at which the symbols of `bindings` have their values.
    pub fn new(bindings: Bindings) -> Self {
        Self { bindings, met: ExprTable::default(), values: Vec::new(), point: Vec::new() }
    }
}

impl Pool {
    /// Values of `roots` at a point, as one sample.
    ///
    /// # Errors
    /// [`Undecided`] if an expression cannot be evaluated in this field, or not together with those before.
    pub fn evaluate<const C: u64>(&mut self, at: &mut Evaluation<C>, roots: &[Expr]) -> Result<Samples<C>, Undecided> {
        let mut met = self.import(&at.met).map_err(|_| Undecided::TooComplex)?;
        let known = met.len();
        let is_bound = |e: Expr| matches!(self.node(e), Node::Sym(s) if at.bindings.get(s).is_some());
        let is_new = |e: &Expr| is_generator(self, *e) && !is_bound(*e) && !met.contains(e);
        let new: Vec<Expr> = self.reachable(roots).into_iter().filter(is_new).collect();
        met.extend(new);
        // Generators that come later are drawn anew.
        let seed = SEED ^ (at.point.len() as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let (samples, mut generated) = self.sample_after::<C>(&met, roots, &at.bindings, (1, seed), &at.point)?;
        let Some((values, point)) = generated.pop() else { return Ok(samples) };
        if values[..known] != at.values {
            // A finer generator has taken the place of one before, such as e^(1/6) that of e^(1/3).
            return Err(Undecided::TooComplex);
        }
        if met.len() > known {
            (at.met, at.values, at.point) = (self.export(&met), values, point);
        }
        Ok(samples)
    }
}
