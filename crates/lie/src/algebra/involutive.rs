//! The smallest involutive distribution that contains given fields.

use bracketry_symbolic::{Bindings, Pool, Symbol};

use crate::algebra::closure::Closure;
use crate::algebra::field::{Field, bracket, is_plain_zero};
use crate::algebra::merge::merge_equal;
use crate::algebra::span::Spanning;
use crate::algebra::word::Word;
use crate::budget::check_growth;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

/// The involutive closure of the distribution spanned by `fields` at a generic point.
///
/// `growth` is that of the derived flag, Δ_0 = span and Δ_{k+1} = Δ_k + [Δ_k, Δ_k] (Frobenius:
/// Δ_k is integrable if and only if the flag ends there). Since `[aX, bY] = ab[X, Y] + …` with the
/// rest in Δ_k, brackets of the fields of a basis suffice, and those of older fields lie in Δ_k.
/// In `words` the fields have the numbers 1, 2, …
///
/// # Errors
/// [`Undecided`] if a function in the fields cannot be evaluated exactly, or the brackets grow too large.
pub fn involutive_closure(
    pool: &mut Pool,
    states: &[Symbol],
    fields: &[Field],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Closure, Undecided> {
    let first_node = pool.len();
    let mut start = Spanning::default();
    for (i, field) in fields.iter().enumerate() {
        start.push(field.clone(), Word::Generator(i + 1));
    }
    let mut basis = start.independent(pool, bindings, evidence)?;
    let mut growth = vec![basis.fields.len()];
    let mut old = 0;
    while old < basis.fields.len() && basis.fields.len() < states.len() {
        let mut candidates = basis.clone();
        for (i, a) in basis.fields.iter().enumerate().skip(old) {
            for (j, b) in basis.fields[..i].iter().enumerate() {
                check_growth(pool, first_node, [a, b], 1)?;
                let z = bracket(pool, states, b, a);
                if !is_plain_zero(pool, &z) && !candidates.fields.contains(&z) {
                    candidates.push(z, Word::bracket(basis.words[j].clone(), basis.words[i].clone()));
                }
            }
        }
        old = basis.fields.len();
        if candidates.fields.len() > old {
            basis = candidates.independent(pool, bindings, evidence)?;
        }
        if let Ok(merged) = merge_equal(pool, &basis.fields, bindings, evidence) {
            basis.fields = merged;
        }
        growth.push(basis.fields.len());
    }
    Ok(Closure { growth, basis: basis.fields, words: basis.words })
}
