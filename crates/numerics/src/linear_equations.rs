//! Linear equations and functions of matrices, compiled once for all crates.

use nalgebra::{Complex, DMatrix, DVector};

/// X with A X = B for a square A, by LU factorization with row pivoting; `None` where A is singular.
pub fn solve(a: DMatrix<f64>, b: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    a.lu().solve(b)
}

/// [`solve`] with one right-hand side.
pub fn solve_vector(a: DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    a.lu().solve(b)
}

/// exp A by scaling and squaring of a Padé approximant (Higham 2005).
pub fn exponential(a: &DMatrix<f64>) -> DMatrix<f64> {
    a.exp()
}

/// A unit vector that nearly solves A v = 0 for a nearly singular A, by three steps of inverse iteration; `None` where A is singular in
/// floating point, or the iteration leaves the finite numbers.
pub fn nearly_null_vector(a: DMatrix<Complex<f64>>) -> Option<DVector<Complex<f64>>> {
    let n = a.nrows();
    let factors = a.lu();
    // No direction of models is orthogonal to it by chance.
    let mut v = DVector::from_fn(n, |i, _| Complex::new(1.0 + (i as f64 * 0.618).fract(), (i as f64 * 0.414).fract()));
    for _ in 0..3 {
        v = factors.solve(&v)?;
        let size = v.norm();
        if !(size.is_finite() && size > 0.0) {
            return None;
        }
        v.unscale_mut(size);
    }
    Some(v)
}
