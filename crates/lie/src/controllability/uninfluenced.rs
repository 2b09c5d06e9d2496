//! Functions of the state that no input influences.

use std::sync::Arc;

use bracketry_symbolic::Pool;

use crate::algebra::closure::{Closure, close};
use crate::algebra::field::{Field, VectorFields, is_plain_zero};
use crate::algebra::integrals::search::{Integrals, integrals_of_involutive};
use crate::algebra::krylov::Krylov;
use crate::algebra::span::{Spanning, independent, involutive};
use crate::algebra::word::Word;
use crate::algebra::word::{Bracket, Generator};
use crate::answer::Answer;
use crate::budget::check_analysis;
use crate::dimensions::Dimensions;
use crate::evidence::Evidence;
use crate::reason::Reason;
use crate::undecided::Undecided;

impl VectorFields {
    /// Functions φ with dφ = 0 along the strong accessibility distribution that `basis` spans,
    /// with the functions in the fields as building blocks (see [`integrals`](crate::algebra::integrals)).
    ///
    /// By Frobenius' theorem there are exactly n − dim of them near a generic point.
    ///
    /// # Errors
    /// [`Undecided`] if a function in the fields cannot be evaluated exactly.
    pub fn autonomous(
        &self,
        pool: &mut Pool,
        basis: &[Field],
        evidence: &mut Evidence,
    ) -> Result<Integrals, Undecided> {
        let mut known = self.controls.concat();
        known.extend(&self.drift);
        integrals_of_involutive(pool, &self.states, basis, &known, &self.bindings, evidence)
    }
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

/// The distributions that the inputs generate at a generic point.
pub(crate) struct Reach {
    pub(crate) all: Result<Closure, Undecided>,
    pub(crate) strong: Result<Closure, Undecided>,
    /// Why the brackets were not closed, where the dimensions are those of a controllable linearization.
    pub(crate) not_closed: Option<Undecided>,
}

impl Reach {
    /// `first` is how many nodes the pool had made when the analysis began.
    pub(crate) fn of(pool: &mut Pool, fields: &VectorFields, first: usize, evidence: &mut Evidence) -> Reach {
        if let Some(linear) = Krylov::of_large(pool, fields) {
            let all = linear.close(pool, true, evidence);
            return Reach { all, strong: linear.close(pool, false, evidence), not_closed: None };
        }
        let all = check_analysis(pool, first).and_then(|()| fields.accessibility(pool, evidence));
        let driftless = fields.drift.iter().all(|&e| pool.is_zero(e));
        let strong = if driftless {
            all.clone()
        } else {
            check_analysis(pool, first).and_then(|()| fields.strong_accessibility(pool, evidence))
        };
        Reach { all, strong, not_closed: None }
    }

    /// The words of the closures are in these generators.
    pub(crate) fn dimensions(&self, generators: &Arc<[Generator]>) -> Dimensions {
        let growth = |c: &Result<Closure, Undecided>| c.as_ref().map(|c| c.growth.clone()).unwrap_or_default();
        let dimension = |c: &Result<Closure, Undecided>| -> Answer<usize> {
            c.as_ref().map(Closure::dimension).map_err(Clone::clone).into()
        };
        let basis = |c: &Result<Closure, Undecided>| -> Vec<Bracket> {
            c.iter().flat_map(|c| Bracket::list(&c.words, generators)).collect()
        };
        Dimensions {
            basis: basis(&self.all),
            strong_basis: basis(&self.strong),
            growth_reason: self.not_closed.clone().map(Reason::from),
            ..Dimensions::new(growth(&self.all), dimension(&self.all), growth(&self.strong), dimension(&self.strong))
        }
    }
}
