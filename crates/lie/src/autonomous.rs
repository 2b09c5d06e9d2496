//! Functions of the state that no input influences.

use bracketry_symbolic::Pool;

use crate::error::Undecided;
use crate::evidence::Evidence;
use crate::fields::{Field, VectorFields};
use crate::integrals::{Integrals, integrals_of_involutive};

impl VectorFields {
    /// Functions φ with dφ = 0 along the strong accessibility distribution that `basis` spans,
    /// with the functions in the fields as building blocks (see [`integrals`](crate::integrals)).
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
