//! The linearization at an equilibrium.

use bracketry_symbolic::{Expr, Pool};
use nalgebra::{DMatrix, DVector};

use crate::algebra::field::Field;
use crate::answer::Answer;
use crate::controllability::local::Frame;
use crate::evidence::Evidence;
use crate::reason::Reason;
use crate::residues::times;
use crate::residues::{Echelon, Fp};
use crate::undecided::Undecided;

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
        let mut span = Echelon::empty(self.a.len());
        let mut queue: Vec<Vec<Fp>> = self.b.clone();
        while let Some(v) = queue.pop() {
            if span.insert(v.clone()) {
                queue.push(times(&self.a, &v));
            }
        }
        span
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

/// Whether the modes of the linearization that inputs do not reach decay.
///
/// `rank` is the exact dimension of the controllable subspace. True if their eigenvalues
/// have negative real part, false if one has positive real part (then no smooth feedback
/// stabilizes the equilibrium), unknown within rounding of the imaginary axis.
pub(crate) fn uncontrollable_modes_decay(pool: &mut Pool, frame: &Frame, rank: usize) -> Answer<bool> {
    if rank == frame.fields.states.len() {
        return Answer::Known(true);
    }
    let (block, tolerance) = match uncontrollable_block(pool, frame, rank) {
        Ok(found) => found,
        Err(why) => return Answer::Unknown(why),
    };
    let worst = block.complex_eigenvalues().iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max);
    if worst < -tolerance {
        Answer::Known(true)
    } else if worst > tolerance {
        Answer::Known(false)
    } else {
        Answer::Unknown(Reason::NearAxis)
    }
}

/// The matrix of the linearization on the states modulo the controllable subspace, whose exact
/// dimension is `rank`, with the accuracy of its eigenvalues; or why there is none.
pub(crate) fn uncontrollable_block(pool: &mut Pool, frame: &Frame, rank: usize) -> Result<(DMatrix<f64>, f64), Reason> {
    let n = frame.fields.states.len();
    let (a, b) = matrices(pool, frame).ok_or(Reason::NoNumbers)?;
    let rest = complement(&a, &b, rank).ok_or(Reason::Rounding)?;
    let block = rest.transpose() * &a * &rest;
    let scale = a.norm().max(f64::MIN_POSITIVE);
    // An eigenvalue of multiplicity k moves by the k-th root of a perturbation.
    let tolerance = 10.0 * scale * (n as f64 * f64::EPSILON).powf(1.0 / block.nrows() as f64);
    Ok((block, tolerance))
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
    let eigen = projection.symmetric_eigen();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    Some(eigen.eigenvectors.select_columns(&order[..n - rank]))
}

/// A unit vector less than this away from a subspace counts as in it.
const INDEPENDENT: f64 = 1e-10;

/// A and B as numbers; `None` if a symbol has no value or a value is not finite.
fn matrices(pool: &mut Pool, frame: &Frame) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let n = frame.fields.states.len();
    let mut roots: Vec<Expr> = pool.jacobian(&frame.fields.drift, &frame.fields.states).concat();
    roots.extend(frame.fields.controls.concat());
    let values = frame.numbers(pool, &roots)?;
    let (a, b) = values.split_at(n * n);
    Some((DMatrix::from_row_slice(n, n, a), DMatrix::from_column_slice(n, b.len() / n, b)))
}
