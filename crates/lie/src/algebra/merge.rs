//! Keeping iterated brackets small: sub-expressions with equal values become one.

use bracketry_symbolic::{Bindings, Expr, Node, Pool};
use rustc_hash::FxHashMap;

use crate::algebra::field::Field;
use crate::evidence::Evidence;
use crate::residues::{Fp, OFFSET};
use crate::undecided::Undecided;

/// Seed and number of the points at which sub-expressions are compared.
const SEED: u64 = 0x6272_6163_6b65_7404;
const POINTS: usize = 3;
/// Fewer nodes are left as they are.
const WORTHWHILE: usize = 300;
/// Largest numerator and denominator of a constant that is written as a number.
const BOUND: u64 = 1 << 20;

/// The same fields, with every sub-expression replaced by the first one that agrees with it, or
/// with its negative, at random points, and by a number where it is a small rational constant.
///
/// Brackets are made by the rules of differentiation and cancel without being seen to. What is
/// left of that grows exponentially with the length of the bracket; equal values are equal
/// functions up to the error probability of any exact test.
pub(crate) fn merge_equal(
    pool: &mut Pool,
    fields: &[Field],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Vec<Field>, Undecided> {
    let nodes = pool.reachable(&fields.concat());
    if nodes.len() < WORTHWHILE {
        return Ok(fields.to_vec());
    }
    let samples = pool.sample_in::<OFFSET>(&nodes, bindings, POINTS, SEED)?;
    evidence.add_equalities(&samples, nodes.len())?;
    let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut first: FxHashMap<[Fp; POINTS], Expr> = FxHashMap::default();
    for (i, &e) in nodes.iter().enumerate() {
        let value: [Fp; POINTS] = std::array::from_fn(|k| samples.values[k][i]);
        let new = if let Some(&same) = first.get(&value) {
            same
        } else if matches!(pool.node(e), Node::Num(_) | Node::Pi | Node::Sym(_)) {
            e
        } else if let Some(c) = constant(&value) {
            pool.rational(c)
        } else if let Some(&opposite) = first.get(&value.map(|v| -v)) {
            pool.neg(opposite)
        } else {
            pool.rebuild(e, |o| image[&o])
        };
        first.entry(value).or_insert(new);
        image.insert(e, new);
    }
    Ok(fields.iter().map(|f| f.iter().map(|e| image[e]).collect()).collect())
}

fn constant(value: &[Fp; POINTS]) -> Option<bracketry_symbolic::Rational> {
    if value.iter().any(|v| *v != value[0]) {
        return None;
    }
    value[0].to_rational(BOUND)
}
