//! Operating points by damped least squares within limits.

use bracketry_numerics::least_squares::{Damping, Factored, Problem, Settings, minimize};
use nalgebra::{DMatrix, DVector};

use crate::operating::equations::Equations;

/// Iterations from one start.
const ITERATIONS: usize = 150;

/// Singular values below this part of the largest are taken for zero.
const RANK: f64 = 1e-9;

/// Relative accuracy of a solution.
const ACCURACY: f64 = 1e-11;

/// The Newton step first, then shorter ones.
const DAMPING: Damping =
    Damping { value: 1e-3, least: 1e-14, most: 1e12, lower: 0.2, raise: 4.0, trials: 30, undamped: 1e-3 };

impl Problem for Equations {
    fn residual(&mut self, z: &DVector<f64>) -> Option<DVector<f64>> {
        Some(self.weighed_value(z))
    }

    fn jacobian(&mut self, z: &DVector<f64>, _: &DVector<f64>) -> Option<DMatrix<f64>> {
        Some(self.weighed_jacobian(z))
    }

    fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }
}

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

/// Whether |f_i| ≤ accuracy · (1 + Σ |J_ij| max(1, |z_j|)) for all i.
fn is_solved(f: &DVector<f64>, j: &DMatrix<f64>, z: &DVector<f64>) -> bool {
    (0..f.len()).all(|i| {
        let size: f64 = (0..z.len()).map(|k| j[(i, k)].abs() * z[k].abs().max(1.0)).sum();
        f[i].abs() <= ACCURACY * (1.0 + size)
    })
}

/// A solution of f(z) = 0 within the limits, from `start`; where it did not converge, the best point on the way.
pub(crate) fn solve(equations: &mut Equations, start: &DVector<f64>) -> Found {
    equations.weigh(start);
    let settings = Settings { damping: DAMPING, iterations: ITERATIONS, rank: RANK, ..Settings::default() };
    let found = minimize(equations, start, &settings);
    let z = found.map_or_else(|| equations.clamped(start.clone()), |minimum| minimum.at);
    judged(equations, z)
}

/// What is known of the end of iterations.
pub(crate) fn judged(equations: &mut Equations, z: DVector<f64>) -> Found {
    let f = equations.value(&z);
    let j = equations.jacobian(&z);
    let residual = if f.iter().any(|v| v.is_nan()) { f64::INFINITY } else { f.amax() };
    let solved = residual.is_finite() && j.iter().all(|v| v.is_finite()) && is_solved(&f, &j, &z);
    let rank = Factored::new(&equations.weighed_jacobian(&z), RANK).map_or(0, |factored| factored.rank());
    Found { z, residual, solved, rank }
}

/// Ends of iterations from beside a solution with a Jacobian of lower rank than variables, in directions in which the equations do not
/// change to first order. If one of them is a solution, it belongs to a set of solutions; else it is a multiple one.
pub(crate) fn neighbors(equations: &mut Equations, solution: &Found) -> Vec<Found> {
    let Some(factored) = Factored::new(&equations.weighed_jacobian(&solution.z), RANK) else { return Vec::new() };
    let length = 0.05 * (1.0 + solution.z.amax());
    let mut ends = Vec::new();
    for k in 0..solution.z.len() {
        // A coordinate direction, without what changes the equations.
        let coordinate = DVector::from_fn(solution.z.len(), |i, _| f64::from(i == k));
        let along = factored.onto_null_space(coordinate);
        let size = along.norm();
        if size < 1e-3 {
            continue;
        }
        let other = solve(equations, &(&solution.z + along * (length / size)));
        if other.solved && (&other.z - &solution.z).norm() > 0.5 * length {
            ends.push(other);
        }
    }
    ends
}

/// The solution near `z` that is nearest to `to`: Gauss–Newton steps onto the solutions, with steps along them toward `to`.
pub(crate) fn nearest(equations: &mut Equations, z: Found, to: &DVector<f64>) -> Found {
    let mut best = z;
    let mut length = 1.0;
    for _ in 0..ITERATIONS {
        let Some(factored) = Factored::new(&equations.weighed_jacobian(&best.z), RANK) else { break };
        let along = factored.onto_null_space(to - &best.z);
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
