//! The involutive closure of the input fields.

use bracketry_symbolic::{Function, Pool};
use serde::Serialize;

use crate::algebra::field::VectorFields;
use crate::algebra::integrals::search::{Among, integrals_among};
use crate::algebra::involutive::involutive_closure;
use crate::algebra::word::{Bracket, generators};
use crate::evidence::Evidence;
use crate::undecided::Undecided;

/// The smallest involutive distribution that contains the input fields, and its integrals.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct InvolutiveClosureReport {
    /// Its dimension.
    pub dimension: usize,
    /// Dimensions of the derived flag, from that of the span of the input fields.
    pub growth: Vec<usize>,
    /// Brackets that span it.
    pub basis: Vec<Bracket>,
    /// Independent functions that are constant along all input fields.
    pub integrals: Vec<Function>,
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
        Ok(InvolutiveClosureReport {
            dimension: closure.dimension(),
            basis: Bracket::list(&closure.words, &generators(self.controls.len())),
            growth: closure.growth,
            integrals: Function::list(pool, &found.functions),
            integrals_not_found: (found.missing > 0).then_some(found.missing),
        })
    }
}
