//! Generic accessibility: dimensions at almost every point.

use bracketry_symbolic::{Bindings, Expr, Pool, Symbol, ZeroTest};

use crate::algebra::field::{Field, VectorFields, bracket, is_plain_zero};
use crate::algebra::peel::Peeled;
use crate::algebra::word::Word;
use crate::budget::check_growth;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

/// Fields with the words that they come from.
#[derive(Clone, Default)]
pub(crate) struct Spanning {
    pub(crate) fields: Vec<Field>,
    pub(crate) words: Vec<Word>,
}

impl Spanning {
    pub(crate) fn push(&mut self, field: Field, word: Word) {
        self.fields.push(field);
        self.words.push(word);
    }

    /// A maximal set that is independent at a generic point, greedily from the first.
    pub(crate) fn independent(
        self,
        pool: &mut Pool,
        bindings: &Bindings,
        evidence: &mut Evidence,
    ) -> Result<Self, Undecided> {
        let mut kept = Self::default();
        for i in independent_rows(pool, &self.fields, bindings, evidence)? {
            kept.push(self.fields[i].clone(), self.words[i].clone());
        }
        Ok(kept)
    }
}

/// A maximal set of fields that are independent at a generic point, greedily from the first.
pub(crate) fn independent(
    pool: &mut Pool,
    fields: &[Field],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Vec<Field>, Undecided> {
    let rows = independent_rows(pool, fields, bindings, evidence)?;
    Ok(rows.into_iter().map(|i| fields[i].clone()).collect())
}

/// The numbers of these fields.
pub(crate) fn independent_rows(
    pool: &mut Pool,
    fields: &[Field],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Vec<usize>, Undecided> {
    let peeled = Peeled::of(pool, fields);
    let mut independent: Vec<usize> = peeled.units.iter().map(|u| u.0).collect();
    if !peeled.rest.is_empty() {
        evidence.allow_elimination(peeled.rest.len(), peeled.columns.len())?;
        let rank = pool.rank(&peeled.rest(fields), bindings)?;
        evidence.add(&rank.certificate);
        independent.extend(rank.independent.iter().map(|&i| peeled.rest[i]));
        independent.sort_unstable();
    }
    Ok(independent)
}

/// Whether the brackets of `basis` (independent fields) stay in its span, at a generic point.
/// Those among its first `old` fields are known to.
pub(crate) fn involutive(
    pool: &mut Pool,
    states: &[Symbol],
    basis: &[Field],
    old: usize,
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<bool, Undecided> {
    if basis.len() == states.len() {
        return Ok(true);
    }
    let first_node = pool.len();
    let mut all = basis.to_vec();
    for (i, a) in basis.iter().enumerate().skip(old) {
        for b in &basis[..i] {
            check_growth(pool, first_node, [a, b], 1)?;
            let z = bracket(pool, states, a, b);
            if !is_plain_zero(pool, &z) {
                all.push(z);
            }
        }
    }
    Ok(independent(pool, &all, bindings, evidence)?.len() == basis.len())
}

impl VectorFields {
    /// Whether a function is zero everywhere.
    pub(crate) fn vanishes(&self, pool: &mut Pool, e: Expr, evidence: &mut Evidence) -> Result<bool, Undecided> {
        if pool.number(e).is_some() {
            return Ok(pool.is_zero(e));
        }
        match pool.zero_test(e, &self.bindings) {
            ZeroTest::Zero(certificate) => {
                evidence.add(&certificate);
                Ok(true)
            }
            ZeroTest::NonZero => Ok(false),
            ZeroTest::Unknown(why) => Err(why.into()),
        }
    }
}

/// Whether a function is found to be zero everywhere.
pub(crate) fn vanishes(pool: &mut Pool, e: Expr, bindings: &Bindings) -> bool {
    pool.is_zero(e) || matches!(pool.zero_test(e, bindings), ZeroTest::Zero(_))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Two entries in each row, none of them a number: all rows would have to be eliminated.
    #[test]
    fn ranks_that_take_too_many_products_are_undecided_before_they_are_taken() {
        let n = 700;
        let mut pool = Pool::new();
        let (x, y, zero) = (pool.parse("x").unwrap(), pool.parse("y").unwrap(), pool.int(0));
        let entry = |i: usize, j: usize| if j == i { x } else { zero };
        let row = |i: usize| -> Field { (0..n).map(|j| if j == (i + 1) % n { y } else { entry(i, j) }).collect() };
        let rows: Vec<Field> = (0..n).map(row).collect();
        let mut evidence = Evidence::default();
        let why = independent_rows(&mut pool, &rows, &Bindings::new(), &mut evidence).unwrap_err();
        assert!(why.to_string().contains("products"), "{why}");
        let few: Vec<Field> = rows[..5].to_vec();
        assert_eq!(independent_rows(&mut pool, &few, &Bindings::new(), &mut evidence).unwrap(), [0, 1, 2, 3, 4]);
    }
}
