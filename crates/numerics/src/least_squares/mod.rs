//! Nonlinear least squares with damped steps (Levenberg 1944, Marquardt 1963; Nocedal and Wright 2006, section 10.3).
//!
//! ```
//! use bracketry_numerics::least_squares::{Settings, Status, minimize};
//! use nalgebra::DVector;
//!
//! // Where the parabola y = x² meets the circle x² + y² = 2; the logarithm is not defined on the left.
//! let mut equations = |z: &DVector<f64>| {
//!     let (x, y) = (z[0], z[1]);
//!     (x > 0.0).then(|| DVector::from_vec(vec![y.ln() - 2.0 * x.ln(), x * x + y * y - 2.0]))
//! };
//! let found = minimize(&mut equations, &DVector::from_vec(vec![3.0, 0.1]), &Settings::default()).unwrap();
//! assert!((found.at - DVector::from_element(2, 1.0)).amax() < 1e-9);
//! assert_ne!(found.status, Status::IterationLimit);
//! ```

mod damping;
mod factored;

pub use damping::{Damping, Trial};
pub use factored::Factored;

use nalgebra::{DMatrix, DVector};

/// Step of the central differences where a problem has no derivative of its own, for variables of size 1.
const DIFFERENCE: f64 = 1e-5;

/// Least size of a column relative to the largest where columns are scaled.
const SMALLEST_COLUMN: f64 = 1e-6;

/// Residuals whose sum of squares is to be least. A function of the variables is one, with derivatives by central differences.
pub trait Problem {
    /// The residuals; `None` where they cannot be computed, which makes a step too long.
    fn residual(&mut self, at: &DVector<f64>) -> Option<DVector<f64>>;

    /// Their derivative at a point where they are `residual`, one column for each variable; `None` ends the iteration.
    fn jacobian(&mut self, at: &DVector<f64>, _residual: &DVector<f64>) -> Option<DMatrix<f64>> {
        central_differences(|moved| self.residual(moved).ok_or(()), at, DIFFERENCE).ok()
    }

    /// Least and greatest value of each variable; none for variables without limits.
    fn limits(&self) -> &[[f64; 2]] {
        &[]
    }

    /// The variables moved into their limits.
    fn clamped(&self, mut at: DVector<f64>) -> DVector<f64> {
        at.iter_mut().zip(self.limits()).for_each(|(v, [low, high])| *v = v.clamp(*low, *high));
        at
    }
}

impl<F: FnMut(&DVector<f64>) -> Option<DVector<f64>>> Problem for F {
    fn residual(&mut self, at: &DVector<f64>) -> Option<DVector<f64>> {
        self(at)
    }
}

/// Jacobian of a vector function at `at`, one column for each variable, of which there is at least one.
///
/// # Errors
/// What the function returns where it has no value.
pub fn central_differences<E>(
    mut function: impl FnMut(&DVector<f64>) -> Result<DVector<f64>, E>,
    at: &DVector<f64>,
    difference: f64,
) -> Result<DMatrix<f64>, E> {
    let columns = (0..at.len()).map(|j| {
        let mut beside = |sign: f64| {
            let mut moved = at.clone();
            moved[j] += sign * difference;
            function(&moved)
        };
        Ok((beside(1.0)? - beside(-1.0)?) / (2.0 * difference))
    });
    Ok(DMatrix::from_columns(&columns.collect::<Result<Vec<_>, E>>()?))
}

/// How [`minimize`] goes about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Damping of the steps, relative to the square of the largest singular value of the Jacobian.
    pub damping: Damping,
    /// Most steps.
    pub iterations: usize,
    /// Singular values up to this part of the largest are taken for zero.
    pub rank: f64,
    /// Whether each variable is damped by the size of its own column of the Jacobian instead (Marquardt 1963), so that units of the
    /// variables do not matter.
    pub scaled: bool,
    /// Largest change of a variable in a step.
    pub longest: f64,
    /// Largest residual that counts as zero.
    pub enough: f64,
    /// Relative decrease of the sum of squares up to which it has converged.
    pub settled: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            damping: Damping::default(),
            iterations: 100,
            rank: 0.0,
            scaled: false,
            longest: f64::INFINITY,
            enough: 0.0,
            settled: 0.0,
        }
    }
}

