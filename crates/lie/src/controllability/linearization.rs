//! The linearization at an equilibrium.

use bracketry_symbolic::{Expr, Pool, Real};
use nalgebra::{DMatrix, DVector};

use crate::algebra::field::{Field, VectorFields};
use crate::answer::Answer;
use crate::controllability::local_accessibility::Frame;
use crate::evidence::Evidence;
use crate::linear::clusters::{Cluster, clusters, decay};
use crate::linear::matrix::{Matrix, RationalMatrix, quotient_by_reachable};
use crate::linear::spectrum::{MAX_IRRATIONAL, Root, Spectrum};
use crate::reason::Reason;
use crate::residues::times;
use crate::residues::{Echelon, Fp};
use crate::undecided::Undecided;
use bracketry_numerics::eigen::{balance, symmetric_eigen};

/// x' = A x + B u around an equilibrium, modulo the prime.
pub(crate) struct Linearization {
    /// Row i is the gradient of f_i.
    pub(crate) a: Vec<Vec<Fp>>,
    /// One row per input.
    pub(crate) b: Vec<Vec<Fp>>,
}

impl Linearization {
    pub(crate) fn at(pool: &mut Pool, frame: &Frame, evidence: &mut Evidence) -> Result<Self, Undecided> {
        let rows: Vec<Field> = pool.jacobian(&frame.fields.drift, &frame.fields.states);
        let a = frame.evaluate(pool, &rows, evidence)?;
        let b = frame.evaluate(pool, &frame.fields.controls, evidence)?;
        Ok(Linearization { a, b })
    }

    /// span{A^k b_i}, which is span{ad_f^k g_i(x0)} at an equilibrium x0.
    pub(crate) fn controllable(&self) -> Echelon {
        Echelon::invariant(&self.b, self.a.len(), |v| times(&self.a, v))
    }

    /// The least k for which {A^j b_i, j < k} spans what all A^j b_i span, at least 1.
    pub(crate) fn index(&self) -> usize {
        let mut span = Echelon::new(&self.b, self.a.len());
        let mut block = self.b.clone();
        let mut k = 1;
        loop {
            for v in &mut block {
                *v = times(&self.a, v);
            }
            let before = span.rank();
            for v in &block {
                span.insert(v.clone());
            }
            if span.rank() == before {
                return k;
            }
            k += 1;
        }
    }
}

/// Whether the drift is linear (with a constant part) and the input fields are constant, seen from the expressions.
pub(crate) fn is_linear(pool: &mut Pool, fields: &VectorFields) -> bool {
    let mut entries = pool.jacobian(&fields.drift, &fields.states).concat();
    entries.extend(fields.controls.concat());
    pool.symbols_of(&entries).iter().all(|s| !fields.states.contains(s))
}

/// The part of the linearization that no input reaches: the states modulo the controllable subspace span{A^k b_i}.
pub(crate) struct Uncontrollable {
    /// Its eigenvalues; with exact multiplicities and half-planes where A and B are known exactly.
    pub(crate) roots: Vec<Root>,
    /// Whether all eigenvalues have negative real part (true), one has positive real part (false), or else why neither is known.
    pub(crate) decays: Answer<bool>,
    /// A and B, where all their entries are rational.
    pub(crate) exact: Option<(RationalMatrix, RationalMatrix)>,
}

/// `rank` is the exact dimension of the controllable subspace.
///
/// # Errors
/// The [`Reason`] why there are no eigenvalues: an entry has no numerical value, the subspace is not clear of rounding,
/// or the QR algorithm does not converge.
pub(crate) fn uncontrollable(
    pool: &mut Pool,
    frame: &Frame,
    rank: usize,
    evidence: &mut Evidence,
) -> Result<Uncontrollable, Reason> {
    let n = frame.fields.states.len();
    if rank == n {
        return Ok(Uncontrollable { roots: Vec::new(), decays: Answer::Known(true), exact: None });
    }
    if let Some((a, b)) = exact_matrices(pool, frame, evidence)
        && let rest = quotient_by_reachable(&a, &b)
        && rest.rows().len() + rank == n
        && let Some(spectrum) = Spectrum::of_reals(&rest)
    {
        let decays = match (spectrum.right, spectrum.on_axis) {
            (0, 0) => Answer::Known(true),
            (0, _) => Answer::Unknown(Reason::OnAxis),
            _ => Answer::Known(false),
        };
        return Ok(Uncontrollable { roots: spectrum.roots, decays, exact: a.rational().zip(b.rational()) });
    }
    let (a, b) = matrices(pool, frame).ok_or(Reason::NoNumbers)?;
    let rest = complement(&a, &b, rank).ok_or(Reason::Rounding)?;
    let block = rest.transpose() * &a * &rest;
    let found = clusters(&block, a.norm()).ok_or(Reason::NoConvergence)?;
    let decays = decay(&found).map_or(Answer::Unknown(Reason::NearAxis), Answer::Known);
    let root = |c: &Cluster| Root { re: c.re, im: c.im, multiplicity: c.count, exact: None };
    Ok(Uncontrollable { roots: found.iter().map(root).collect(), decays, exact: None })
}

