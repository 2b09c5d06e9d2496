//! The prime field of sampled ranks.

use bracketry_symbolic::{Residue, SECOND_PRIME};

/// Modulo this prime the values at a point such as π/3 exist too: it holds √2 … √53 and the sines of π/4320.
pub(crate) const PRIME: u64 = SECOND_PRIME;
/// An integer modulo 2^61 − [`PRIME`].
pub(crate) type Fp = Residue<PRIME>;
/// Reduced row echelon form over this field.
pub(crate) type Echelon = bracketry_symbolic::Echelon<PRIME>;
