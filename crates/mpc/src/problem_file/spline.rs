//! Natural cubic splines through the rows of a table.

/// A twice continuously differentiable curve of cubic pieces through points, without curvature at its ends. Before the first point and
/// after the last one it keeps the value there.
///
/// Source: C. de Boor, A Practical Guide to Splines, ch. IV.
pub(super) struct CubicSpline {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the points.
    curvatures: Vec<f64>,
}

impl CubicSpline {
    /// The spline through `values[i]` at `times[i]`, which increase; at least one point.
    pub(super) fn new(times: Vec<f64>, values: Vec<f64>) -> Self {
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
    pub(super) fn derivative(&self, t: f64, order: u32) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::CubicSpline;

    /// The sine has no curvature at 0 and 2π, so that the error of the spline and of its derivatives falls as the powers of the step
    /// that theory states: 4, 3 and 2.
    #[test]
    fn the_spline_of_a_sine_converges_with_its_derivatives() {
        let error = |points: usize, order: u32| {
            let times: Vec<f64> = (0..=points).map(|k| std::f64::consts::TAU * k as f64 / points as f64).collect();
            let spline = CubicSpline::new(times.clone(), times.iter().map(|t| t.sin()).collect());
            let truth = |t: f64| [t.sin(), t.cos(), -t.sin()][order as usize];
            let at = (0..997).map(|k| std::f64::consts::TAU * f64::from(k) / 997.0);
            at.fold(0.0, |w: f64, t| w.max((spline.derivative(t, order) - truth(t)).abs()))
        };
        for (order, power) in [(0, 4.0), (1, 3.0), (2, 2.0)] {
            let found = (error(20, order) / error(80, order)).log(4.0);
            assert!((found - power).abs() < 0.3, "derivative {order}: {found}");
        }
    }

    /// A straight line stays one, whatever the steps, and one point is a constant.
    #[test]
    fn lines_are_reproduced_and_ends_hold() {
        let times = vec![0.0, 0.1, 0.5, 0.6, 2.0];
        let line = CubicSpline::new(times.clone(), times.iter().map(|t| 3.0 - 2.0 * t).collect());
        for t in [0.0, 0.05, 0.3, 0.55, 1.9] {
            assert!((line.derivative(t, 0) - (3.0 - 2.0 * t)).abs() < 1e-12);
            assert!((line.derivative(t, 1) + 2.0).abs() < 1e-12 && line.derivative(t, 2).abs() < 1e-12);
        }
        assert_eq!((line.derivative(-1.0, 0), line.derivative(5.0, 0), line.derivative(5.0, 1)), (3.0, -1.0, 0.0));
        let point = CubicSpline::new(vec![1.0], vec![7.0]);
        assert_eq!((point.derivative(0.0, 0), point.derivative(2.0, 0), point.derivative(1.0, 1)), (7.0, 7.0, 0.0));
    }
}
