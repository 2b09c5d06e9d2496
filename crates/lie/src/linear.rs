//! The linearisation at an equilibrium.

use bracketry_symbolic::{Expr, Fp, Pool, Tape};
use nalgebra::DMatrix;

use crate::answer::Answer;
use crate::echelon::Echelon;
use crate::error::Undecided;
use crate::evidence::Evidence;
use crate::fields::Field;
use crate::local::Frame;

/// x' = A x + B u around an equilibrium, modulo the prime.
pub(crate) struct Linearisation {
    /// Row i is the gradient of f_i.
    a: Vec<Vec<Fp>>,
    /// One row per input.
    b: Vec<Vec<Fp>>,
}

impl Linearisation {
    pub(crate) fn at(pool: &mut Pool, frame: &Frame, evidence: &mut Evidence) -> Result<Self, Undecided> {
        let rows: Vec<Field> = pool.jacobian(&frame.fields.drift, &frame.fields.states);
        let a = frame.evaluate(pool, &rows, evidence)?;
        let b = frame.evaluate(pool, &frame.fields.controls, evidence)?;
        Ok(Linearisation { a, b })
    }

    /// span{A^k b_i}, which is span{ad_f^k g_i(x0)} at an equilibrium x0.
    pub(crate) fn controllable(&self) -> Echelon {
        let mut span = Echelon::new();
        let mut queue: Vec<Vec<Fp>> = self.b.clone();
        while let Some(v) = queue.pop() {
            if span.insert(v.clone()) {
                queue.push(
                    self.a.iter().map(|row| row.iter().zip(&v).fold(Fp::ZERO, |s, (&x, &y)| s + x * y)).collect(),
                );
            }
        }
        span
    }
}

/// Whether the modes of the linearisation that inputs do not reach decay.
///
/// `rank` is the exact dimension of the controllable subspace. True if their eigenvalues
/// have negative real part, false if one has positive real part (then no smooth feedback
/// stabilises the equilibrium), unknown within rounding of the imaginary axis.
pub(crate) fn uncontrollable_modes_decay(pool: &mut Pool, frame: &Frame, rank: usize) -> Answer<bool> {
    let n = frame.fields.states.len();
    if rank == n {
        return Answer::Known(true);
    }
    let unknown = |reason: &str| Answer::Unknown(reason.to_owned());
    let Some((a, b)) = matrices(pool, frame) else {
        return unknown("the linearisation has no numerical value: a parameter has none");
    };
    let scale = a.norm().max(f64::MIN_POSITIVE);
    let mut krylov = DMatrix::zeros(n, n * b.ncols());
    let mut block = b.clone();
    for k in 0..n {
        krylov.view_mut((0, k * b.ncols()), (n, b.ncols())).copy_from(&block);
        block = (&a / scale) * block;
    }
    // Columns of U beyond the rank span the orthogonal complement of the controllable subspace.
    let gram = &krylov * krylov.transpose();
    let eigen = gram.symmetric_eigen();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let rest = eigen.eigenvectors.select_columns(&order[rank..]);
    let quotient = rest.transpose() * &a * &rest;
    let k = quotient.nrows();
    // An eigenvalue of multiplicity k moves by the k-th root of a perturbation.
    let tolerance = 10.0 * scale * (n as f64 * f64::EPSILON).powf(1.0 / k as f64);
    let worst = quotient.complex_eigenvalues().iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max);
    if worst < -tolerance {
        Answer::Known(true)
    } else if worst > tolerance {
        Answer::Known(false)
    } else {
        unknown("the linearisation has an uncontrollable eigenvalue on, or too near, the imaginary axis")
    }
}

/// A and B as numbers; `None` if a symbol has no value or a value is not finite.
fn matrices(pool: &mut Pool, frame: &Frame) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let n = frame.fields.states.len();
    let mut roots: Vec<Expr> = pool.jacobian(&frame.fields.drift, &frame.fields.states).concat();
    roots.extend(frame.fields.controls.concat());
    // Twice, because coordinates of the point may be expressions of parameters.
    for _ in 0..2 {
        let at = frame.constants(pool, &roots);
        roots = pool.substitute_all(&roots, &at);
    }
    let tape = Tape::compile(pool, &[], &roots).ok()?;
    let mut values = vec![0.0; tape.n_outputs()];
    tape.eval(&[], &mut Vec::new(), &mut values);
    if !values.iter().all(|v| v.is_finite()) {
        return None;
    }
    let (a, b) = values.split_at(n * n);
    Some((DMatrix::from_row_slice(n, n, a), DMatrix::from_column_slice(n, b.len() / n, b)))
}
