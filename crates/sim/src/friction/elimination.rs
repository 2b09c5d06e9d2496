//! Gaussian elimination for signs that stick.

/// Rows that repeat others may contradict them by this part of the largest right-hand side: rounding.
const CONTRADICTION: f64 = 1e-9;

/// Solves `M X = R` in place: `matrix` holds the `m × m` entries of `M` and `rhs` the `m × q` of `R`, both by rows; `rhs` becomes `X`.
/// Rows are exchanged for the largest pivot.
///
/// An unknown whose column is zero moves nothing (the components of a direction of which the equations use another one only): it
/// is 0 in the solution, and as many rows must then repeat others. False if a pivot is not above `least` otherwise, if rows that
/// should repeat others contradict them, or if the solution is not finite.
pub(crate) fn eliminate(matrix: &mut [f64], rhs: &mut [f64], m: usize, least: f64) -> bool {
    if m == 0 {
        return true;
    }
    let q = rhs.len() / m;
    let size = rhs.iter().fold(0.0f64, |size, v| size.max(v.abs()));
    let mut rank = 0;
    for c in 0..m {
        if is_idle(matrix, m, c) {
            continue;
        }
        let largest = |&p: &usize, &q: &usize| matrix[p * m + c].abs().total_cmp(&matrix[q * m + c].abs());
        let pivot = (rank..m).max_by(largest).unwrap_or(rank);
        if !(matrix[pivot * m + c].abs() > least && matrix[pivot * m + c].is_finite()) {
            return false;
        }
        if pivot != rank {
            (0..m).for_each(|k| matrix.swap(rank * m + k, pivot * m + k));
            (0..q).for_each(|k| rhs.swap(rank * q + k, pivot * q + k));
        }
        for r in rank + 1..m {
            let factor = matrix[r * m + c] / matrix[rank * m + c];
            if factor != 0.0 {
                (c..m).for_each(|k| matrix[r * m + k] -= factor * matrix[rank * m + k]);
                (0..q).for_each(|k| rhs[r * q + k] -= factor * rhs[rank * q + k]);
            }
        }
        rank += 1;
    }
    if rhs[rank * q..].iter().any(|v| v.abs() > CONTRADICTION * size) {
        return false;
    }
    // From the last row of the triangle on; the solution of a column moves down to its own row, past those of idle ones.
    let mut row = rank;
    for c in (0..m).rev() {
        if is_idle(matrix, m, c) {
            rhs[c * q..(c + 1) * q].fill(0.0);
            continue;
        }
        row -= 1;
        for k in 0..q {
            let known: f64 = (c + 1..m).map(|d| matrix[row * m + d] * rhs[d * q + k]).sum();
            rhs[c * q + k] = (rhs[row * q + k] - known) / matrix[row * m + c];
        }
    }
    rhs.iter().all(|v| v.is_finite())
}

/// Whether a column is zero; elimination leaves it so.
pub(crate) fn is_idle(matrix: &[f64], m: usize, column: usize) -> bool {
    (0..m).all(|r| matrix[r * m + column] == 0.0)
}
