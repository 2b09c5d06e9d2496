//! Eigenvalues of matrices of numbers with what rounding leaves open of them.

use bracketry_numerics::eigen::eigenvalues;
use bracketry_numerics::linear_equations::nearly_null_vector;
use nalgebra::{Complex, DMatrix};

/// Eigenvalues that rounding does not tell from each other.
pub(crate) struct Cluster {
    /// Real part of their mean; 0 where it is not told from 0.
    pub(crate) re: f64,
    /// Imaginary part of their mean.
    pub(crate) im: f64,
    /// Their number.
    pub(crate) count: usize,
    /// How far any of them may be from the mean.
    pub(crate) radius: f64,
}

/// How much more than its estimate an eigenvalue may move.
const CAUTION: f64 = 10.0;

/// The eigenvalues of M, whose entries are computed from numbers of size `source`; `None` where the QR algorithm does not converge.
///
/// To first order, a rounding E moves a simple eigenvalue by ‖E‖/|yᴴx|, with the left and right eigenvectors y and x (Wilkinson 1965, ch. 2).
/// Eigenvalues that move as far as they are apart are not told from a multiple one. None moves further than
/// ‖M‖^(1 − 1/k) ‖E‖^(1/k).
pub(crate) fn clusters(m: &DMatrix<f64>, source: f64) -> Option<Vec<Cluster>> {
    let found = eigenvalues(m)?;
    let k = m.nrows() as f64;
    let rounding = k * f64::EPSILON * source.max(m.norm()).max(f64::MIN_POSITIVE);
    let worst = rounding + m.norm().powf(1.0 - 1.0 / k) * rounding.powf(1.0 / k);
    let moves: Vec<f64> =
        found.iter().map(|&z| CAUTION * (rounding / overlap(m, z, rounding)).min(worst).max(rounding)).collect();
    let distance = |i: usize, j: usize| (found[i].0 - found[j].0).hypot(found[i].1 - found[j].1);
    let mut clusters: Vec<Vec<usize>> = Vec::new();
    for i in 0..found.len() {
        let near = |c: &Vec<usize>| c.iter().any(|&j| distance(i, j) <= moves[i] + moves[j]);
        let (linked, mut apart): (Vec<_>, Vec<_>) = clusters.into_iter().partition(near);
        apart.push(linked.into_iter().flatten().chain([i]).collect());
        clusters = apart;
    }
    let cluster = |c: &Vec<usize>| {
        let mean = |part: fn(&(f64, f64)) -> f64| c.iter().map(|&i| part(&found[i])).sum::<f64>() / c.len() as f64;
        let (re, im) = (mean(|z| z.0), mean(|z| z.1));
        let radius = c.iter().map(|&i| moves[i].max((found[i].0 - re).hypot(found[i].1 - im))).fold(0.0, f64::max);
        let tidy = |x: f64| if x.abs() <= radius { 0.0 } else { x };
        Cluster { re: tidy(re), im: tidy(im), count: c.len(), radius }
    };
    let mut list: Vec<Cluster> = clusters.iter().map(cluster).collect();
    list.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
    Some(list)
}

/// Whether all of these have negative real parts; `None` where rounding leaves that open.
pub(crate) fn decay(list: &[Cluster]) -> Option<bool> {
    if list.iter().any(|c| c.re > c.radius) {
        return Some(false);
    }
    list.iter().all(|c| c.re < -c.radius).then_some(true)
}

/// |yᴴx| of the unit eigenvectors for an eigenvalue, by inverse iteration; 0 where they are not found.
fn overlap(m: &DMatrix<f64>, z: (f64, f64), rounding: f64) -> f64 {
    let n = m.nrows();
    // Beside the eigenvalue, so that the matrix is not singular.
    let shift = Complex::new(z.0 + rounding, z.1 + 0.5 * rounding);
    let shifted =
        DMatrix::from_fn(n, n, |i, j| Complex::from(m[(i, j)]) - if i == j { shift } else { Complex::from(0.0) });
    let left = nearly_null_vector(shifted.adjoint());
    let right = nearly_null_vector(shifted);
    right.zip(left).map_or(0.0, |(x, y)| y.dotc(&x).norm())
}
