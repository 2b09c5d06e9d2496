//! Linear systems by triangular factors, without allocation.

// Only what is inlined where the instructions are chosen is compiled for them.
#![allow(clippy::inline_always)]

use crate::rows::{combine, sum_of_products};
use pulp::Arch;

/// Triangular factors of a square matrix with row exchanges, in memory that is kept.
///
/// ```
/// use bracketry_numerics::dense::Lu;
/// let mut lu = Lu::default();
/// lu.matrix(2).copy_from_slice(&[0.0, 2.0, 1.0, 1.0]); // row by row
/// assert!(lu.factorize());
/// let mut b = [4.0, 3.0];
/// lu.solve(&mut b, 1);
/// assert_eq!(b, [1.0, 2.0]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Lu {
    size: usize,
    entries: Vec<f64>,
    exchanges: Vec<usize>,
}

impl Lu {
    /// The matrix to be filled in, row by row, before [`Lu::factorize`].
    pub fn matrix(&mut self, size: usize) -> &mut [f64] {
        self.size = size;
        self.entries.resize(size * size, 0.0);
        self.exchanges.resize(size, 0);
        &mut self.entries
    }

    /// Gaussian elimination with partial pivoting; false if the matrix is singular or has an entry that is no number.
    #[must_use]
    pub fn factorize(&mut self) -> bool {
        let n = self.size;
        let (entries, exchanges) = (&mut self.entries, &mut self.exchanges);
        Arch::new().dispatch(
            #[inline(always)]
            || {
                // Four columns at a time, and then what they do to the others.
                for first in (0..n).step_by(4) {
                    let end = (first + 4).min(n);
                    for k in first..end {
                        let size = |i: usize| entries[i * n + k].abs();
                        let pivot = (k + 1..n).fold(k, |p, i| if size(i) > size(p) { i } else { p });
                        let d = entries[pivot * n + k];
                        if d == 0.0 || !d.is_finite() {
                            return false;
                        }
                        exchanges[k] = pivot;
                        let (above, below) = entries.split_at_mut((k + 1) * n);
                        let row = &mut above[k * n..];
                        if pivot != k {
                            row.swap_with_slice(&mut below[(pivot - k - 1) * n..(pivot - k) * n]);
                        }
                        for other in below.chunks_exact_mut(n) {
                            let l = other[k] / d;
                            other[k] = l;
                            other[k + 1..end].iter_mut().zip(&row[k + 1..end]).for_each(|(a, b)| *a -= l * b);
                        }
                    }
                    let (panel, rest) = entries.split_at_mut(end * n);
                    let panel = &mut panel[first * n..];
                    for k in first + 1..end {
                        let (before, own) = panel.split_at_mut((k - first) * n);
                        let (left, right) = own[..n].split_at_mut(end);
                        combine(right, before, (n, end), k - first, |q| -left[first + q]);
                    }
                    for other in rest.chunks_exact_mut(n) {
                        let (left, right) = other.split_at_mut(end);
                        combine(right, panel, (n, end), end - first, |q| -left[first + q]);
                    }
                }
                true
            },
        )
    }

    /// Overwrites B, row by row with `columns` columns, by A⁻¹ B.
    pub fn solve(&self, b: &mut [f64], columns: usize) {
        let n = self.size;
        for k in 0..n {
            let p = self.exchanges[k];
            if p != k {
                let (low, high) = b.split_at_mut(p * columns);
                low[k * columns..(k + 1) * columns].swap_with_slice(&mut high[..columns]);
            }
        }
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for i in 0..n {
                    let row = &self.entries[i * n..i * n + i];
                    let (known, own) = b.split_at_mut(i * columns);
                    subtract(&mut own[..columns], known, row);
                }
                for i in (0..n).rev() {
                    let row = &self.entries[i * n..(i + 1) * n];
                    let (own, known) = b[i * columns..].split_at_mut(columns);
                    subtract(own, known, &row[i + 1..]);
                    for v in own {
                        *v /= row[i];
                    }
                }
            },
        );
    }

    /// Overwrites the vector b by A⁻ᵀ b.
    pub fn solve_transposed(&self, b: &mut [f64]) {
        let n = self.size;
        for i in 0..n {
            for k in 0..i {
                b[i] -= self.entries[k * n + i] * b[k];
            }
            b[i] /= self.entries[i * n + i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                b[i] -= self.entries[k * n + i] * b[k];
            }
        }
        for k in (0..n).rev() {
            b.swap(k, self.exchanges[k]);
        }
    }
}

/// A row of B less these multiples of the rows of `known`.
#[inline(always)]
fn subtract(own: &mut [f64], known: &[f64], factors: &[f64]) {
    match own {
        [v] => *v -= sum_of_products(factors, &known[..factors.len()]),
        own => combine(own, known, (own.len(), 0), factors.len(), |l| -factors[l]),
    }
}
