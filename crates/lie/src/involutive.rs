//! The smallest involutive distribution that contains given fields.

use std::fmt;

use bracketry_symbolic::{Bindings, Pool, Symbol};
use serde::Serialize;

use crate::closure::Closure;
use crate::error::{Undecided, check_growth};
use crate::evidence::Evidence;
use crate::fields::{Field, VectorFields, bracket, is_plain_zero};
use crate::growth::Spanning;
use crate::integrals::{Among, integrals_among};
use crate::merge::merge_equal;
use crate::word::{Word, generator_names};

/// The involutive closure of the distribution spanned by `fields` at a generic point.
///
/// `growth` is that of the derived flag, Δ_0 = span and Δ_{k+1} = Δ_k + [Δ_k, Δ_k] (Frobenius:
/// Δ_k is integrable exactly if the flag ends there). Since `[aX, bY] = ab[X, Y] + …` with the
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

/// The smallest involutive distribution that contains the input fields, and its integrals.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct InvolutiveClosureReport {
    /// Its dimension.
    pub dimension: usize,
    /// Dimensions of the derived flag, from that of the span of the input fields.
    pub growth: Vec<usize>,
    /// Names of brackets that span it.
    pub basis: Vec<String>,
    /// Independent functions that are constant along all input fields.
    pub integrals: Vec<String>,
    /// How many more such functions exist than were found in closed form, for a smoothed model among the linear
    /// functions; absent if none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub integrals_not_found: Option<usize>,
}

impl VectorFields {
    /// The involutive closure of the input fields with its integrals among some functions.
    pub(crate) fn involutive_closure_report(
        &self,
        pool: &mut Pool,
        among: Among,
        evidence: &mut Evidence,
    ) -> Result<InvolutiveClosureReport, Undecided> {
        let closure = involutive_closure(pool, &self.states, &self.controls, &self.bindings, evidence)?;
        let known = [&self.drift[..], &self.controls.concat()].concat();
        let found = integrals_among(pool, &self.states, &closure.basis, &known, &self.bindings, among, evidence)?;
        let names = generator_names(self.controls.len());
        Ok(InvolutiveClosureReport {
            dimension: closure.dimension(),
            basis: closure.words.iter().map(|w| w.name(&names)).collect(),
            growth: closure.growth,
            integrals: found.functions.iter().map(|&e| pool.text(e)).collect(),
            integrals_not_found: (found.missing > 0).then_some(found.missing),
        })
    }
}

impl fmt::Display for InvolutiveClosureReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let growth: Vec<String> = self.growth.iter().map(ToString::to_string).collect();
        write!(f, "dimension {} (growth {})", self.dimension, growth.join(", "))?;
        if !self.integrals.is_empty() {
            write!(f, ", constant along it {}", self.integrals.join(",  "))?;
        }
        if let Some(k) = self.integrals_not_found {
            write!(f, ", {k} not found in closed form")?;
        }
        Ok(())
    }
}
