//! The involutive closure of the input fields.

use std::fmt;

use bracketry_symbolic::Pool;
use serde::Serialize;

use crate::algebra::field::VectorFields;
use crate::algebra::integrals::search::{Among, integrals_among};
use crate::algebra::involutive::involutive_closure;
use crate::algebra::word::generator_names;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

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
