//! Natural cubic splines through points.

/// A twice continuously differentiable curve of cubic pieces through points, without curvature at its ends. Before the first point and
/// after the last one it keeps the value there.
///
/// Source: de Boor 1978, ch. IV.
pub struct NaturalSpline {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the points.
    curvatures: Vec<f64>,
}

impl NaturalSpline {
    /// The spline through `values[i]` at `times[i]`, which increase; at least one point.
    pub fn new(times: Vec<f64>, values: Vec<f64>) -> Self {
        let n = times.len();
        let mut curvatures = vec![0.0; n];
        // The second derivatives m solve h₋ m₋ + 2 (h₋ + h) m + h m₊ = 6 (slope − slope₋), a tridiagonal system that is diagonally
        // dominant: elimination without pivots, then substitution.
        let step = |i: usize| times[i + 1] - times[i];
        let slope = |i: usize| (values[i + 1] - values[i]) / step(i);
        let (mut diagonal, mut right) = (vec![1.0; n], vec![0.0; n]);
        for i in 1..n.saturating_sub(1) {
            let before = if i == 1 { 0.0 } else { step(i - 1) / diagonal[i - 1] };
            diagonal[i] = 2.0 * (step(i - 1) + step(i)) - before * step(i - 1);
            right[i] = 6.0 * (slope(i) - slope(i - 1)) - before * right[i - 1];
        }
        for i in (1..n.saturating_sub(1)).rev() {
            curvatures[i] = (right[i] - step(i) * curvatures[i + 1]) / diagonal[i];
        }
        Self { times, values, curvatures }
    }

    /// The derivative of this order at a time, 0 for the value; at a point, that of the piece after it.
    pub fn derivative(&self, t: f64, order: u32) -> f64 {
        let after = self.times.partition_point(|at| *at <= t);
        if after == 0 || after == self.times.len() {
            let end = if after == 0 { self.values.first() } else { self.values.last() };
            return if order == 0 { end.copied().unwrap_or(0.0) } else { 0.0 };
        }
        let (i, j) = (after - 1, after);
        let h = self.times[j] - self.times[i];
        let (left, right) = (t - self.times[i], self.times[j] - t);
        let (a, b) = (self.curvatures[i], self.curvatures[j]);
        let (p, q) = (self.values[i] / h - a * h / 6.0, self.values[j] / h - b * h / 6.0);
        match order {
            0 => (a * right.powi(3) + b * left.powi(3)) / (6.0 * h) + p * right + q * left,
            1 => (b * left.powi(2) - a * right.powi(2)) / (2.0 * h) + q - p,
            2 => (a * right + b * left) / h,
            3 => (b - a) / h,
            _ => 0.0,
        }
    }
}
