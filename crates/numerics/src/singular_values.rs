//! Singular values by rotations (Hestenes 1958; Demmel and Veselić 1992). Those of nalgebra are wrong for many matrices, mostly of
//! lower rank: the product of the factors is another matrix.

use nalgebra::{DMatrix, DVector, Dyn, SVD};

/// Rounds in which every pair of columns is rotated; it commonly takes five to ten.
const ROUNDS: usize = 60;

/// The thin decomposition of a matrix of finite numbers with at least as many rows as columns, singular values in descending order,
/// those below rounding zero. `None` where the rotations do not come to an end.
pub(crate) fn tall_svd(a: &DMatrix<f64>) -> Option<SVD<f64, Dyn, Dyn>> {
    let n = a.ncols();
    let size = if a.amax() > 0.0 { a.amax() } else { 1.0 };
    let (q, r) = (a / size).qr().unpack();
    // Rᵀ V = W has orthogonal columns at the end: A = Q R = (Q V) Wᵀ.
    let (mut w, mut v) = (r.transpose(), DMatrix::identity(n, n));
    let rounding = f64::EPSILON * w.norm();
    (0..ROUNDS).find(|_| !rotate_all(&mut w, &mut v, rounding))?;
    let length = |c: f64| if c > rounding { c } else { 0.0 };
    let lengths: Vec<f64> = w.column_iter().map(|c| length(c.norm())).collect();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| lengths[j].total_cmp(&lengths[i]));
    let singular_values = DVector::from_iterator(n, order.iter().map(|&j| lengths[j] * size));
    let rank = lengths.iter().filter(|l| **l > 0.0).count();
    let mut right = w.select_columns(&order);
    for (mut column, &j) in right.column_iter_mut().zip(&order[..rank]) {
        column /= lengths[j];
    }
    complete(&mut right, rank);
    Some(SVD { u: Some(q * v.select_columns(&order)), v_t: Some(right.transpose()), singular_values })
}

/// Makes the columns of each pair orthogonal in turn, unless one is no longer than `rounding`; whether a pair was not.
fn rotate_all(w: &mut DMatrix<f64>, v: &mut DMatrix<f64>, rounding: f64) -> bool {
    let n = w.ncols();
    let mut is_rotated = false;
    for i in 0..n {
        for j in i + 1..n {
            let (a, b) = (w.column(i).norm(), w.column(j).norm());
            let product = w.column(i).dot(&w.column(j));
            if a.min(b) <= rounding || product.abs() <= f64::EPSILON * n as f64 * a * b {
                continue;
            }
            let cotangent = (b - a) * (b + a) / (2.0 * product);
            let tangent = cotangent.signum() / (cotangent.abs() + (1.0 + cotangent * cotangent).sqrt());
            is_rotated = true;
            let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
            let sine = tangent * cosine;
            for m in [&mut *w, &mut *v] {
                for k in 0..n {
                    let (x, y) = (m[(k, i)], m[(k, j)]);
                    m[(k, i)] = cosine * x - sine * y;
                    m[(k, j)] = sine * x + cosine * y;
                }
            }
        }
    }
    is_rotated
}

/// Replaces the columns after the first `known`, which are orthonormal, so that all are.
fn complete(m: &mut DMatrix<f64>, known: usize) {
    for k in known..m.ncols() {
        let known = m.columns(0, k).into_owned();
        // The unit vector that is farthest from their span.
        let share = DVector::from_iterator(m.nrows(), known.row_iter().map(|row| row.norm_squared()));
        let mut column = DVector::zeros(m.nrows());
        column[share.imin()] = 1.0;
        for _ in 0..2 {
            column -= &known * known.tr_mul(&column);
        }
        m.set_column(k, &column.normalize());
    }
}
