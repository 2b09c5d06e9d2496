//! Linear systems by triangular factors, without allocation.

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
        for k in 0..n {
            let mut pivot = k;
            for i in k + 1..n {
                if self.entries[i * n + k].abs() > self.entries[pivot * n + k].abs() {
                    pivot = i;
                }
            }
            let d = self.entries[pivot * n + k];
            if d == 0.0 || !d.is_finite() {
                return false;
            }
            self.exchanges[k] = pivot;
            if pivot != k {
                for j in 0..n {
                    self.entries.swap(k * n + j, pivot * n + j);
                }
            }
            let (above, below) = self.entries.split_at_mut((k + 1) * n);
            let row = &above[k * n + k + 1..];
            for other in below.chunks_exact_mut(n) {
                let l = other[k] / d;
                other[k] = l;
                if l != 0.0 {
                    other[k + 1..].iter_mut().zip(row).for_each(|(a, b)| *a -= l * b);
                }
            }
        }
        true
    }

    /// Overwrites B, row by row with `columns` columns, by A⁻¹ B.
    pub fn solve(&self, b: &mut [f64], columns: usize) {
        let n = self.size;
        for k in 0..n {
            let p = self.exchanges[k];
            if p != k {
                for c in 0..columns {
                    b.swap(k * columns + c, p * columns + c);
                }
            }
        }
        for i in 0..n {
            for k in 0..i {
                self.subtract(b, columns, i, k);
            }
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                self.subtract(b, columns, i, k);
            }
            let d = self.entries[i * n + i];
            b[i * columns..(i + 1) * columns].iter_mut().for_each(|v| *v /= d);
        }
    }

    /// Row i of B less l_ik times row k.
    fn subtract(&self, b: &mut [f64], columns: usize, i: usize, k: usize) {
        let l = self.entries[i * self.size + k];
        if l != 0.0 {
            let (low, high) = b.split_at_mut(i.max(k) * columns);
            let (to, from) = if i > k {
                (&mut high[..columns], &low[k * columns..(k + 1) * columns])
            } else {
                (&mut low[i * columns..(i + 1) * columns], &high[..columns])
            };
            to.iter_mut().zip(from).for_each(|(a, b)| *a -= l * b);
        }
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
