//! The Lie algebra over the constants that the fields of a system generate.

use bracketry_symbolic::Pool;
use serde::Serialize;

use crate::algebra::constant_span::Words;
use crate::algebra::field::{Field, VectorFields, bracket, is_plain_zero};
use crate::evidence::Evidence;
use crate::options::Limits;
use crate::undecided::Undecided;

/// The finite-dimensional Lie algebra of all constant combinations of brackets of {f, g_1 … g_m}.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LieAlgebra {
    /// Its dimension over the constants.
    pub dimension: usize,
    /// Length of the longest brackets that do not all vanish; absent if there is no such length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nilpotent_length: Option<usize>,
}

/// Most dimensions of an algebra that is looked at.
const MAX_DIMENSION: usize = 40;
/// Most new nodes.
const MAX_NODES: usize = 4_000;

impl VectorFields {
    /// The Lie algebra over the constants; `None` if it is infinite-dimensional or larger than
    /// the limits.
    ///
    /// Parameters have their values. The terms of the lower central series L^1 ⊃ L^2 ⊃ … are
    /// spanned by the right-normed brackets of at least k generators, L^{k+1} = Σ [x, L^k] over the
    /// generators x; the algebra is nilpotent if the series reaches 0.
    ///
    /// # Errors
    /// [`Undecided`] if a function in the fields cannot be evaluated exactly.
    pub fn lie_algebra(
        &self,
        pool: &mut Pool,
        limits: &Limits,
        evidence: &mut Evidence,
    ) -> Result<Option<LieAlgebra>, Undecided> {
        let first_node = pool.len();
        let mut generators: Vec<Field> = self.controls.clone();
        generators.push(self.drift.clone());
        generators.retain(|g| !is_plain_zero(pool, g));
        let mut words = Words::default();
        words.extend(pool, &self.bindings, generators, evidence)?;
        let generators = words.kept.clone();
        let mut length = 1;
        while !words.fresh.is_empty() {
            let mut candidates = Vec::new();
            for (x, i) in generators.iter().flat_map(|x| words.fresh.clone().map(move |i| (x, i))) {
                if let Some(limit) = pool.reached_limit() {
                    return Err(limit.into());
                }
                if pool.len() - first_node > MAX_NODES {
                    return Ok(None);
                }
                candidates.push(bracket(pool, &self.states, x, &words.kept[i]));
            }
            length += 1;
            words.extend(pool, &self.bindings, candidates, evidence)?;
            if words.kept.len() > MAX_DIMENSION || length > 2 * limits.length {
                return Ok(None);
            }
        }
        let dimension = words.kept.len();
        let mut series = words.kept;
        let mut nilpotent_length = 0;
        while !series.is_empty() {
            let mut candidates = Vec::new();
            for (x, y) in generators.iter().flat_map(|x| series.iter().map(move |y| (x, y))) {
                if let Some(limit) = pool.reached_limit() {
                    return Err(limit.into());
                }
                if pool.len() - first_node > MAX_NODES {
                    return Ok(None);
                }
                candidates.push(bracket(pool, &self.states, x, y));
            }
            let mut next = Words::default();
            next.extend(pool, &self.bindings, candidates, evidence)?;
            nilpotent_length += 1;
            if next.kept.len() == series.len() {
                return Ok(Some(LieAlgebra { dimension, nilpotent_length: None }));
            }
            series = next.kept;
        }
        Ok(Some(LieAlgebra { dimension, nilpotent_length: Some(nilpotent_length) }))
    }
}