/// Where an iteration ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// The variables.
    pub at: DVector<f64>,
    /// The residuals there.
    pub residual: DVector<f64>,
    /// Steps that were taken.
    pub iterations: usize,
    /// Why it ended.
    pub status: Status,
}

/// Why an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The residuals are zero, do not depend on the variables, or do not fall any more.
    Converged,
    /// No step lowers the sum of squares: a minimum to rounding, or a kink.
    Stalled,
    /// The limit of steps came first.
    IterationLimit,
    /// The derivative cannot be computed or is not finite.
    NoDerivative,
}

/// Minimizes the sum of squares within the limits, from `start` moved into them. `None` where the residuals cannot be computed there.
pub fn minimize(problem: &mut impl Problem, start: &DVector<f64>, settings: &Settings) -> Option<Minimum> {
    let mut at = problem.clamped(start.clone());
    let mut residual = finite(problem, &at)?;
    let mut damping = settings.damping;
    let mut iterations = 0;
    let status = loop {
        if at.is_empty() || residual.amax() <= settings.enough {
            break Status::Converged;
        }
        if iterations == settings.iterations {
            break Status::IterationLimit;
        }
        let Some(jacobian) = problem.jacobian(&at, &residual) else { break Status::NoDerivative };
        if jacobian.iter().all(|v| *v == 0.0) {
            break Status::Converged;
        }
        let Some(steps) = Steps::new(jacobian, settings, &residual, &at, problem.limits()) else {
            break Status::NoDerivative;
        };
        let norm = residual.norm();
        let found = damping.search(|damping| {
            let next = problem.clamped(&at + steps.step(&residual, damping, settings.longest));
            match finite(problem, &next) {
                Some(moved) if moved.norm() < norm => Trial::Accepted((next, moved)),
                _ => Trial::Rejected,
            }
        });
        let Some((next, moved)) = found else { break Status::Stalled };
        iterations += 1;
        let is_settled = moved.norm_squared() >= (1.0 - settings.settled) * residual.norm_squared()
            || (&next - &at).norm() <= f64::EPSILON * (1.0 + at.norm());
        (at, residual) = (next, moved);
        if is_settled {
            break Status::Converged;
        }
    };
    Some(Minimum { at, residual, iterations, status })
}

/// The residuals where all are finite.
fn finite(problem: &mut impl Problem, at: &DVector<f64>) -> Option<DVector<f64>> {
    problem.residual(at).filter(|r| r.iter().all(|v| v.is_finite()))
}

/// The steps from a point, more or less damped.
struct Steps {
    /// The Jacobian by the variables in units of `sizes`.
    factored: Factored,
    sizes: DVector<f64>,
    /// What the damping is relative to.
    unit: f64,
}

impl Steps {
    fn new(
        jacobian: DMatrix<f64>,
        settings: &Settings,
        residual: &DVector<f64>,
        at: &DVector<f64>,
        limits: &[[f64; 2]],
    ) -> Option<Self> {
        let mut scaled = jacobian;
        let mut sizes = DVector::from_element(at.len(), 1.0);
        if settings.scaled {
            let norms = DVector::from_iterator(at.len(), scaled.column_iter().map(|c| c.norm()));
            let floor = SMALLEST_COLUMN * norms.max();
            sizes = norms.map(|n| 1.0 / n.max(floor));
            scaled.column_iter_mut().zip(&sizes).for_each(|(mut column, size)| column *= *size);
        }
        let factored = Factored::new(&scaled, settings.rank)?;
        let unit = if settings.scaled { 1.0 } else { factored.largest().powi(2) };
        let mut steps = Self { factored, sizes, unit };
        // Variables at a limit that the step leaves stay where they are.
        let first = steps.step(residual, 0.0, f64::INFINITY);
        let mut is_held = false;
        for (k, [low, high]) in limits.iter().enumerate() {
            if (at[k] <= *low && first[k] < 0.0) || (at[k] >= *high && first[k] > 0.0) {
                scaled.column_mut(k).fill(0.0);
                is_held = true;
            }
        }
        if is_held {
            steps.factored = Factored::new(&scaled, settings.rank)?;
        }
        Some(steps)
    }

    fn step(&self, residual: &DVector<f64>, damping: f64, longest: f64) -> DVector<f64> {
        let step = -self.factored.solve(residual, damping * self.unit).component_mul(&self.sizes);
        let length = step.amax();
        if length > longest { step * (longest / length) } else { step }
    }
}
