//! Generic accessibility: dimensions at almost every point.

use bracketry_symbolic::{Bindings, Pool, Symbol};

use crate::closure::{Closure, close};
use crate::error::{Undecided, check_growth};
use crate::evidence::Evidence;
use crate::fields::{Field, VectorFields, bracket, is_plain_zero};
use crate::word::Word;

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
    let numbers: Vec<usize> = (0..fields.len()).filter(|&i| !is_plain_zero(pool, &fields[i])).collect();
    if numbers.is_empty() {
        return Ok(numbers);
    }
    let rows: Vec<Field> = numbers.iter().map(|&i| fields[i].clone()).collect();
    evidence.allow_elimination(rows.len(), rows[0].len())?;
    let rank = pool.rank(&rows, bindings)?;
    evidence.add(&rank.certificate);
    Ok(rank.independent.iter().map(|&i| numbers[i]).collect())
}

impl VectorFields {
    /// The accessibility distribution: all iterated brackets of {f, g_1 … g_m}.
    ///
    /// # Errors
    /// [`Undecided`] if a function in the fields cannot be evaluated exactly.
    pub fn accessibility(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Closure, Undecided> {
        let mut all = Spanning::default();
        for (i, field) in self.generators().into_iter().enumerate() {
            all.push(field, Word::Generator(i));
        }
        // [aX, Y] = a[X, Y] − (Y·a)X with X itself in the distribution: a K-basis of generators will do.
        let generators = all.independent(pool, &self.bindings, evidence)?;
        close(pool, &self.states, &generators, None, &self.bindings, evidence)
    }

    /// The strong accessibility distribution: the smallest that contains the g_i and is
    /// closed under brackets with f and the g_i.
    ///
    /// # Errors
    /// [`Undecided`] if a function in the fields cannot be evaluated exactly.
    pub fn strong_accessibility(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Closure, Undecided> {
        let mut all = Spanning::default();
        for (i, field) in self.controls.iter().enumerate() {
            all.push(field.clone(), Word::Generator(i + 1));
        }
        let controls = all.independent(pool, &self.bindings, evidence)?;
        let drift = (!is_plain_zero(pool, &self.drift)).then_some(&self.drift);
        close(pool, &self.states, &controls, drift, &self.bindings, evidence)
    }

    /// Whether the distribution spanned by the input fields is involutive at a generic point.
    ///
    /// # Errors
    /// [`Undecided`] if a function in the fields cannot be evaluated exactly.
    pub fn is_involutive(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<bool, Undecided> {
        let controls = independent(pool, &self.controls, &self.bindings, evidence)?;
        involutive(pool, &self.states, &controls, 0, &self.bindings, evidence)
    }
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
            all.push(z);
        }
    }
    Ok(independent(pool, &all, bindings, evidence)?.len() == basis.len())
}
