//! Points and weights for means over a footprint.

use std::f64::consts::TAU;

/// Points with weights, own axes: `∫ f dA / A ≈ Σ w f(r)`, exact up to second moments.
///
/// An ellipse is covered by rings at Gauss points of the radius (48 points are rings of 4, 12, 20 and 12), a rectangle by a grid of equal cells, stretched to the exact second moments, a polygon by triangles with
/// three points each at `(2/3, 1/6, 1/6)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadrature {
    /// Points in m.
    pub points: Vec<[f64; 2]>,
    /// Their weights, positive, of sum 1.
    pub weights: Vec<f64>,
}

impl Quadrature {
    fn equal(points: Vec<[f64; 2]>) -> Self {
        let weights = vec![1.0 / points.len() as f64; points.len()];
        Self { points, weights }
    }
}

/// Rings at the Gauss points for the weight `r`, so that means of `r^k` are exact for `k < 2n`, with points in proportion to
/// their weights. Each has a multiple of 4 points (2, or any, if the count is no such multiple): with 3 or more it is exact
/// for second moments, with a multiple of 4 it is its own mirror image about both axes.
pub(crate) fn ellipse(a: f64, b: f64, count: usize) -> Quadrature {
    let unit: usize = match count % 4 {
        0 => 4,
        2 => 2,
        _ => 1,
    };
    let least = unit.max(3).next_multiple_of(unit);
    // At least two rings for r², as far as there are points for them.
    let rings = ((count as f64 / 3.0).sqrt().round() as usize).max(2).clamp(1, count / least);
    let radii = if rings == 1 { vec![(0.5f64.sqrt(), 1.0)] } else { gauss_for_disk(rings) };
    let (mut points, mut weights) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut share, mut used) = (0.0, 0);
    for (ring, (radius, weight)) in radii.into_iter().enumerate() {
        share += weight;
        let up_to = (share * (count / unit) as f64).round() as usize * unit;
        let left = (rings - 1 - ring) * least;
        let end = if left == 0 { count } else { up_to.max(used + least).min(count - left) };
        let n = end - used;
        for i in 0..n {
            let (s, c) = (TAU * (i as f64 + 0.5) / n as f64).sin_cos();
            points.push([a * radius * c, b * radius * s]);
            weights.push(weight / n as f64);
        }
        used = end;
    }
    Quadrature { points, weights }
}

/// Gauss points and weights on `[0, 1]` for the weight `2 r`, by increasing radius: the zeros of the Jacobi polynomial
/// `P_n^(0,1)(2r − 1)`, found by Newton's method from those of lower degree.
fn gauss_for_disk(n: usize) -> Vec<(f64, f64)> {
    // P_n and its derivative at x by the recurrence in the degree (DLMF 18.9.2 with α = 0, β = 1).
    let jacobi = |x: f64| {
        let (mut before, mut here) = (1.0, 0.5 * (3.0 * x - 1.0));
        for k in 1..n {
            let k = k as f64;
            let next = ((2.0 * k + 2.0) * ((2.0 * k + 3.0) * (2.0 * k + 1.0) * x - 1.0) * here
                - 2.0 * k * (k + 1.0) * (2.0 * k + 3.0) * before)
                / (2.0 * (k + 1.0) * (k + 2.0) * (2.0 * k + 1.0));
            (before, here) = (here, next);
        }
        let n = n as f64;
        // DLMF 18.9.17
        let slope =
            n * ((-1.0 - (2.0 * n + 1.0) * x) * here + 2.0 * (n + 1.0) * before) / ((2.0 * n + 1.0) * (1.0 - x * x));
        (here, slope)
    };
    let mut zeros: Vec<(f64, f64)> = Vec::with_capacity(n);
    for i in 0..n {
        // Near the zeros of a Chebyshev polynomial; what is found already is divided out.
        let mut x = -(TAU * (2 * i + 1) as f64 / (8.0 * (n as f64 + 0.5))).cos();
        x = if i == 0 { x } else { x.max(zeros[i - 1].0 + 1e-3 / (n * n) as f64) };
        for _ in 0..100 {
            let (value, slope) = jacobi(x);
            let known: f64 = zeros.iter().map(|z| 1.0 / (x - z.0)).sum();
            let step = value / (slope - value * known);
            x = (x - step).clamp(-1.0 + 1e-12, 1.0 - 1e-12);
            if step.abs() < 1e-15 {
                break;
            }
        }
        zeros.push((x, jacobi(x).1));
    }
    // Weight ∝ 1/((1 − x²) P_n'(x)²).
    let mut rule: Vec<(f64, f64)> =
        zeros.iter().map(|(x, slope)| (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))).collect();
    rule.sort_by(|p, q| p.0.total_cmp(&q.0));
    let total: f64 = rule.iter().map(|(_, weight)| weight).sum();
    for (_, weight) in &mut rule {
        *weight /= total;
    }
    rule
}

