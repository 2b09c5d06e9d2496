//! Levenberg–Marquardt iterations within limits (Nocedal and Wright 2006, Numerical Optimization, section 10.3).

use nalgebra::{DMatrix, DVector, Dyn, SVD};

use crate::operating::equations::Equations;

/// Iterations from one start.
const ITERATIONS: usize = 150;

/// Singular values below this part of the largest are taken for zero.
const RANK: f64 = 1e-9;

/// Relative accuracy of a solution.
const ACCURACY: f64 = 1e-11;

/// Where the iterations ended.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) z: DVector<f64>,
    /// Largest absolute value of f.
    pub(crate) residual: f64,
    /// Whether f vanishes to rounding.
    pub(crate) solved: bool,
    /// Rank of the Jacobian.
    pub(crate) rank: usize,
}

fn decomposed(j: DMatrix<f64>) -> Option<SVD<f64, Dyn, Dyn>> {
    let most = 500 * (j.nrows() + j.ncols());
    if !j.is_empty() && j.iter().all(|v| v.is_finite()) {
        SVD::try_new(j, true, true, f64::EPSILON, most)
    } else {
        None
    }
}

/// −(JᵀJ + μ)⁻¹ Jᵀ f, for μ = 0 the step of least norm.
fn step(svd: &SVD<f64, Dyn, Dyn>, f: &DVector<f64>, mu: f64) -> Option<DVector<f64>> {
    let (u, v) = (svd.u.as_ref()?, svd.v_t.as_ref()?);
    let largest = svd.singular_values.max();
    let mut along = u.transpose() * f;
    for (c, &s) in along.iter_mut().zip(svd.singular_values.iter()) {
        *c = if s > RANK * largest && s > 0.0 { -*c * s / (s * s + mu) } else { 0.0 };
    }
    Some(v.transpose() * along)
}

/// Whether |f_i| ≤ accuracy · (1 + Σ |J_ij| max(1, |z_j|)) for all i.
fn is_solved(f: &DVector<f64>, j: &DMatrix<f64>, z: &DVector<f64>) -> bool {
    (0..f.len()).all(|i| {
        let size: f64 = (0..z.len()).map(|k| j[(i, k)].abs() * z[k].abs().max(1.0)).sum();
        f[i].abs() <= ACCURACY * (1.0 + size)
    })
}

/// A solution of f(z) = 0 within the limits, from `start`; where it did not converge, the best point on the way.
pub(crate) fn solve(equations: &mut Equations, start: &DVector<f64>) -> Found {
    let mut z = equations.clamped(start);
    let mut f = equations.value(&z);
    let mut mu = 1e-3;
    for _ in 0..ITERATIONS {
        if !f.iter().all(|v| v.is_finite()) {
            break;
        }
        let mut j = equations.jacobian(&z);
        let Some(svd) = decomposed(j.clone()) else { break };
        let scale = svd.singular_values.iter().copied().fold(0.0, f64::max).powi(2);
        if f.norm() == 0.0 || scale == 0.0 {
            break;
        }
        // Variables at a limit that the step leaves stay where they are.
        let Some(first) = step(&svd, &f, 0.0) else { break };
        let blocked: Vec<usize> = (0..z.len())
            .filter(|&k| {
                let [low, high] = equations.limits[k];
                (z[k] <= low && first[k] < 0.0) || (z[k] >= high && first[k] > 0.0)
            })
            .collect();
        for &k in &blocked {
            j.column_mut(k).fill(0.0);
        }
        let Some(svd) = (if blocked.is_empty() { Some(svd) } else { decomposed(j) }) else { break };
        let mut moved = false;
        // The Newton step first, then shorter ones.
        for trial in 0..30 {
            let weight = if trial == 0 && mu <= 1e-3 { 0.0 } else { mu * scale };
            let Some(d) = step(&svd, &f, weight) else { break };
            let next = equations.clamped(&(&z + d));
            let value = equations.value(&next);
            if value.norm() < f.norm() {
                moved = (&next - &z).norm() > f64::EPSILON * (1.0 + z.norm());
                (z, f) = (next, value);
                mu = (mu * 0.2).max(1e-14);
                break;
            }
            mu = (mu * 4.0).min(1e12);
        }
        if !moved {
            break;
        }
    }
    found(equations, z)
}

fn found(equations: &mut Equations, z: DVector<f64>) -> Found {
    let f = equations.value(&z);
    let j = equations.jacobian(&z);
    let residual = if f.iter().any(|v| v.is_nan()) { f64::INFINITY } else { f.amax() };
    let solved = residual.is_finite() && j.iter().all(|v| v.is_finite()) && is_solved(&f, &j, &z);
    let rank = decomposed(j).map_or(0, |svd| {
        let largest = svd.singular_values.iter().copied().fold(0.0, f64::max);
        svd.singular_values.iter().filter(|s| **s > RANK * largest && **s > 0.0).count()
    });
    Found { z, residual, solved, rank }
}

/// Whether a solution with a Jacobian of lower rank than variables belongs to a set of solutions: another one lies in a
/// direction in which the equations do not change to first order. Else it is a multiple one.
pub(crate) fn is_one_of_a_set(equations: &mut Equations, solution: &Found) -> bool {
    let Some(svd) = decomposed(equations.jacobian(&solution.z)) else { return !solution.z.is_empty() };
    let Some(v) = svd.v_t.as_ref() else { return false };
    let largest = svd.singular_values.max();
    let length = 0.05 * (1.0 + solution.z.amax());
    (0..solution.z.len()).any(|k| {
        // A coordinate direction, without what changes the equations.
        let mut along = DVector::from_fn(solution.z.len(), |i, _| f64::from(i == k));
        for (row, s) in v.row_iter().zip(svd.singular_values.iter()) {
            if *s > RANK * largest {
                let row = row.transpose();
                along -= &row * row.dot(&along);
            }
        }
        let size = along.norm();
        if size < 1e-3 {
            return false;
        }
        let other = solve(equations, &(&solution.z + along * (length / size)));
        other.solved && (&other.z - &solution.z).norm() > 0.5 * length
    })
}

/// The solution near `z` that is nearest to `to`: Gauss–Newton steps onto the solutions, with steps along them toward `to`.
pub(crate) fn nearest(equations: &mut Equations, z: Found, to: &DVector<f64>) -> Found {
    let mut best = z;
    let mut length = 1.0;
    for _ in 0..ITERATIONS {
        let Some(svd) = decomposed(equations.jacobian(&best.z)) else { break };
        let Some(v) = svd.v_t.as_ref() else { break };
        let largest = svd.singular_values.max();
        let mut along = to - &best.z;
        for (k, s) in svd.singular_values.iter().enumerate() {
            if *s > RANK * largest {
                let row = v.row(k).transpose();
                along -= &row * row.dot(&along);
            }
        }
        if along.norm() <= 1e-12 * (1.0 + best.z.norm()) {
            break;
        }
        let next = solve(equations, &(&best.z + along * length));
        if next.solved && (&next.z - to).norm() < (&best.z - to).norm() {
            best = next;
        } else {
            length *= 0.5;
            if length < 1e-6 {
                break;
            }
        }
    }
    best
}
