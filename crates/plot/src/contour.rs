//! Lines of equal value through values on a grid.

/// The pieces of the line `value = level` by marching squares: in each square of four neighboring places the value is
/// taken to change linearly along the edges. Squares with a missing corner have no pieces.
pub(crate) fn contour(x: &[f64], y: &[f64], values: &[Vec<f64>], level: f64) -> Vec<[(f64, f64); 2]> {
    let mut pieces = Vec::new();
    for j in 1..y.len() {
        for i in 1..x.len() {
            // Around the square, starting at its lower left corner.
            let corners = [(i - 1, j - 1), (i, j - 1), (i, j), (i - 1, j)];
            let value = |k: usize| values[corners[k % 4].1][corners[k % 4].0];
            let place = |k: usize| (x[corners[k % 4].0], y[corners[k % 4].1]);
            if (0..4).any(|k| !value(k).is_finite()) {
                continue;
            }
            let above = |k: usize| value(k) >= level;
            let crossing = |k: usize| {
                let s = (level - value(k)) / (value(k + 1) - value(k));
                let (p, q) = (place(k), place(k + 1));
                (p.0 + s * (q.0 - p.0), p.1 + s * (q.1 - p.1))
            };
            let crossed: Vec<usize> = (0..4).filter(|k| above(*k) != above(k + 1)).collect();
            match crossed[..] {
                [a, b] => pieces.push([crossing(a), crossing(b)]),
                // A saddle: the mean decides which corners are connected.
                [_, _, _, _] => {
                    let high = (0..4).map(value).sum::<f64>() / 4.0 >= level;
                    let pairs = if high == above(0) { [(0, 1), (2, 3)] } else { [(3, 0), (1, 2)] };
                    pieces.extend(pairs.map(|(a, b)| [crossing(a), crossing(b)]));
                }
                _ => {}
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize, f: impl Fn(f64, f64) -> f64) -> (Vec<f64>, Vec<Vec<f64>>) {
        let x: Vec<f64> = (0..n).map(|k| -1.0 + 2.0 * k as f64 / (n - 1) as f64).collect();
        let values = x.iter().map(|y| x.iter().map(|x| f(*x, *y)).collect()).collect();
        (x, values)
    }

    #[test]
    fn the_contour_of_a_plane_is_a_straight_line_of_full_length() {
        let (x, values) = grid(7, |x, y| x + y);
        let pieces = contour(&x, &x, &values, 0.5);
        assert!(pieces.iter().flatten().all(|(x, y)| (x + y - 0.5).abs() < 1e-12));
        let length: f64 = pieces.iter().map(|[p, q]| (p.0 - q.0).hypot(p.1 - q.1)).sum();
        assert!((length - 1.5 * 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_contour_of_a_cone_is_a_circle() {
        let (x, values) = grid(101, f64::hypot);
        let length: f64 = contour(&x, &x, &values, 0.6).iter().map(|[p, q]| (p.0 - q.0).hypot(p.1 - q.1)).sum();
        assert!((length - std::f64::consts::TAU * 0.6).abs() < 2e-3);
    }

    #[test]
    fn a_saddle_has_two_lines_that_do_not_cross_and_a_gap_none() {
        let values = vec![vec![1.0, 0.0], vec![0.0, 1.0]];
        let pieces = contour(&[0.0, 1.0], &[0.0, 1.0], &values, 0.4);
        // The mean, 0.5, lies above: the low corners are cut off.
        let sums: Vec<f64> = pieces.iter().map(|[p, q]| (p.0 - p.1) + (q.0 - q.1)).collect();
        assert_eq!(pieces.len(), 2);
        assert!((sums[0] * sums[1]) < 0.0);
        let gap = vec![vec![1.0, f64::NAN], vec![0.0, 1.0]];
        assert!(contour(&[0.0, 1.0], &[0.0, 1.0], &gap, 0.4).is_empty());
    }
}
