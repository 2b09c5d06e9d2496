//! The smallest involutive distribution that contains given fields.

use bracketry_symbolic::{Bindings, Pool, Symbol};

use crate::error::{Undecided, check_growth};
use crate::evidence::Evidence;
use crate::fields::{Field, bracket, is_plain_zero};
use crate::growth::{Closure, independent};
use crate::merge::merge_equal;

/// The involutive closure of the distribution spanned by `fields` at a generic point.
///
/// `growth` is that of the derived flag, Δ_0 = span and Δ_{k+1} = Δ_k + [Δ_k, Δ_k] (Frobenius:
/// Δ_k is integrable exactly if the flag ends there). Since `[aX, bY] = ab[X, Y] + …` with the
/// rest in Δ_k, brackets of the fields of a basis suffice, and those of older fields lie in Δ_k.
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
    let mut basis = independent(pool, fields, bindings, evidence)?;
    let mut growth = vec![basis.len()];
    let mut old = 0;
    while old < basis.len() && basis.len() < states.len() {
        let mut candidates = basis.clone();
        for (i, a) in basis.iter().enumerate().skip(old) {
            for b in &basis[..i] {
                check_growth(pool, first_node, [a, b], 1)?;
                let z = bracket(pool, states, b, a);
                if !is_plain_zero(pool, &z) && !candidates.contains(&z) {
                    candidates.push(z);
                }
            }
        }
        old = basis.len();
        if candidates.len() > old {
            basis = independent(pool, &candidates, bindings, evidence)?;
        }
        if let Ok(merged) = merge_equal(pool, &basis, bindings, evidence) {
            basis = merged;
        }
        growth.push(basis.len());
        if basis.len() == old {
            break;
        }
    }
    Ok(Closure { growth, basis })
}
