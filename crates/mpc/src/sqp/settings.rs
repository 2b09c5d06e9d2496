//! Settings of the solver.

use crate::qp::QpSettings;
use bracketry_symbolic::StopFlag;
use serde::Serialize;

/// Second derivatives of the quadratic programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hessian {
    /// Those of Gauss and Newton first. Where the programs converge too slowly with them, or no step is acceptable, those of the
    /// Lagrangian, if the dynamics are smooth and have second derivatives; [`Solution::hessian`](super::Solution::hessian) says so.
    #[default]
    Automatic,
    /// Those of the cost, positive semidefinite: robust, converges linearly where multipliers and curvature of the dynamics are
    /// large.
    GaussNewton,
    /// Those of the Lagrangian, curvature of the dynamics included: quadratic convergence. Curvature is moved between grid points
    /// so that the program becomes convex with the same solution; where there is too little of it, as far from a solution, the
    /// Hessian is blended with that of Gauss and Newton.
    Exact,
}

/// Settings of [`Sqp`](super::Sqp).
#[derive(Clone, Debug, PartialEq)]
pub struct SqpSettings {
    /// Largest number of quadratic programs at one smoothing width.
    pub max_iterations: usize,
    /// The solution is accepted when a step promises less than this fraction of the merit.
    pub tolerance: f64,
    /// Largest defect, in units of the state scale, of an accepted solution.
    pub defect_tolerance: f64,
    /// Smoothing widths, from wide to narrow; ignored by smooth dynamics, and when empty the width set last is kept.
    pub smoothing: Vec<f64>,
    /// Largest number of programs at every width but the last.
    pub continuation_iterations: usize,
    /// Promised fraction of the merit below which the next width follows.
    pub continuation_tolerance: f64,
    /// Largest number of programs of an attempt of the filter method: smooth dynamics get up to two attempts, smoothed ones end with it where
    /// the guarded iteration does not converge. 0 leaves it out, and the guarded iteration takes its place.
    pub filter_iterations: usize,
    /// Whether the filter method solves a second program, with the curvature of dynamics and constraints on its right-hand
    /// side, where a whole step close to feasible points is not acceptable because of it (Maratos effect).
    pub second_order_correction: bool,
    /// Whether solutions for smooth dynamics start with the interior-point method, which needs second derivatives; `Hessian::GaussNewton` leaves it
    /// out, and so do second-order cones and move blocks.
    pub interior_point: bool,
    /// Proximal weight λ of the first program.
    pub proximal: f64,
    /// Smallest proximal weight; below it the term is left out.
    pub min_proximal: f64,
    /// Second derivatives of the quadratic programs.
    pub hessian: Hessian,
    /// Settings of the quadratic programs.
    pub qp: QpSettings,
    /// Once it is raised, the iteration ends with [`MpcError::Stopped`](crate::MpcError::Stopped).
    pub stop: StopFlag,
}

impl Default for SqpSettings {
    fn default() -> Self {
        Self {
            max_iterations: 100,
            tolerance: 1e-8,
            defect_tolerance: 1e-6,
            smoothing: Vec::new(),
            continuation_iterations: 25,
            continuation_tolerance: 0.05,
            filter_iterations: 100,
            second_order_correction: true,
            interior_point: true,
            proximal: 1.0,
            min_proximal: 1e-4,
            hessian: Hessian::default(),
            qp: QpSettings::default(),
            stop: StopFlag::default(),
        }
    }
}
