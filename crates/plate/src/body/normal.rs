//! Normal impulses on unilateral contact points.

use nalgebra::{Matrix6, Vector6};

/// Stiffness of the regularization against the mass of the body.
const STIFFNESS: f64 = 1e6;
/// Most rounds of the method of multipliers.
const ROUNDS: usize = 60;
/// Violation of the conditions at which it ends, relative to the velocities at work.
const TOLERANCE: f64 = 1e-14;

/// Solves `M (v − v*) = Σ λ_k n_k` with `0 ≤ λ_k ⊥ n_k·v − b_k ≥ 0`.
///
/// The velocity is the projection of `v*` onto `{n_k·v ≥ b_k}` in the metric `M`. Where more points touch than the rigid
/// body can tell apart, the impulses are those of least norm `Σ λ_k²/w_k`: the problem is solved by the proximal method of multipliers
/// started at `λ = 0` (Rockafellar 1976), whose inner problems, piecewise quadratic in the six velocities, Newton's method
/// with a line search solves in finitely many steps.
///
/// Returns the velocity and the violation of the conditions that is left, relative to the velocities at work; the impulses go into
/// `impulses`.
pub(super) fn normal_impulses(
    mass: &Matrix6<f64>,
    free: &Vector6<f64>,
    normals: &[Vector6<f64>],
    targets: &[f64],
    weights: &[f64],
    impulses: &mut Vec<f64>,
) -> (Vector6<f64>, f64) {
    impulses.clear();
    impulses.resize(normals.len(), 0.0);
    let scale = free.amax().max(targets.iter().fold(0.0, |a: f64, b| a.max(b.abs())));
    let mut v = *free;
    if scale == 0.0 {
        return (v, 0.0);
    }
    let mut left = f64::INFINITY;
    for _ in 0..ROUNDS {
        v = inner(mass, free, normals, targets, weights, impulses, v);
        let mut violation = 0.0_f64;
        for (((n, b), w), impulse) in normals.iter().zip(targets).zip(weights).zip(impulses.iter_mut()) {
            let next = (*impulse + STIFFNESS * w * (b - n.dot(&v))).max(0.0);
            violation = violation.max((next - *impulse).abs() / (STIFFNESS * w));
            *impulse = next;
        }
        left = violation / scale;
        if left <= TOLERANCE {
            break;
        }
    }
    (v, left)
}

/// Minimizes `½ |v − v*|²_M + Σ max(0, λ_k + κ_k (b_k − n_k·v))²/(2κ_k)` from `start`.
fn inner(
    mass: &Matrix6<f64>,
    free: &Vector6<f64>,
    normals: &[Vector6<f64>],
    targets: &[f64],
    weights: &[f64],
    impulses: &[f64],
    start: Vector6<f64>,
) -> Vector6<f64> {
    let mut v = start;
    let pushes = |v: &Vector6<f64>| {
        let v = *v;
        normals
            .iter()
            .zip(targets)
            .zip(weights)
            .zip(impulses)
            .map(move |(((n, b), w), l)| (n, STIFFNESS * w, l + STIFFNESS * w * (b - n.dot(&v))))
            .filter(|(_, _, push)| *push > 0.0)
    };
    let value = |v: &Vector6<f64>| {
        let d = v - free;
        0.5 * d.dot(&(mass * d)) + 0.5 * pushes(v).map(|(_, k, p)| p * p / k).sum::<f64>()
    };
    let mut now = value(&v);
    for _ in 0..50 {
        let mut gradient = mass * (v - free);
        let mut hessian = *mass;
        for (n, stiffness, push) in pushes(&v) {
            gradient -= n * push;
            hessian.ger(stiffness, n, n, 1.0);
        }
        let Some(factor) = hessian.cholesky() else { return v };
        let step = -factor.solve(&gradient);
        let decrease = gradient.dot(&step);
        let mut length = 1.0;
        let mut next = v + step;
        let mut then = value(&next);
        while then > now + 1e-4 * length * decrease && length > 1e-6 {
            length *= 0.5;
            next = v + step * length;
            then = value(&next);
        }
        if then >= now {
            // Down to rounding: the full step is the better one if it is small.
            return if step.amax() <= 1e-10 * v.amax().max(free.amax()) { v + step } else { v };
        }
        (v, now) = (next, then);
    }
    v
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn normal(x: f64, y: f64) -> Vector6<f64> {
        Vector6::new(0.0, 0.0, 1.0, y, -x, 0.0)
    }

    fn mass() -> Matrix6<f64> {
        Matrix6::from_diagonal(&Vector6::new(1.0, 1.0, 1.0, 0.3, 0.2, 0.4))
    }

    #[test]
    fn a_square_that_falls_flat_is_held_by_equal_impulses_at_its_corners() {
        let normals = [normal(1.0, 1.0), normal(-1.0, 1.0), normal(-1.0, -1.0), normal(1.0, -1.0)];
        let free = Vector6::new(0.3, 0.0, -2.0, 0.0, 0.0, 1.0);
        let mut impulses = Vec::new();
        let (v, left) = normal_impulses(&mass(), &free, &normals, &[0.0; 4], &[1.0; 4], &mut impulses);
        assert!(left <= TOLERANCE && (v - Vector6::new(0.3, 0.0, 0.0, 0.0, 0.0, 1.0)).amax() < 1e-13);
        for impulse in impulses {
            assert!((impulse - 0.5).abs() < 1e-12);
        }
    }

    #[test]
    fn impulses_push_only_where_the_points_do_not_part() {
        let normals: Vec<_> = (0..12).map(|k| f64::from(k) * 0.7).map(|a| normal(a.cos(), 0.5 * a.sin())).collect();
        let free = Vector6::new(0.0, 0.0, -1.0, 2.0, -3.0, 0.5);
        let mut impulses = Vec::new();
        let (v, left) = normal_impulses(&mass(), &free, &normals, &[0.0; 12], &[1.0; 12], &mut impulses);
        assert!(left <= TOLERANCE);
        let mut sum = mass() * (v - free);
        for (n, impulse) in normals.iter().zip(&impulses) {
            let speed = n.dot(&v);
            assert!(speed > -1e-12 && *impulse >= 0.0 && (speed * impulse).abs() < 1e-11);
            sum -= n * *impulse;
        }
        assert!(sum.amax() < 1e-11);
    }
}
