//! Linear algebra of a few unknowns, on arrays.

/// Cholesky factor of the leading `n × n` block of a symmetric matrix; absent if it is not positive definite.
pub(super) fn cholesky<const N: usize>(a: &[[f64; N]; N], n: usize) -> Option<[[f64; N]; N]> {
    let mut l = [[0.0; N]; N];
    for j in 0..n {
        for i in j..n {
            let mut sum = a[i][j];
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            if i == j {
                if !(sum > 0.0 && sum.is_finite()) {
                    return None;
                }
                l[j][j] = sum.sqrt();
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    Some(l)
}

/// Solves `L Lᵀ x = b` in the leading `n` unknowns; the others are zero.
pub(super) fn solve<const N: usize>(l: &[[f64; N]; N], b: &[f64; N], n: usize) -> [f64; N] {
    let mut x = [0.0; N];
    for i in 0..n {
        let mut sum = b[i];
        for k in 0..i {
            sum -= l[i][k] * x[k];
        }
        x[i] = sum / l[i][i];
    }
    for i in (0..n).rev() {
        let mut sum = x[i];
        for k in i + 1..n {
            sum -= l[k][i] * x[k];
        }
        x[i] = sum / l[i][i];
    }
    x
}

pub(super) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(super) fn times<const N: usize>(m: &[[f64; N]; N], v: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| dot(&m[i], v))
}

pub(super) fn scaled<const N: usize>(a: &[f64; N], factor: f64) -> [f64; N] {
    a.map(|a| factor * a)
}

/// `a + factor · b`.
pub(super) fn sum<const N: usize>(a: &[f64; N], factor: f64, b: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| a[i] + factor * b[i])
}

/// An orthonormal basis that grows vector by vector (Gram–Schmidt, twice for orthogonality to rounding).
#[derive(Debug, Clone)]
pub(super) struct Basis<const N: usize> {
    vectors: [[f64; N]; N],
    len: usize,
}

impl<const N: usize> Basis<N> {
    pub(super) fn new() -> Self {
        Self { vectors: [[0.0; N]; N], len: 0 }
    }

    pub(super) fn vectors(&self) -> &[[f64; N]] {
        &self.vectors[..self.len]
    }

    /// Adds the direction of `v` unless it lies in the span up to `tolerance · |v|`; whether it was added.
    pub(super) fn add(&mut self, v: &[f64; N], tolerance: f64) -> bool {
        let norm = dot(v, v).sqrt();
        if self.len == N || norm == 0.0 || !norm.is_finite() {
            return false;
        }
        let mut rest = scaled(v, 1.0 / norm);
        for _ in 0..2 {
            for known in &self.vectors[..self.len] {
                rest = sum(&rest, -dot(known, &rest), known);
            }
        }
        let left = dot(&rest, &rest).sqrt();
        if left <= tolerance {
            return false;
        }
        self.vectors[self.len] = scaled(&rest, 1.0 / left);
        self.len += 1;
        true
    }

    /// Basis of the orthogonal complement.
    pub(super) fn complement(&self) -> Self {
        let mut all = self.clone();
        let mut complement = Self::new();
        while all.len < N {
            // The unit vector farthest from the span is never nearly inside it.
            let mut best = ([0.0; N], 0.0);
            for i in 0..N {
                let outside = 1.0 - all.vectors().iter().map(|b| b[i] * b[i]).sum::<f64>();
                if outside > best.1 {
                    let mut unit = [0.0; N];
                    unit[i] = 1.0;
                    best = (unit, outside);
                }
            }
            if !all.add(&best.0, 1e-8) {
                break;
            }
            let newest = all.vectors[all.len - 1];
            complement.vectors[complement.len] = newest;
            complement.len += 1;
        }
        complement
    }
}
