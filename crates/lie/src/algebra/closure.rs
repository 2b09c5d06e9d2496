//! Distributions closed under brackets with their generators, at a generic point.

use bracketry_symbolic::{Bindings, Pool, Symbol};

use crate::algebra::field::{Field, bracket, is_plain_zero};
use crate::algebra::merge::merge_equal;
use crate::algebra::naming::{History, Round};
use crate::algebra::reduce::{Reduced, reduce};
use crate::algebra::span::{Spanning, independent_rows};
use crate::algebra::word::Word;
use crate::budget::{check_growth, release};
use crate::evidence::Evidence;
use crate::undecided::Undecided;

/// The distribution that a closure under brackets ends in, with the intermediate dimensions.
#[derive(Clone, Debug)]
pub struct Closure {
    /// Entry k: dimension at a generic point after k rounds of brackets. The list ends when
    /// the dimension stops growing (the repeated value is kept) or is full.
    pub growth: Vec<usize>,
    /// Fields that span the distribution at a generic point, the first `growth[k]` of them that after k rounds.
    /// They need not be brackets themselves but may be simpler combinations, over the functions.
    pub basis: Vec<Field>,
    /// Brackets that span the same distributions, as words in the generators f (number 0), g_1 … g_m.
    pub words: Vec<Word>,
}

impl Closure {
    /// Final dimension.
    pub fn dimension(&self) -> usize {
        self.basis.len()
    }

    /// The fields that `words` stand for, for one field per generator.
    ///
    /// # Errors
    /// [`Undecided::TooLarge`] where the brackets take too many nodes.
    pub(crate) fn brackets(
        &self,
        pool: &mut Pool,
        states: &[Symbol],
        generators: &[Field],
        bindings: &Bindings,
        evidence: &mut Evidence,
    ) -> Result<Vec<Field>, Undecided> {
        let first_node = pool.len();
        let mut found: Vec<Field> = Vec::with_capacity(self.words.len());
        for &dimension in &self.growth {
            for i in found.len()..dimension.min(self.words.len()) {
                let field = match &self.words[i] {
                    Word::Generator(g) => generators[*g].clone(),
                    Word::Bracket(ab) => {
                        let factor = |w: &Word| match w {
                            Word::Generator(g) => generators.get(*g),
                            Word::Bracket(_) => self.words[..i].iter().position(|v| v == w).map(|j| &found[j]),
                        };
                        let (Some(a), Some(b)) = (factor(&ab[0]), factor(&ab[1])) else { continue };
                        check_growth(pool, first_node, [a, b], 1)?;
                        bracket(pool, states, a, b)
                    }
                };
                found.push(field);
            }
            if let Ok(merged) = merge_equal(pool, &found, bindings, evidence) {
                found = merged;
            }
        }
        Ok(found)
    }
}

