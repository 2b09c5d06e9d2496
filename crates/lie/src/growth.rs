//! Generic accessibility: dimensions at almost every point.

use bracketry_symbolic::{Bindings, Pool, Symbol};

use crate::error::{Undecided, check_growth};
use crate::evidence::Evidence;
use crate::fields::{Field, VectorFields, bracket, is_plain_zero};
use crate::merge::merge_equal;
use crate::word::Word;

/// The distribution that a closure under brackets ends in, with the dimensions on the way.
#[derive(Clone, Debug)]
pub struct Closure {
    /// Entry k: dimension at a generic point after k rounds of brackets. The list ends when
    /// the dimension stops growing (the repeated value is kept) or is full.
    pub growth: Vec<usize>,
    /// Brackets that span the distribution at a generic point, the first `growth[k]` of them after k rounds.
    pub basis: Vec<Field>,
    /// The brackets of `basis` as words in the generators f (number 0), g_1 … g_m.
    pub words: Vec<Word>,
}

impl Closure {
    /// Final dimension.
    pub fn dimension(&self) -> usize {
        self.basis.len()
    }
}

/// The smallest distribution that contains `start` and is closed under brackets with
/// `generators` and with itself, at a generic point.
///
/// Let K be the field of functions and Δ_k the K-span of the fields after k rounds. For
/// X ∈ `generators`, `[X, aY] = a[X, Y] + (X·a)Y`, so Δ_k + [X, Δ_k] is spanned by Δ_k and
/// the brackets of X with any K-basis of Δ_k. A basis element that was already in Δ_{k−1}
/// has its brackets in Δ_k. Hence only the fields that were new in the last round, and of
/// them only independent ones, need to be bracketed; and by the Jacobi identity brackets of
/// the form [X_1, [X_2, … ]] span all iterated brackets. Dimension at a generic point is
/// dimension over K. When a round adds nothing, Δ_k is closed and no later round adds anything.
fn close(
    pool: &mut Pool,
    states: &[Symbol],
    start: Spanning,
    generators: &Spanning,
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Closure, Undecided> {
    let first_node = pool.len();
    let mut basis = start;
    let mut fresh = 0..basis.fields.len();
    let mut growth = vec![basis.fields.len()];
    while !fresh.is_empty() && basis.fields.len() < states.len() {
        let known = basis.fields.len();
        let mut candidates = basis.clone();
        for (x, name) in generators.fields.iter().zip(&generators.words) {
            for j in fresh.clone() {
                let y = &basis.fields[j];
                check_growth(pool, first_node, [x, y], 1)?;
                let z = bracket(pool, states, x, y);
                if !is_plain_zero(pool, &z) && !candidates.fields.contains(&z) {
                    candidates.push(z, Word::bracket(name.clone(), basis.words[j].clone()));
                }
            }
        }
        basis = candidates.independent(pool, bindings, evidence)?;
        fresh = known..basis.fields.len();
        if let Ok(merged) = merge_equal(pool, &basis.fields, bindings, evidence) {
            basis.fields = merged;
        }
        growth.push(basis.fields.len());
    }
    Ok(Closure { growth, basis: basis.fields, words: basis.words })
}

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
fn independent_rows(
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
        close(pool, &self.states, generators.clone(), &generators, &self.bindings, evidence)
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
        let mut generators = controls.clone();
        if !is_plain_zero(pool, &self.drift) {
            generators.push(self.drift.clone(), Word::Generator(0));
        }
        close(pool, &self.states, controls, &generators, &self.bindings, evidence)
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
