//! Nonlinear least squares.

use nalgebra::{DMatrix, DVector};

/// Step of the central differences; the parameters are of size 1 (logarithms, or scaled).
const DIFFERENCE: f64 = 1e-5;
/// Relative decrease of the sum of squares below which the fit has converged.
const CONVERGED: f64 = 1e-8;
/// Largest change of a parameter in a step.
const LONGEST: f64 = 2.0;

/// Where the iteration ended.
pub(super) struct Minimum {
    pub(super) parameters: DVector<f64>,
    /// Derivative of the residuals there.
    pub(super) jacobian: DMatrix<f64>,
    pub(super) iterations: usize,
    pub(super) converged: bool,
}

/// Minimizes `‖residuals(p)‖²` (Levenberg 1944, Marquardt 1963). `None` from `residuals` makes a step too long.
///
/// The fits of the crate `bracketry-diagnose` have an iteration of their own: they eliminate the initial states window by
/// window from the normal equations, and never form the Jacobian of all residuals that this one works on.
pub(super) fn minimize(
    residuals: impl Fn(&DVector<f64>) -> Option<DVector<f64>>,
    start: DVector<f64>,
    most_iterations: usize,
) -> Option<Minimum> {
    let mut p = start;
    let mut r = residuals(&p)?;
    let derivative = |p: &DVector<f64>| central_differences(|p| residuals(p).ok_or(()), p).ok();
    let mut jacobian = derivative(&p)?;
    let mut damping = 1e-3;
    for iteration in 0..most_iterations {
        let normal = jacobian.tr_mul(&jacobian);
        let gradient = jacobian.tr_mul(&r);
        let diagonal = normal.diagonal();
        let floor = 1e-12 * diagonal.max();
        let mut lowered = None;
        while damping < 1e12 {
            let mut damped = normal.clone();
            for i in 0..p.len() {
                damped[(i, i)] += damping * diagonal[i].max(floor) + f64::MIN_POSITIVE;
            }
            if let Some(factor) = damped.cholesky() {
                let mut step = -factor.solve(&gradient);
                let longest = step.amax();
                if longest > LONGEST {
                    step *= LONGEST / longest;
                }
                let next = &p + step;
                match residuals(&next) {
                    Some(moved) if moved.norm_squared() <= r.norm_squared() => {
                        lowered = Some((next, moved));
                        break;
                    }
                    _ => {}
                }
            }
            damping *= 4.0;
        }
        let Some((next, moved)) = lowered else {
            return Some(Minimum { parameters: p, jacobian, iterations: iteration, converged: true });
        };
        let decrease = r.norm_squared() - moved.norm_squared();
        let converged = decrease <= CONVERGED * r.norm_squared();
        (p, r) = (next, moved);
        jacobian = derivative(&p)?;
        damping = (damping * 0.2).max(1e-12);
        if converged {
            return Some(Minimum { parameters: p, jacobian, iterations: iteration + 1, converged });
        }
    }
    Some(Minimum { parameters: p, jacobian, iterations: most_iterations, converged: false })
}

/// Jacobian of a vector function at `p`, one column for each parameter.
pub(super) fn central_differences<E>(
    function: impl Fn(&DVector<f64>) -> Result<DVector<f64>, E>,
    p: &DVector<f64>,
) -> Result<DMatrix<f64>, E> {
    let columns = (0..p.len()).map(|j| {
        let at = |sign: f64| {
            let mut moved = p.clone();
            moved[j] += sign * DIFFERENCE;
            function(&moved)
        };
        Ok((at(1.0)? - at(-1.0)?) / (2.0 * DIFFERENCE))
    });
    Ok(DMatrix::from_columns(&columns.collect::<Result<Vec<_>, E>>()?))
}
