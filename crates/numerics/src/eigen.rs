//! Eigenvalues and singular values, with a bound on the iterations: without one, those of nalgebra do not end on every matrix.

use crate::singular_values::tall_svd;
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix, DVector, Dyn, SVD, Schur, SymmetricEigen};

/// Iterations of the QR algorithm for each row; it commonly takes two or three.
const ITERATIONS: usize = 100;

/// Entries beyond it are not balanced: their squares, or sums of them, may overflow.
const LARGEST_BALANCED: f64 = 1e150;

/// The eigenvalues, real and imaginary parts; `None` where the QR algorithm does not converge, or an entry is not a finite number.
pub fn eigenvalues(a: &DMatrix<f64>) -> Option<Vec<(f64, f64)>> {
    if a.is_empty() {
        return Some(Vec::new());
    }
    if !is_finite(a) {
        return None;
    }
    let mut a = a.clone();
    balance(&mut a);
    let a = &a;
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

/// Divides row i by unit i and multiplies column i by it, with powers of 2 as units, until rows and columns are alike in size (Parlett and
/// Reinsch 1969): rounding is relative to the norm, which large entries beside small ones would dominate. The eigenvalues stay. The units;
/// all are 1 where the squares of entries would overflow.
pub fn balance(a: &mut DMatrix<f64>) -> DVector<f64> {
    // The iteration ends for finite squares only.
    if a.is_empty() || !a.iter().all(|v| v.abs() < LARGEST_BALANCED) {
        return DVector::from_element(a.nrows(), 1.0);
    }
    balance_parlett_reinsch(a)
}

/// Eigenvalues and orthonormal eigenvectors of a symmetric matrix; `None` where the iteration does not converge, or an
/// entry is not a finite number.
pub fn symmetric_eigen(a: DMatrix<f64>) -> Option<SymmetricEigen<f64, Dyn>> {
    let iterations = ITERATIONS * a.nrows().max(1);
    is_finite(&a).then(|| SymmetricEigen::try_new(a, f64::EPSILON, iterations)).flatten()
}

/// The thin singular value decomposition, singular values in descending order; `None` where the matrix has no entries, one is not
/// a finite number, or the iteration does not converge.
pub fn svd(a: &DMatrix<f64>) -> Option<SVD<f64, Dyn, Dyn>> {
    if a.is_empty() || !is_finite(a) {
        return None;
    }
    if a.nrows() >= a.ncols() {
        return tall_svd(a);
    }
    let SVD { u, v_t, singular_values } = tall_svd(&a.transpose())?;
    Some(SVD { u: Some(v_t?.transpose()), v_t: Some(u?.transpose()), singular_values })
}

/// The smallest singular value of a matrix of complex numbers; `None` where it has no entries, one is not a finite number, or the
/// iteration does not converge.
pub fn smallest_singular_value(a: DMatrix<Complex<f64>>) -> Option<f64> {
    if a.is_empty() || !a.iter().all(|z| z.re.is_finite() && z.im.is_finite()) {
        return None;
    }
    let iterations = ITERATIONS * (a.nrows() + a.ncols());
    let svd = SVD::try_new(a, false, false, f64::EPSILON, iterations)?;
    Some(svd.singular_values.iter().copied().fold(f64::INFINITY, f64::min))
}

/// The pseudo-inverse, singular values of at most `cut` taken for zero; `None` where the iteration does not converge, or an
/// entry is not a finite number.
pub fn pseudo_inverse(a: &DMatrix<f64>, cut: f64) -> Option<DMatrix<f64>> {
    svd(a)?.pseudo_inverse(cut).ok()
}

fn is_finite(a: &DMatrix<f64>) -> bool {
    a.iter().all(|v| v.is_finite())
}