/// Whether all eigenvalues of A are seen to have negative real parts.
pub(crate) fn is_hurwitz(pool: &mut Pool, frame: &Frame, evidence: &mut Evidence) -> bool {
    let exact = exact_matrices(pool, frame, evidence);
    if let Some(spectrum) = exact.and_then(|(a, _)| Spectrum::of_reals(&a)) {
        return spectrum.right == 0 && spectrum.on_axis == 0;
    }
    let Some((a, _)) = matrices(pool, frame) else { return false };
    clusters(&a, a.norm()).is_some_and(|found| decay(&found) == Some(true))
}

/// Orthonormal columns that span the orthogonal complement of span{A^k b_i}, whose exact dimension
/// is `rank`; `None` if the numbers do not show that dimension.
pub(crate) fn complement(a: &DMatrix<f64>, b: &DMatrix<f64>, rank: usize) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    // Orthonormal steps keep the powers of A from hiding small directions.
    let scale = a.norm().max(f64::MIN_POSITIVE);
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut queue: std::collections::VecDeque<DVector<f64>> =
        b.column_iter().map(nalgebra::Matrix::into_owned).filter(|c| c.norm() > 0.0).map(|c| c.normalize()).collect();
    while let Some(v) = queue.pop_front() {
        let mut rest = v;
        for _ in 0..2 {
            for e in &basis {
                let along = e.dot(&rest);
                rest.axpy(-along, e, 1.0);
            }
        }
        let size = rest.norm();
        if size > INDEPENDENT {
            let e = rest / size;
            queue.push_back(a * &e / scale);
            basis.push(e);
        }
    }
    if basis.len() != rank {
        return None;
    }
    let mut projection = DMatrix::identity(n, n);
    for e in &basis {
        projection -= e * e.transpose();
    }
    let eigen = symmetric_eigen(projection)?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    Some(eigen.eigenvectors.select_columns(&order[..n - rank]))
}

/// A unit vector less than this away from a subspace counts as in it.
const INDEPENDENT: f64 = 1e-10;

/// The entries of A by rows, then those of B by columns.
fn entries(pool: &mut Pool, frame: &Frame) -> Vec<Expr> {
    let mut roots: Vec<Expr> = pool.jacobian(&frame.fields.drift, &frame.fields.states).concat();
    roots.extend(frame.fields.controls.concat());
    roots
}

/// A and the columns of B as rows; `None` if an entry has no exact value, and where not all entries of large matrices are rational.
pub(crate) fn exact_matrices(
    pool: &mut Pool,
    frame: &Frame,
    evidence: &mut Evidence,
) -> Option<(Matrix<Real>, Matrix<Real>)> {
    let n = frame.fields.states.len();
    let roots = entries(pool, frame);
    let mut values = if n > MAX_IRRATIONAL {
        frame.rationals(pool, &roots)?.into_iter().map(Real::from).collect()
    } else {
        frame.reals(pool, &roots, evidence)?
    };
    let b = values.split_off(n * n);
    let matrix = |list: Vec<Real>| Matrix::new(list.chunks(n).map(<[Real]>::to_vec).collect(), n);
    Some((matrix(values), matrix(b)))
}

/// A and B as numbers, in units of the states in which rows and columns of A are alike in size: rounding is relative to the norm, which
/// large entries beside small ones would dominate. `None` if a symbol has no value or a value is not finite.
fn matrices(pool: &mut Pool, frame: &Frame) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let n = frame.fields.states.len();
    let roots = entries(pool, frame);
    let values = frame.numbers(pool, &roots)?;
    let (a, b) = values.split_at(n * n);
    let (mut a, mut b) = (DMatrix::from_row_slice(n, n, a), DMatrix::from_column_slice(n, b.len() / n, b));
    let units = balance(&mut a);
    for (mut row, unit) in b.row_iter_mut().zip(&units) {
        row /= *unit;
    }
    Some((a, b))
}
