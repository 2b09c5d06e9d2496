//! Whether friction can hold a load with everything at rest.

use super::points::FrictionPoints;
use super::small::{cholesky, dot, solve, sum};

/// Most Newton steps. On the boundary of what can be held the iterates grow by half each; 100 suffice to rounding.
const STEPS: usize = 100;
/// Balance of forces, relative to the load and 1.
const BALANCE: f64 = 1e-13;

/// What friction can do against a load.
pub(super) enum Statics<const N: usize> {
    /// It is held: `λ_i = c_i J_i y/sqrt(|J_i y|² + 1)` balance the load, `Σ J_iᵀ λ_i = load`, within their bounds.
    Held([f64; N]),
    /// It is not: the load does more work on the motion `y` than friction can dissipate.
    Slips([f64; N]),
}

/// Decides whether `Σ J_iᵀ λ_i = load` has a solution with `|λ_i| ≤ c_i`, by Newton's method on the convex function
/// `Σ c_i sqrt(|J_i y|² + 1) − load · y`: a stationary point gives forces inside their bounds, a `y` with
/// `load · y > Σ c_i |J_i y|` a motion that no such forces prevent (theorem of the alternative).
pub(super) fn statics<const N: usize>(points: &FrictionPoints<N>, load: &[f64; N]) -> (Statics<N>, usize) {
    let tolerance = BALANCE * (1.0 + dot(load, load).sqrt());
    let mut y = [0.0; N];
    let mut here = points.smoothed(&y, 1.0);
    for step in 0..STEPS {
        let slope = sum(&here.gradient, -1.0, load);
        if dot(&slope, &slope).sqrt() <= tolerance {
            return (Statics::Held(y), step);
        }
        if dot(load, &y) > points.dissipation(&y) * (1.0 + 1e-14) {
            return (Statics::Slips(y), step);
        }
        // Motions that no point feels have no curvature; a load on them shows at the first step.
        let mut hessian = here.hessian;
        let trace: f64 = (0..N).map(|i| hessian[i][i]).sum();
        for i in 0..N {
            hessian[i][i] += 1e-13 * trace + f64::MIN_POSITIVE;
        }
        let Some(factor) = cholesky(&hessian, N) else {
            return (Statics::Held(y), step);
        };
        let direction = solve(&factor, &slope, N).map(|d| -d);
        let decrease = dot(&slope, &direction);
        let value = here.value - dot(load, &y);
        let mut length = 1.0;
        loop {
            let trial = sum(&y, length, &direction);
            if dot(load, &trial) > points.dissipation(&trial) * (1.0 + 1e-14) {
                return (Statics::Slips(trial), step);
            }
            here = points.smoothed(&trial, 1.0);
            let slack = 4.0 * f64::EPSILON * value.abs();
            if here.value - dot(load, &trial) <= value + 1e-4 * length * decrease + slack || length < 1e-9 {
                y = trial;
                break;
            }
            length *= 0.5;
        }
    }
    (Statics::Held(y), STEPS)
}
