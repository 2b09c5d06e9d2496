//! The prime field of sampled ranks.

use bracketry_symbolic::{Residue, SECOND_OFFSET};

/// The prime is 2^61 less this: modulo it, the values at a point such as π/3 exist too, √2 … √53, √9.81, and the sines of π/1800.
pub(crate) const OFFSET: u64 = SECOND_OFFSET;
/// An integer modulo 2^61 − [`OFFSET`].
pub(crate) type Fp = Residue<OFFSET>;
/// Reduced row echelon form over this field.
pub(crate) type Echelon = bracketry_symbolic::Echelon<Fp>;

/// The row with 1 at place i and 0 elsewhere.
pub(crate) fn unit_row<const C: u64>(i: usize, n: usize) -> Vec<Residue<C>> {
    (0..n).map(|j| if i == j { Residue::ONE } else { Residue::ZERO }).collect()
}

/// The product of a matrix, given by its rows, with a vector.
pub(crate) fn times(rows: &[Vec<Fp>], v: &[Fp]) -> Vec<Fp> {
    rows.iter().map(|row| row.iter().zip(v).fold(Fp::ZERO, |s, (&x, &y)| s + x * y)).collect()
}
