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

#[cfg(test)]
mod tests {
    use super::eliminate;

    /// Entries of a matrix by rows, from a linear congruence: nothing special about them.
    fn entries(count: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let next = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
        };
        std::iter::repeat_with(next).take(count).collect()
    }

    fn product(a: &[f64], x: &[f64], m: usize, q: usize) -> Vec<f64> {
        let entry = |r: usize, k: usize| (0..m).map(|c| a[r * m + c] * x[c * q + k]).sum();
        (0..m * q).map(|at| entry(at / q, at % q)).collect()
    }

    #[test]
    fn a_regular_matrix_gives_back_what_it_was_multiplied_with() {
        for m in 1..6 {
            let (a, x) = (entries(m * m, 7 + m as u64), entries(3 * m, 70 + m as u64));
            let mut rhs = product(&a, &x, m, 3);
            assert!(eliminate(&mut a.clone(), &mut rhs, m, 1e-12));
            assert!(rhs.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-9), "{m}");
        }
    }

    #[test]
    fn unknowns_that_move_nothing_are_zero_where_rows_repeat_others() {
        // Columns 1 and 3 are idle, rows 2 and 3 repeat rows 0 and 1 with factors.
        let small = [2.0, 1.0, -1.0, 3.0];
        let mut a = vec![0.0; 16];
        for (r, factor) in [1.0, 1.0, 0.5, -2.0].into_iter().enumerate() {
            a[r * 4] = factor * small[(r % 2) * 2];
            a[r * 4 + 2] = factor * small[(r % 2) * 2 + 1];
        }
        let x = [0.3, 0.0, -0.7, 0.0];
        let mut rhs = product(&a, &x, 4, 1);
        assert!(eliminate(&mut a.clone(), &mut rhs, 4, 1e-12));
        assert!(rhs.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-12), "{rhs:?}");
        let mut contradiction = product(&a, &x, 4, 1);
        contradiction[3] += 0.1;
        assert!(!eliminate(&mut a, &mut contradiction, 4, 1e-12));
    }

    #[test]
    fn a_matrix_of_lower_rank_without_idle_columns_is_refused() {
        let mut a = vec![1.0, 2.0, 2.0, 4.0];
        assert!(!eliminate(&mut a, &mut [1.0, 2.0], 2, 1e-12));
    }
}
