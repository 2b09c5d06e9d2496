//! Small dense linear systems without allocation.

/// Triangular factors of a square matrix with row exchanges, in memory that is kept.
#[derive(Clone, Debug, Default)]
pub(crate) struct Factors {
    size: usize,
    lu: Vec<f64>,
    exchanges: Vec<usize>,
}

impl Factors {
    /// The matrix to be filled in, row by row, before [`Factors::factorize`].
    pub(crate) fn matrix(&mut self, size: usize) -> &mut [f64] {
        self.size = size;
        self.lu.resize(size * size, 0.0);
        self.exchanges.resize(size, 0);
        &mut self.lu
    }

    /// Gaussian elimination with partial pivoting; false if the matrix is singular or has an entry that is no number.
    pub(crate) fn factorize(&mut self) -> bool {
        let n = self.size;
        for k in 0..n {
            let mut pivot = k;
            for i in k + 1..n {
                if self.lu[i * n + k].abs() > self.lu[pivot * n + k].abs() {
                    pivot = i;
                }
            }
            let d = self.lu[pivot * n + k];
            if d == 0.0 || !d.is_finite() {
                return false;
            }
            self.exchanges[k] = pivot;
            if pivot != k {
                for j in 0..n {
                    self.lu.swap(k * n + j, pivot * n + j);
                }
            }
            let (above, below) = self.lu.split_at_mut((k + 1) * n);
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
    pub(crate) fn solve(&self, b: &mut [f64], columns: usize) {
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
            let d = self.lu[i * n + i];
            b[i * columns..(i + 1) * columns].iter_mut().for_each(|v| *v /= d);
        }
    }

    /// Row i of B less l_ik times row k.
    fn subtract(&self, b: &mut [f64], columns: usize, i: usize, k: usize) {
        let l = self.lu[i * self.size + k];
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
    pub(crate) fn solve_transposed(&self, b: &mut [f64]) {
        let n = self.size;
        for i in 0..n {
            for k in 0..i {
                b[i] -= self.lu[k * n + i] * b[k];
            }
            b[i] /= self.lu[i * n + i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                b[i] -= self.lu[k * n + i] * b[k];
            }
        }
        for k in (0..n).rev() {
            b.swap(k, self.exchanges[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn both_systems_are_solved() {
        let a = [0.0, 2.0, 1.0, 1.0, -1.0, 3.0, 4.0, 0.5, -2.0];
        let x = [1.0, -2.0, 0.5];
        let mut f = Factors::default();
        f.matrix(3).copy_from_slice(&a);
        assert!(f.factorize());
        let mut b: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[i * 3 + j] * x[j]).sum()).collect();
        let mut bt: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[j * 3 + i] * x[j]).sum()).collect();
        f.solve(&mut b, 1);
        f.solve_transposed(&mut bt);
        for i in 0..3 {
            assert_relative_eq!(b[i], x[i], epsilon = 1e-14);
            assert_relative_eq!(bt[i], x[i], epsilon = 1e-14);
        }
    }

    #[test]
    fn a_singular_matrix_is_noticed() {
        let mut f = Factors::default();
        f.matrix(2).copy_from_slice(&[1.0, 2.0, 2.0, 4.0]);
        assert!(!f.factorize());
    }
}
