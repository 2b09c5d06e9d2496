//! Whether compensation and process drive each other up.

use super::error::CompensationError;
use crate::error::check_finite;
use nalgebra::{Complex, Matrix6, Schur};

/// Iterations to the eigenvalues.
const MOST_ITERATIONS: usize = 1000;

/// Gains of the loop through the process: the tool moves, the wrench changes, the compensation moves the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stability {
    /// Spectral radius of process stiffness × compliance, `ρ(K_p C)`: how much of a displacement comes back through the
    /// process and the robot's own springs.
    pub process: f64,
    /// Spectral radius of `(1 + K_p C)⁻¹ K_p Ĉ`: how much of a correction comes back as the next one.
    pub compensation: f64,
    /// Whether the process holds the tool by itself, quasi-statically: `1 + λ` has a positive real part for every eigenvalue λ of
    /// `K_p C`.
    pub process_holds: bool,
}

impl Stability {
    /// No feedback: nothing comes back.
    pub(crate) const NONE: Self = Self { process: 0.0, compensation: 0.0, process_holds: true };

    /// The larger of each gain.
    pub(crate) fn worse(self, other: Self) -> Self {
        Self {
            process: self.process.max(other.process),
            compensation: self.compensation.max(other.compensation),
            process_holds: self.process_holds && other.process_holds,
        }
    }

    /// Whether both gains are below one and the process holds.
    ///
    /// A `compensation` below one is enough for any lag of the servo and any filter whose gain is at most one (generalized
    /// Nyquist criterion: every eigenvalue of the loop is one of `(1 + K_p C)⁻¹ K_p Ĉ` times the filter and the lag).
    pub fn holds(&self) -> bool {
        self.process_holds && self.process < 1.0 && self.compensation < 1.0
    }
}

/// Stability of compensation with a process of stiffness `K_p`, in base axes at the tool point: the wrench on the robot changes by
/// `−K_p ΔX` as the tool point moves. `compliance` C is the robot's, `modeled` Ĉ what the compensation believes.
///
/// # Errors
/// [`CompensationError`] for a matrix with an entry that is not finite, or whose eigenvalues do not settle.
pub fn stability(
    process: &Matrix6<f64>,
    compliance: &Matrix6<f64>,
    modeled: &Matrix6<f64>,
) -> Result<Stability, CompensationError> {
    for (what, matrix) in [("process stiffness", process), ("compliance", compliance), ("modeled compliance", modeled)]
    {
        check_finite(what, matrix)?;
    }
    let round = process * compliance;
    let returned = eigenvalues(&round)?;
    let process_holds = returned.iter().all(|e| 1.0 + e.re > 0.0);
    let fed_back = (Matrix6::identity() + round).lu().solve(&(process * modeled));
    let compensation = match fed_back {
        Some(matrix) => radius(&eigenvalues(&matrix)?),
        None => f64::INFINITY,
    };
    Ok(Stability { process: radius(&returned), compensation, process_holds })
}

fn eigenvalues(matrix: &Matrix6<f64>) -> Result<[Complex<f64>; 6], CompensationError> {
    let schur = Schur::try_new(*matrix, f64::EPSILON, MOST_ITERATIONS).ok_or(CompensationError::NoEigenvalues)?;
    Ok(schur.complex_eigenvalues().into())
}

fn radius(eigenvalues: &[Complex<f64>]) -> f64 {
    eigenvalues.iter().map(|e| e.norm()).fold(0.0, f64::max)
}
