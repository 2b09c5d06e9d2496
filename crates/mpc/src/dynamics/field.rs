//! The dynamics as the optimizer needs them: a field and its exact derivatives.

use crate::error::MpcError;
use bracketry_sim::NoRoot;

/// Dynamics x' = f(t, x, u) with exact derivatives; with [`Integrator::Map`](crate::Integrator::Map), x⁺ = f(t, x, u).
pub trait Dynamics: Send {
    /// Number of states n.
    fn states(&self) -> usize;
    /// Number of inputs m.
    fn inputs(&self) -> usize;
    /// dx = f(t, x, u).
    fn field(&mut self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64]);
    /// Places (i, j) of the entries of ∂f/∂(x, u) that can differ from zero, 0 ≤ i < n, 0 ≤ j < n + m.
    fn jacobian_pattern(&self) -> &[(usize, usize)];
    /// dx = f and the entries of ∂f/∂(x, u) in the order of [`Dynamics::jacobian_pattern`].
    fn field_and_jacobian(&mut self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64], jacobian: &mut [f64]);
    /// Prepares [`Dynamics::weighted_hessian`]; the places (i, j), i ≤ j < n + m, that the Hessian can occupy.
    ///
    /// # Errors
    /// [`MpcError::NoSecondDerivatives`] if there are none, which is the default.
    fn second_derivatives(&mut self) -> Result<Vec<(usize, usize)>, MpcError> {
        Err(MpcError::NoSecondDerivatives)
    }
    /// The entries of ∇²_(x, u) Σ w_i f_i(t, x, u) in the order of the places that [`Dynamics::second_derivatives`] returned,
    /// which has to be called first; else they are no numbers.
    fn weighted_hessian(&mut self, _t: f64, _x: &[f64], _u: &[f64], _weights: &[f64], hessian: &mut [f64]) {
        hessian.fill(f64::NAN);
    }
    /// Number of parameters that can be changed while the dynamics are in use.
    fn parameters(&self) -> usize {
        0
    }
    /// Sets these parameters, [`Dynamics::parameters`] of them.
    fn set_parameters(&mut self, _parameters: &[f64]) {}
    /// Whether the dynamics contain switching functions that are smoothed.
    fn is_smoothed(&self) -> bool {
        false
    }
    /// Whether some of these functions jump, as friction does; else they have kinks alone, as limits written with `min` and `max`.
    fn has_jumps(&self) -> bool {
        self.is_smoothed()
    }
    /// Sets the smoothing width; without effect on smooth dynamics.
    fn set_smoothing(&mut self, _width: f64) {}
    /// Time and cause of the last evaluation at which algebraic equations had no solution, since this was last asked; the values
    /// there are no numbers.
    fn take_failure(&mut self) -> Option<(f64, NoRoot)> {
        None
    }
    /// Speed, in 1/s, at which the smoothed dynamics relax onto a switching surface; 0 for smooth dynamics.
    fn relaxation_rate(&mut self, _t: f64, _x: &[f64], _u: &[f64]) -> f64 {
        0.0
    }
}

/// Dynamics given by a function that writes f and the dense Jacobian ∂f/∂(x, u), row by row.
///
/// ```
/// use bracketry_mpc::Dynamics;
/// use bracketry_mpc::dynamics::FieldDynamics;
/// let mut pendulum = FieldDynamics::new(2, 1, |_t, x, u, dx, jac| {
///     dx.copy_from_slice(&[x[1], u[0] - x[0].sin()]);
///     jac.copy_from_slice(&[0.0, 1.0, 0.0, -x[0].cos(), 0.0, 1.0]);
/// });
/// let mut dx = [0.0; 2];
/// pendulum.field(0.0, &[0.0, 2.0], &[3.0], &mut dx);
/// assert_eq!(dx, [2.0, 3.0]);
/// ```
pub struct FieldDynamics<F> {
    states: usize,
    inputs: usize,
    pattern: Vec<(usize, usize)>,
    scratch: Vec<f64>,
    function: F,
}

impl<F: FnMut(f64, &[f64], &[f64], &mut [f64], &mut [f64]) + Send> FieldDynamics<F> {
    /// Dynamics with `function(t, x, u, dx, jacobian)`; the Jacobian has n rows of n + m entries.
    pub fn new(states: usize, inputs: usize, function: F) -> Self {
        let columns = states + inputs;
        let pattern = (0..states * columns).map(|i| (i / columns, i % columns)).collect();
        Self { states, inputs, pattern, scratch: vec![0.0; states * columns], function }
    }
}

impl<F: FnMut(f64, &[f64], &[f64], &mut [f64], &mut [f64]) + Send> Dynamics for FieldDynamics<F> {
    fn states(&self) -> usize {
        self.states
    }
    fn inputs(&self) -> usize {
        self.inputs
    }
    fn field(&mut self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64]) {
        (self.function)(t, x, u, dx, &mut self.scratch);
    }
    fn jacobian_pattern(&self) -> &[(usize, usize)] {
        &self.pattern
    }
    fn field_and_jacobian(&mut self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64], jacobian: &mut [f64]) {
        (self.function)(t, x, u, dx, jacobian);
    }
}
