//! How well directions positively span a space.

use nalgebra::DMatrix;

/// The radius of the largest ball about 0 in the convex hull of some vectors; 0 if 0 is not inside.
///
/// The hull lies on one side of each of its facets, and every facet contains as many of the vectors as the space has dimensions.
/// The radius is the least distance of a supporting plane, which is that of a facet.
///
/// ```
/// use bracketry_steer::from_rest::margin;
/// let cross = [vec![1.0, 0.0], vec![-1.0, 0.0], vec![0.0, 1.0], vec![0.0, -1.0]];
/// assert!((margin(&cross) - 0.5f64.sqrt()).abs() < 1e-12);
/// assert_eq!(margin(&cross[..3]), 0.0);
/// ```
pub fn margin(vectors: &[Vec<f64>]) -> f64 {
    let Some(dimension) = vectors.first().map(Vec::len) else { return 0.0 };
    let support = |n: &[f64]| vectors.iter().map(|v| dot(v, n)).fold(f64::NEG_INFINITY, f64::max);
    let mut least = f64::INFINITY;
    let mut chosen: Vec<usize> = (0..dimension).collect();
    if vectors.len() < dimension {
        return 0.0;
    }
    loop {
        let normal = normal(&chosen.iter().map(|&k| vectors[k].as_slice()).collect::<Vec<_>>());
        let opposite: Vec<f64> = normal.iter().map(|x| -x).collect();
        least = least.min(support(&normal)).min(support(&opposite));
        if !advance(&mut chosen, vectors.len()) {
            return least.max(0.0);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A unit vector orthogonal to the differences of as many points as there are dimensions.
fn normal(points: &[&[f64]]) -> Vec<f64> {
    let d = points.len();
    let differences = DMatrix::from_fn(d, d, |i, j| if i + 1 < d { points[i + 1][j] - points[0][j] } else { 0.0 });
    let svd = differences.svd(false, true);
    let least = svd.singular_values.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(k, _)| k);
    svd.v_t.map_or_else(|| vec![0.0; d], |v| v.row(least).iter().copied().collect())
}

/// The next choice of increasing places below `n`; false after the last one.
fn advance(chosen: &mut [usize], n: usize) -> bool {
    let d = chosen.len();
    for i in (0..d).rev() {
        if chosen[i] < n - d + i {
            chosen[i] += 1;
            for j in i + 1..d {
                chosen[j] = chosen[j - 1] + 1;
            }
            return true;
        }
    }
    false
}