/// The grid whose number of points is nearest to the count and whose cells are nearest to squares. The middle of `n` cells
/// has the second moment `(1 − 1/n²)/3`; stretched by `1/sqrt(1 − 1/n²)` the points stay inside.
pub(crate) fn rectangle(a: f64, b: f64, count: usize) -> Quadrature {
    let mut best = (f64::INFINITY, 2, 2);
    for n in 2..=(count / 2).max(2) {
        let m = ((count as f64 / n as f64).round() as usize).max(2);
        let missed = ((n * m) as f64 / count as f64).ln().abs();
        let oblong = (a * m as f64 / (b * n as f64)).ln().abs();
        if 4.0 * missed + oblong < best.0 {
            best = (4.0 * missed + oblong, n, m);
        }
    }
    let (_, n, m) = best;
    let line = |half: f64, n: usize| {
        let cells = n as f64;
        let stretch = half / (1.0 - 1.0 / (cells * cells)).sqrt();
        (0..n).map(move |i| stretch * ((2 * i + 1) as f64 / cells - 1.0))
    };
    Quadrature::equal(line(a, n).flat_map(|x| line(b, m).map(move |y| [x, y])).collect())
}

/// The triangles are halved across their longest sides, the largest first, until there are enough points.
pub(crate) fn triangles(mut triangles: Vec<[[f64; 2]; 3]>, count: usize) -> Quadrature {
    let double = |t: &[[f64; 2]; 3]| {
        ((t[1][0] - t[0][0]) * (t[2][1] - t[0][1]) - (t[1][1] - t[0][1]) * (t[2][0] - t[0][0])).abs()
    };
    let side = |t: &[[f64; 2]; 3], i: usize| {
        let (p, q) = (t[i], t[(i + 1) % 3]);
        (q[0] - p[0]).hypot(q[1] - p[1])
    };
    let longest = |t: &[[f64; 2]; 3]| (0..3).fold(0, |best, i| if side(t, i) > side(t, best) { i } else { best });
    while 3 * triangles.len() < count {
        // Long and large ones first; of equals the earliest, so that the result does not depend on chance.
        let size = |t: &[[f64; 2]; 3]| double(t) * side(t, longest(t));
        let largest =
            (0..triangles.len()).fold(0, |best, i| if size(&triangles[i]) > size(&triangles[best]) { i } else { best });
        let t = triangles[largest];
        let i = longest(&t);
        let (p, q, r) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
        let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        triangles[largest] = [p, middle, r];
        triangles.push([middle, q, r]);
    }
    let total: f64 = triangles.iter().map(double).sum();
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for t in &triangles {
        for i in 0..3 {
            let (p, q, r) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
            points.push([0, 1].map(|k| (4.0 * p[k] + q[k] + r[k]) / 6.0));
            weights.push(double(t) / total / 3.0);
        }
    }
    Quadrature { points, weights }
}