/// The smallest distribution that contains `start` and is closed under brackets with `start`,
/// with `drift` if there is one, and with itself, at a generic point. The `start` is independent.
///
/// Let K be the field of functions and Δ_k the K-span of the fields after k rounds. For
/// a generator X, `[X, aY] = a[X, Y] + (X·a)Y`, so Δ_k + [X, Δ_k] is spanned by Δ_k and
/// the brackets of X with any K-basis of Δ_k. A basis element that was already in Δ_{k−1}
/// has its brackets in Δ_k. Hence only the fields that were new in the last round, and of
/// them only independent ones, need to be bracketed; and by the Jacobi identity brackets of
/// the form [X_1, [X_2, … ]] span all iterated brackets. Dimension at a generic point is
/// dimension over K. When a round adds nothing, Δ_k is closed and no later round adds anything.
///
/// For the same reason every K-basis will do, also of the generators, as `[aX, Y] = a[X, Y] − (Y·a)X` and X
/// itself is in Δ_0 or, for the drift, changed by fields of Δ_0 only: see [`reduce`].
pub(crate) fn close(
    pool: &mut Pool,
    states: &[Symbol],
    start: &Spanning,
    drift: Option<&Field>,
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Closure, Undecided> {
    let simplified = close_by(pool, states, start, drift, true, bindings, evidence)?;
    match simplified {
        Some(closure) => Ok(closure),
        // Without simplifications the words are known.
        None => close_by(pool, states, start, drift, false, bindings, evidence)?
            .ok_or(Undecided::Exact(bracketry_symbolic::Undecided::TooComplex)),
    }
}

/// Brackets of generators with the fresh fields of a round.
struct Products {
    /// All that do not vanish, with the numbers of generator and field.
    brackets: Vec<(usize, usize, Field)>,
    /// The rest of the distribution, then the brackets modulo its coordinate fields that differ from all before them.
    candidates: Vec<Field>,
    /// Where those brackets come from.
    origin: Vec<(usize, usize)>,
}

fn products(
    pool: &mut Pool,
    states: &[Symbol],
    generators: &[Field],
    now: &Reduced,
    first_node: usize,
) -> Result<Products, Undecided> {
    let zero = pool.int(0);
    let (mut brackets, mut candidates, mut origin) = (Vec::new(), now.rest.clone(), Vec::new());
    for (m, x) in generators.iter().enumerate() {
        for (l, y) in now.fresh.iter().enumerate() {
            check_growth(pool, first_node, [x, y], 1)?;
            let z = bracket(pool, states, x, y);
            if is_plain_zero(pool, &z) {
                continue;
            }
            let rest = now.remainder(zero, &z);
            if !is_plain_zero(pool, &rest) && !candidates.contains(&rest) {
                candidates.push(rest);
                origin.push((m, l));
            }
            brackets.push((m, l, z));
        }
    }
    Ok(Products { brackets, candidates, origin })
}

/// [`close`]; none if the words behind a simplified basis are not found.
fn close_by(
    pool: &mut Pool,
    states: &[Symbol],
    start: &Spanning,
    drift: Option<&Field>,
    simplify: bool,
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Option<Closure>, Undecided> {
    let first_node = pool.len();
    let reduce_more = |pool: &mut Pool, old: Reduced, new: Vec<Field>, evidence: &mut Evidence| {
        if simplify { reduce(pool, old, new, bindings, evidence) } else { old.with(new) }
    };
    let mut now = reduce_more(pool, Reduced::empty(states.len()), start.fields.clone(), evidence);
    let mut changed = now.units.contains(&true);
    let mut history = History {
        generators: start.fields.clone(),
        words: start.words.clone(),
        simplified: now.fresh.clone(),
        rounds: Vec::new(),
    };
    if let Some(f) = drift {
        history.generators.push(f.clone());
        history.words.push(Word::Generator(0));
        let rest = now.remainder(pool.int(0), f);
        if !is_plain_zero(pool, &rest) {
            history.simplified.push(rest);
        }
    }
    let mut growth = vec![now.dimension()];
    // The words of all rounds, and where those of the last begin, while nothing was simplified.
    let (mut words, mut last) = (start.words.clone(), 0);
    while !now.fresh.is_empty() && now.dimension() < states.len() {
        let known = now.rest.len();
        let Products { brackets, candidates, origin } = products(pool, states, &history.simplified, &now, first_node)?;
        let rows = independent_rows(pool, &candidates, bindings, evidence)?;
        let chosen: Vec<usize> = rows.into_iter().filter(|&i| i >= known).collect();
        if !changed {
            let from = std::mem::replace(&mut last, words.len());
            for (m, l) in chosen.iter().map(|i| origin[i - known]) {
                words.push(Word::bracket(history.words[m].clone(), words[from + l].clone()));
            }
        }
        let new: Vec<Field> = chosen.into_iter().map(|i| candidates[i].clone()).collect();
        history.rounds.push(Round { fresh: std::mem::take(&mut now.fresh), brackets });
        now = reduce_more(pool, now, new, evidence);
        changed |= now.units.contains(&true);
        let both = [&now.rest[..], &now.fresh].concat();
        if let Ok(mut merged) = merge_equal(pool, &both, bindings, evidence) {
            now.fresh = merged.split_off(now.rest.len());
            now.rest = merged;
        }
        growth.push(now.dimension());
    }
    history.rounds.push(Round { fresh: now.fresh, brackets: Vec::new() });
    if changed {
        let Some(found) = history.name(pool, bindings, evidence) else { return Ok(None) };
        words = found;
    }
    let mut basis: Vec<Field> = history.rounds.into_iter().flat_map(|r| r.fresh).collect();
    release(pool, first_node, &mut basis);
    Ok(Some(Closure { growth, basis, words }))
}
