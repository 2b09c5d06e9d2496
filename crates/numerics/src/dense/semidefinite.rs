//! The nearest positive semidefinite matrix, block by block, in memory that is kept.

/// Groups the indices 0 … size−1 that are linked by an off-diagonal entry.
pub fn components(size: usize, links: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut label: Vec<usize> = (0..size).collect();
    let mut changed = true;
    while changed {
        changed = false;
        for &(i, j) in links {
            let low = label[i].min(label[j]);
            changed |= label[i] != low || label[j] != low;
            label[i] = low;
            label[j] = low;
        }
    }
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); size];
    for (i, &l) in label.iter().enumerate() {
        groups[l].push(i);
    }
    groups.retain(|g| !g.is_empty());
    groups
}

/// Clips the negative eigenvalues of a symmetric matrix, given in full by rows, to zero; a positive semidefinite matrix stays
/// exactly as it is, and one with an entry that is not finite too. `scratch` grows to 2·size² entries.
pub fn clip_to_psd(h: &mut [f64], size: usize, scratch: &mut Vec<f64>) {
    if size == 1 {
        h[0] = h[0].max(0.0);
        return;
    }
    scratch.resize(2 * size * size, 0.0);
    let (a, v) = scratch.split_at_mut(size * size);
    a.copy_from_slice(h);
    if h.iter().any(|x| !x.is_finite()) || is_positive_definite(a, size) {
        return;
    }
    a.copy_from_slice(h);
    diagonalize(a, v, size);
    if (0..size).all(|i| a[i * size + i] >= 0.0) {
        return;
    }
    for i in 0..size {
        for j in 0..size {
            h[i * size + j] = (0..size).map(|k| v[i * size + k] * a[k * size + k].max(0.0) * v[j * size + k]).sum();
        }
    }
}

/// Whether a symmetric matrix of n rows, given by rows, has a Cholesky factor, which replaces its lower triangle.
#[must_use]
pub fn is_positive_definite(a: &mut [f64], n: usize) -> bool {
    for j in 0..n {
        let pivot = a[j * n + j] - (0..j).map(|k| a[j * n + k].powi(2)).sum::<f64>();
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let root = pivot.sqrt();
        a[j * n + j] = root;
        for i in j + 1..n {
            let dot: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
            a[i * n + j] = (a[i * n + j] - dot) / root;
        }
    }
    true
}

/// Largest number of sweeps of the Jacobi method; it converges quadratically after a few.
const SWEEPS: usize = 60;

/// The cyclic Jacobi method: leaves the eigenvalues on the diagonal of `a` and the eigenvectors in the columns of `v`.
fn diagonalize(a: &mut [f64], v: &mut [f64], n: usize) {
    v.fill(0.0);
    for i in 0..n {
        v[i * n + i] = 1.0;
    }
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                let (off, below, above) = (a[p * n + q], a[p * n + p], a[q * n + q]);
                if off.abs() <= f64::EPSILON * (below.abs() * above.abs()).sqrt() || off.abs() < f64::MIN_POSITIVE {
                    continue;
                }
                rotated = true;
                let theta = (above - below) / (2.0 * off);
                let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = tangent * cosine;
                for k in 0..n {
                    let (x, y) = (a[k * n + p], a[k * n + q]);
                    a[k * n + p] = cosine * x - sine * y;
                    a[k * n + q] = sine * x + cosine * y;
                }
                for k in 0..n {
                    let (x, y) = (a[p * n + k], a[q * n + k]);
                    a[p * n + k] = cosine * x - sine * y;
                    a[q * n + k] = sine * x + cosine * y;
                    let (x, y) = (v[k * n + p], v[k * n + q]);
                    v[k * n + p] = cosine * x - sine * y;
                    v[k * n + q] = sine * x + cosine * y;
                }
            }
        }
        if !rotated {
            return;
        }
    }
}
