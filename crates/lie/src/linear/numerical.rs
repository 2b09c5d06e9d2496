//! Decompositions in floating point, with a bound on the iterations.

use nalgebra::{DMatrix, Dyn, SVD, Schur, SymmetricEigen};

/// Iterations of the QR algorithm for each row; it commonly takes two or three.
const ITERATIONS: usize = 100;

/// The eigenvalues, real and imaginary parts; `None` where the QR algorithm does not converge.
pub(crate) fn eigenvalues(a: &DMatrix<f64>) -> Option<Vec<(f64, f64)>> {
    if a.is_empty() {
        return Some(Vec::new());
    }
    // The deflation of small subdiagonal entries compares with the neighboring diagonal, which may be zero:
    // a shift by the size of the matrix gives it a scale. It costs no accuracy beyond rounding.
    let schur = |m: &DMatrix<f64>| Schur::try_new(m.clone(), f64::EPSILON, ITERATIONS * m.nrows());
    let values = |s: Schur<f64, nalgebra::Dyn>, shift: f64| -> Vec<(f64, f64)> {
        s.complex_eigenvalues().iter().map(|z| (z.re - shift, z.im)).collect()
    };
    if let Some(s) = schur(a) {
        return Some(values(s, 0.0));
    }
    let shift = a.norm();
    schur(&(a + DMatrix::identity(a.nrows(), a.nrows()) * shift)).map(|s| values(s, shift))
}

/// Eigenvalues and orthonormal eigenvectors of a symmetric matrix; `None` where the iteration does not converge.
pub(crate) fn symmetric_eigen(a: DMatrix<f64>) -> Option<SymmetricEigen<f64, Dyn>> {
    let iterations = ITERATIONS * a.nrows().max(1);
    SymmetricEigen::try_new(a, f64::EPSILON, iterations)
}

/// The singular value decomposition; `None` where the iteration does not converge.
pub(crate) fn svd(a: DMatrix<f64>) -> Option<SVD<f64, Dyn, Dyn>> {
    let iterations = ITERATIONS * a.nrows().max(a.ncols()).max(1);
    SVD::try_new(a, true, true, 5.0 * f64::EPSILON, iterations)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x0' = u, x_i' = x0 − x_i, on which the QR algorithm without a limit does not end.
    #[test]
    fn stars_and_complete_graphs_end() {
        for n in 2..30usize {
            let star = DMatrix::from_fn(n, n, |i, j| match (i, j) {
                (0, _) => 0.0,
                (i, j) if i == j => -1.0,
                (_, 0) => 1.0,
                _ => 0.0,
            });
            let complete = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 - n as f64 } else { 1.0 });
            for a in [star, complete] {
                if let Some(found) = eigenvalues(&a) {
                    let trace: f64 = found.iter().map(|z| z.0).sum();
                    assert!((trace - a.trace()).abs() <= 1e-9 * a.norm(), "{n}: {found:?}");
                }
            }
        }
    }
}
