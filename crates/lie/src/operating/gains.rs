//! Feedback and estimator gains of a linear system, and its Gramians.

use nalgebra::DMatrix;
use serde::Serialize;

use crate::operating::linear_model::rows;
use bracketry_numerics::linear_equations::exponential;
use bracketry_numerics::matrix_equations::{lyapunov, riccati};

/// Why there is no gain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum NoGain {
    /// The equation has no stabilizing solution, or none that rounding lets find.
    #[error("the Riccati equation has no stabilizing solution, or rounding hides it")]
    NoStabilizingSolution,
    /// There is no input, or no output.
    #[error("there is no input or no output")]
    Empty,
}

/// The optimal feedback u = −K x, or the gain L of the estimator x̂' = A x̂ + B u + L (y − C x̂ − D u).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gain {
    /// K (m × n) or L (n × p).
    #[serde(serialize_with = "rows")]
    pub gain: DMatrix<f64>,
    /// The solution of the Riccati equation: the cost xᵀ X x, or the covariance of the error.
    #[serde(serialize_with = "rows")]
    pub solution: DMatrix<f64>,
    /// Norm of the equation's left side, relative to that of its terms.
    pub residual: f64,
    /// Eigenvalues of A − B K or A − L C.
    pub poles: Vec<(f64, f64)>,
}

/// ∫ xᵀQx + uᵀRu is least for u = −K x, with diagonal Q and R.
///
/// # Errors
/// [`NoGain`] where there is none.
pub(crate) fn regulator(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &[f64], r: &[f64]) -> Result<Gain, NoGain> {
    if b.is_empty() {
        return Err(NoGain::Empty);
    }
    let diagonal = |list: &[f64]| DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(list));
    let found = riccati(a, b, &diagonal(q), &diagonal(r)).ok_or(NoGain::NoStabilizingSolution)?;
    let poles = bracketry_numerics::eigen::eigenvalues(&(a - b * &found.gain)).ok_or(NoGain::NoStabilizingSolution)?;
    Ok(Gain { gain: found.gain, solution: found.x, residual: found.residual, poles })
}

/// The dual: the steady Kalman filter for process noise Q and measurement noise R.
///
/// # Errors
/// [`NoGain`] where there is none.
pub(crate) fn estimator(a: &DMatrix<f64>, c: &DMatrix<f64>, q: &[f64], r: &[f64]) -> Result<Gain, NoGain> {
    let dual = regulator(&a.transpose(), &c.transpose(), q, r)?;
    Ok(Gain { gain: dual.gain.transpose(), ..dual })
}

/// ∫ e^{At} B Bᵀ e^{Aᵀt} dt and ∫ e^{Aᵀt} Cᵀ C e^{At} dt.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gramians {
    /// Upper end of the integrals; none for ∞.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizon: Option<f64>,
    /// n × n.
    #[serde(serialize_with = "rows")]
    pub controllability: DMatrix<f64>,
    /// n × n.
    #[serde(serialize_with = "rows")]
    pub observability: DMatrix<f64>,
}

/// Over all time for a stable system; else, and where a horizon is given, over a finite time.
pub(crate) fn gramians(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    c: &DMatrix<f64>,
    poles: &[(f64, f64)],
    horizon: Option<f64>,
) -> Option<Gramians> {
    let (bb, cc) = (b * b.transpose(), c.transpose() * c);
    if horizon.is_none() && poles.iter().all(|z| z.0 < 0.0) {
        let (controllability, observability) = (lyapunov(a, &bb)?, lyapunov(&a.transpose(), &cc)?);
        return Some(Gramians { horizon: None, controllability, observability });
    }
    // Ten time constants of the fastest growth, at most one unit of time, keep the numbers moderate.
    let fastest = poles.iter().fold(0.0, |m: f64, z| m.max(z.0.abs()));
    let time = horizon.unwrap_or(if fastest > 10.0 { 10.0 / fastest } else { 1.0 });
    let (controllability, observability) = (finite(a, &bb, time)?, finite(&a.transpose(), &cc, time)?);
    Some(Gramians { horizon: Some(time), controllability, observability })
}

/// ∫₀ᵀ e^{At} Q e^{Aᵀt} dt from the exponential of a block matrix (Van Loan 1978).
fn finite(a: &DMatrix<f64>, q: &DMatrix<f64>, time: f64) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let mut block = DMatrix::zeros(2 * n, 2 * n);
    block.view_mut((0, 0), (n, n)).copy_from(&-a);
    block.view_mut((0, n), (n, n)).copy_from(q);
    block.view_mut((n, n), (n, n)).copy_from(&a.transpose());
    let e = exponential(&(block * time));
    let w = e.view((n, n), (n, n)).transpose() * e.view((0, n), (n, n));
    let w = (&w + w.transpose()) * 0.5;
    w.iter().all(|v| v.is_finite()).then_some(w)
}
