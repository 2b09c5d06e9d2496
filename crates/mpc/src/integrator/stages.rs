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
    /// ∇²(μ_qᵀ f) Z_q, w × w, and the rows of it that are not zero.
    product: Vec<f64>,
    rows: Vec<usize>,
}

/// Adds `factor` times `row` to `to`.
fn add(to: &mut [f64], factor: f64, row: &[f64]) {
    to.iter_mut().zip(row).for_each(|(t, r)| *t += factor * r);
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
        let Self { times, states, sensitivities, weights, entries, product, rows, .. } = self;
        entries.resize(pattern.len(), 0.0);
        product.resize(w * w, 0.0);
        rows.clear();
        rows.extend(pattern.iter().flat_map(|&(i, j)| [i, j]));
        rows.sort_unstable();
        rows.dedup();
        out.fill(0.0);
        for (q, &time) in times.iter().enumerate() {
            let (x, weights) = (&states[q * n..(q + 1) * n], &weights[q * n..(q + 1) * n]);
            dynamics.weighted_hessian(time, x, u, weights, entries);
            let block = &sensitivities[q * n * w..(q + 1) * n * w];
            // H Z first, then Zᵀ(H Z): a row of length w per second derivative instead of a block.
            for &i in &*rows {
                product[i * w..(i + 1) * w].fill(0.0);
            }
            let mut entry = |i: usize, j: usize, v: f64| {
                let to = &mut product[i * w..(i + 1) * w];
                if j < n { add(to, v, &block[j * w..(j + 1) * w]) } else { to[j] += v }
            };
            for (&(i, j), &v) in pattern.iter().zip(&*entries) {
                entry(i, j, v);
                if i != j {
                    entry(j, i, v);
                }
            }
            for &i in &*rows {
                let row = &product[i * w..(i + 1) * w];
                if i < n {
                    for (a, &z) in block[i * w..(i + 1) * w].iter().enumerate().filter(|(_, z)| **z != 0.0) {
                        add(&mut out[a * w + a..(a + 1) * w], z, &row[a..]);
                    }
                } else {
                    add(&mut out[i * w + i..(i + 1) * w], 1.0, &row[i..]);
                }
            }
        }
        for a in 0..w {
            for b in 0..a {
                out[a * w + b] = out[b * w + a];
            }
        }
    }
}
