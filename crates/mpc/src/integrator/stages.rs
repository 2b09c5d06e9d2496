//! Second derivatives of the flow of any Runge–Kutta method.
//!
//! The end state depends on (x, u) through the field at the stages X_q(x, u), and everything else in the method is linear.
//! With the adjoints μ_q of the field values, which a sweep from the end of the interval to its start gives,
//!
//! ```text
//! ∇² λᵀF(x, u) = Σ_q Z_qᵀ ∇²(μ_qᵀ f)(X_q, u) Z_q,    Z_q = [∂X_q/∂(x, u); 0 I]
//! ```

use crate::dynamics::Dynamics;

/// The stages of all steps over one interval, in order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stages {
    pub(super) times: Vec<f64>,
    /// X_q, rows of n.
    states: Vec<f64>,
    /// ∂X_q/∂(x, u), blocks of n rows of n + m.
    sensitivities: Vec<f64>,
    /// Entries of ∂f/∂(x, u).
    pub(super) jacobians: Vec<f64>,
    /// Adjoints μ_q, rows of n.
    pub(super) weights: Vec<f64>,
    entries: Vec<f64>,
}

impl Stages {
    pub(crate) fn clear(&mut self) {
        self.times.clear();
        self.states.clear();
        self.sensitivities.clear();
        self.jacobians.clear();
    }

    pub(super) fn push(&mut self, time: f64, x: &[f64], jacobian: &[f64], sensitivity: impl Iterator<Item = f64>) {
        self.times.push(time);
        self.states.extend_from_slice(x);
        self.jacobians.extend_from_slice(jacobian);
        self.sensitivities.extend(sensitivity);
    }

    /// Adds J_qᵀ μ_q, its part for the states, to `to`.
    pub(super) fn add_transposed(&self, pattern: &[(usize, usize)], stage: usize, to: &mut [f64]) {
        let n = to.len();
        let jacobian = &self.jacobians[stage * pattern.len()..(stage + 1) * pattern.len()];
        for (&(i, j), a) in pattern.iter().zip(jacobian) {
            if j < n {
                to[j] += a * self.weights[stage * n + i];
            }
        }
    }

    /// The Hessian from the adjoints; `pattern` holds the places of the field's second derivatives.
    pub(crate) fn hessian(
        &mut self,
        dynamics: &mut dyn Dynamics,
        u: &[f64],
        pattern: &[(usize, usize)],
        out: &mut [f64],
    ) {
        let n = dynamics.states();
        let w = n + u.len();
        out.fill(0.0);
        self.entries.resize(pattern.len(), 0.0);
        for (q, &time) in self.times.iter().enumerate() {
            let (x, weights) = (&self.states[q * n..(q + 1) * n], &self.weights[q * n..(q + 1) * n]);
            dynamics.weighted_hessian(time, x, u, weights, &mut self.entries);
            let block = &self.sensitivities[q * n * w..(q + 1) * n * w];
            let row = |i: usize, c: usize| if i < n { block[i * w + c] } else { f64::from(u8::from(i == c)) };
            for (&(i, j), &v) in pattern.iter().zip(&self.entries) {
                for a in (0..w).filter(|&a| row(i, a) != 0.0) {
                    let scaled = v * row(i, a);
                    for b in 0..w {
                        let product = scaled * row(j, b);
                        out[a * w + b] += product;
                        if i != j {
                            out[b * w + a] += product;
                        }
                    }
                }
            }
        }
    }
}
