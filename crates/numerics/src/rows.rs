//! Products and factorizations of matrices that are stored by rows, for sizes of some dozen: multiples of rows are added to rows,
//! four at a time, with the vector instructions that the processor has.
//!
//! Every entry is computed in one order and without fused operations, so results are the same bits on every machine.

// Only what is inlined where the instructions are chosen is compiled for them.
#![allow(clippy::inline_always)]

use pulp::Arch;

/// A matrix within a slice: entry (i, j) stands at `i * row + j * column`.
#[derive(Clone, Copy)]
pub struct Strided<'a> {
    /// The entries.
    pub values: &'a [f64],
    /// Distance of rows.
    pub row: usize,
    /// Distance of columns.
    pub column: usize,
}

impl<'a> Strided<'a> {
    /// A matrix whose rows follow each other at this distance.
    pub fn new(values: &'a [f64], row: usize) -> Self {
        Self { values, row, column: 1 }
    }

    /// Its transpose.
    #[must_use]
    pub fn transposed(self) -> Self {
        Self { row: self.column, column: self.row, ..self }
    }

    #[inline(always)]
    fn at(self, i: usize, j: usize) -> f64 {
        self.values[i * self.row + j * self.column]
    }
}

/// to += Σ_l factor(l) · (row l of `rows`, from `first` on), for l < count.
#[inline(always)]
pub(crate) fn combine(
    to: &mut [f64],
    rows: &[f64],
    (stride, first): (usize, usize),
    count: usize,
    factor: impl Fn(usize) -> f64,
) {
    let length = to.len();
    let row = |l: usize| &rows[l * stride + first..][..length];
    let mut l = 0;
    while l + 4 <= count {
        let (a, b, c, d) = (factor(l), factor(l + 1), factor(l + 2), factor(l + 3));
        if a != 0.0 || b != 0.0 || c != 0.0 || d != 0.0 {
            let (ra, rb, rc, rd) = (row(l), row(l + 1), row(l + 2), row(l + 3));
            for i in 0..length {
                to[i] += (a * ra[i] + b * rb[i]) + (c * rc[i] + d * rd[i]);
            }
        }
        l += 4;
    }
    for l in l..count {
        let a = factor(l);
        if a != 0.0 {
            to.iter_mut().zip(row(l)).for_each(|(t, r)| *t += a * r);
        }
    }
}

/// C += A B: `rows` rows of `columns` entries from `column` on, in C and B, and `inner` columns of A.
///
/// # Panics
/// If a matrix has fewer entries.
pub fn add_product(
    c: &mut [f64],
    c_row: usize,
    a: Strided<'_>,
    (b, b_row): (&[f64], usize),
    (rows, inner): (usize, usize),
    columns: std::ops::Range<usize>,
) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for i in 0..rows {
                let to = &mut c[i * c_row + columns.start..i * c_row + columns.end];
                combine(to, b, (b_row, columns.start), inner, |l| a.at(i, l));
            }
        },
    );
}

/// Adds Aᵀ B, which is symmetric, to the upper triangle of C: `size` rows and columns, `inner` rows of A and B; all three at one distance of rows.
///
/// # Panics
/// If a matrix has fewer entries.
pub fn add_symmetric_product(c: &mut [f64], row: usize, a: &[f64], b: &[f64], (size, inner): (usize, usize)) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for i in 0..size {
                combine(&mut c[i * row + i..i * row + size], b, (row, i), inner, |l| a[l * row + i]);
            }
        },
    );
}

/// Adds Σ_l weight_l a_l a_lᵀ to the upper triangle of C, for rows a_l of `size` entries, both at one distance of rows; C from place `first` on.
///
/// # Panics
/// If a matrix has fewer entries.
pub fn add_weighted_squares(
    c: &mut [f64],
    row: usize,
    first: usize,
    (a, a_row): (&[f64], usize),
    size: usize,
    weights: &[f64],
) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for i in 0..size {
                let start = (first + i) * row + first;
                combine(&mut c[start + i..start + size], a, (a_row, i), weights.len(), |l| {
                    weights[l] * a[l * a_row + i]
                });
            }
        },
    );
}

/// Eliminates the first `pivots` of `size` variables from a symmetric matrix whose upper triangle is given by rows at the distance `row`:
/// their rows become L⁻¹ times what they were, with the Cholesky factor Lᵀ on them, the others what is left (the Schur complement). False where a pivot is not
/// above `smallest` times the diagonal entry that it is left of.
///
/// # Panics
/// If the matrix has fewer entries.
pub fn eliminate(m: &mut [f64], row: usize, (pivots, size): (usize, usize), smallest: f64) -> bool {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let mut first = 0;
            while first < pivots {
                let end = (first + 4).min(pivots);
                let (panel, rest) = m.split_at_mut((end * row).min(m.len()));
                let panel = &mut panel[first * row..];
                for p in first..end {
                    let (before, own) = panel.split_at_mut((p - first) * row);
                    let own = &mut own[..size];
                    let diagonal = own[p];
                    combine(&mut own[p..], before, (row, p), p - first, |l| -before[l * row + p]);
                    let pivot = own[p];
                    if pivot.is_nan() || pivot <= smallest * diagonal.abs() || pivot.is_infinite() {
                        return false;
                    }
                    let root = pivot.sqrt();
                    let inverse = 1.0 / root;
                    own[p..].iter_mut().for_each(|v| *v *= inverse);
                    own[p] = root;
                }
                for i in end..size {
                    let start = (i - end) * row;
                    combine(&mut rest[start + i..start + size], panel, (row, i), end - first, |l| -panel[l * row + i]);
                }
                first = end;
            }
            true
        },
    )
}

/// The sum of products, in four parts.
#[inline(always)]
pub(crate) fn sum_of_products(a: &[f64], b: &[f64]) -> f64 {
    let mut parts = [0.0; 4];
    let (quads, others) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = quads.remainder().iter().zip(others.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in quads.zip(others) {
        for i in 0..4 {
            parts[i] += a[i] * b[i];
        }
    }
    (parts[0] + parts[1]) + (parts[2] + parts[3]) + rest
}

/// The scalar product of two slices of one length.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    debug_assert_eq!(a.len(), b.len());
    Arch::new().dispatch(
        #[inline(always)]
        || sum_of_products(a, b),
    )
}

/// to += factor · row.
pub fn add_multiple(to: &mut [f64], factor: f64, row: &[f64]) {
    debug_assert_eq!(to.len(), row.len());
    Arch::new().dispatch(
        #[inline(always)]
        || to.iter_mut().zip(row).for_each(|(t, r)| *t += factor * r),
    );
}

/// y += C x for a symmetric matrix of which the upper triangle is given.
///
/// # Panics
/// If a slice is too short.
pub fn add_symmetric_times(y: &mut [f64], c: &[f64], row: usize, x: &[f64]) {
    let size = x.len();
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for i in 0..size {
                let upper = &c[i * row + i..i * row + size];
                y[i] += sum_of_products(upper, &x[i..]);
                let v = x[i];
                y[i + 1..size].iter_mut().zip(&upper[1..]).for_each(|(y, c)| *y += c * v);
            }
        },
    );
}
