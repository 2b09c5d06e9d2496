//! Modes of the linearization that no input reaches.

use bracketry_symbolic::{Expr, Function, Pool, Rational};
use dashu_int::ops::BitTest;
use serde::Serialize;

use crate::controllability::linearization::Uncontrollable;
use crate::controllability::local_accessibility::Frame;
use crate::linear::matrix::RationalMatrix;
use crate::linear::spectrum::Root;

/// An eigenvalue of the linearization x' = A x + B u that no input reaches: rank [A − λ, B] < n
/// (Popov–Belevitch–Hautus).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UncontrollableMode {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// How often it occurs among the uncontrollable eigenvalues.
    pub multiplicity: usize,
    /// Combinations w·x of the states (deviations from the point) with (w·x)' = λ w·x to first
    /// order whatever the inputs; known, and the eigenvalue exact, where λ and w are rational.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub combinations: Vec<Function>,
}

/// Largest numerator and denominator, in bits, of the numbers in a combination that is shown.
const MAX_BITS: usize = 24;

/// The uncontrollable eigenvalues; their number, with multiplicities, is n less the dimension of the controllable subspace.
pub(crate) fn uncontrollable_modes(pool: &mut Pool, frame: &Frame, found: &Uncontrollable) -> Vec<UncontrollableMode> {
    let mode = |root: &Root| UncontrollableMode {
        re: root.re,
        im: root.im,
        multiplicity: root.multiplicity,
        combinations: match (&root.exact, &found.exact) {
            (Some(eigenvalue), Some((a, b))) => left_eigenvectors(pool, frame, a, b, eigenvalue),
            _ => Vec::new(),
        },
    };
    found.roots.iter().map(mode).collect()
}

/// A basis of {w : wᵀA = λ wᵀ, wᵀB = 0}; empty if its numbers are too long to be read. `b` has a row for each input.
fn left_eigenvectors(
    pool: &mut Pool,
    frame: &Frame,
    a: &RationalMatrix,
    b: &RationalMatrix,
    eigenvalue: &Rational,
) -> Vec<Function> {
    let n = frame.fields.states.len();
    let mut rows = a.transposed().rows().to_vec();
    for (i, row) in rows.iter_mut().enumerate() {
        row[i] -= eigenvalue;
    }
    rows.extend(b.rows().iter().cloned());
    let basis = RationalMatrix::new(rows, n).null_space();
    let short = |x: &Rational| x.numerator().bit_len().max(x.denominator().bit_len()) <= MAX_BITS;
    if !basis.iter().flatten().all(short) {
        return Vec::new();
    }
    let combination = |w: Vec<Rational>| {
        let terms: Vec<Expr> = frame
            .fields
            .states
            .iter()
            .zip(w)
            .map(|(&s, c)| {
                let s = pool.sym(s);
                let c = pool.rational(c);
                pool.mul(c, s)
            })
            .collect();
        let sum = pool.sum(terms);
        let sum = pool.simplify(sum);
        Function::new(pool, sum)
    };
    basis.into_iter().map(combination).collect()
}
