//! Multiple shooting: the flow over every interval and its exact derivatives.
//!
//! The classical Runge–Kutta method of order 4 is differentiated as it stands, so the sensitivities are those of the numbers
//! it returns: S_{i+1} = S_i + h/6 (D_1 + 2 D_2 + 2 D_3 + D_4), D_j = A_j T_j + [0 B_j].

use crate::dynamics::Dynamics;
use crate::trajectory::Trajectory;

/// End states of every interval, and their derivatives.
#[derive(Clone, Debug, Default)]
pub struct Linearisation {
    /// F(x_k, u_k), N rows of n entries.
    pub end: Vec<f64>,
    /// ∂F/∂(x, u), N blocks of n rows of n + m entries.
    pub jacobian: Vec<f64>,
}

/// The integrator with its working memory.
pub(crate) struct Shooter {
    n: usize,
    m: usize,
    pattern: Vec<(usize, usize)>,
    /// Entries that the flow's derivative can have: the reflexive and transitive closure of the field's pattern.
    closure: Vec<bool>,
    /// Columns of the possible entries of each row.
    columns: Vec<Vec<usize>>,
    /// Positions of all possible entries.
    entries: Vec<usize>,
    stage: Vec<f64>,
    k: [Vec<f64>; 4],
    d: [Vec<f64>; 4],
    s: Vec<f64>,
    t: Vec<f64>,
    jac: Vec<f64>,
}

const FRACTION: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
const WEIGHT: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

impl Shooter {
    pub(crate) fn new(dynamics: &dyn Dynamics) -> Self {
        let (n, m) = (dynamics.states(), dynamics.inputs());
        let w = n + m;
        let pattern = dynamics.jacobian_pattern().to_vec();
        let mut closure = vec![false; n * w];
        for i in 0..n {
            closure[i * w + i] = true;
        }
        for &(i, j) in &pattern {
            closure[i * w + j] = true;
        }
        // Warshall: a path i → k → j makes the entry (i, j) possible.
        for k in 0..n {
            for i in 0..n {
                if closure[i * w + k] {
                    for j in 0..w {
                        closure[i * w + j] |= closure[k * w + j];
                    }
                }
            }
        }
        let columns = (0..n).map(|i| (0..w).filter(|j| closure[i * w + j]).collect()).collect();
        let entries = (0..n * w).filter(|&e| closure[e]).collect();
        let row = || vec![0.0; n];
        let block = || vec![0.0; n * w];
        Self {
            n,
            m,
            closure,
            columns,
            entries,
            stage: row(),
            k: [row(), row(), row(), row()],
            d: [block(), block(), block(), block()],
            s: block(),
            t: block(),
            jac: vec![0.0; pattern.len()],
            pattern,
        }
    }

    /// Which entries of ∂F/∂(x, u) can differ from zero, n rows of n + m.
    pub(crate) fn closure(&self) -> &[bool] {
        &self.closure
    }

    /// Advances `x` over `dt`.
    pub(crate) fn advance(
        &mut self,
        dynamics: &mut dyn Dynamics,
        t: f64,
        x: &mut [f64],
        u: &[f64],
        dt: f64,
        substeps: usize,
    ) {
        let h = dt / substeps as f64;
        for step in 0..substeps {
            let time = t + step as f64 * h;
            for q in 0..4 {
                let c = FRACTION[q] * h;
                for i in 0..self.n {
                    self.stage[i] = if q == 0 { x[i] } else { x[i] + c * self.k[q - 1][i] };
                }
                dynamics.field(time + c, &self.stage, u, &mut self.k[q]);
            }
            for i in 0..self.n {
                x[i] += h * (0..4).map(|q| WEIGHT[q] * self.k[q][i]).sum::<f64>();
            }
        }
    }

    /// As [`Shooter::advance`], and the derivative of the end state with respect to (x, u) into `jacobian`.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn advance_with_sensitivity(
        &mut self,
        dynamics: &mut dyn Dynamics,
        t: f64,
        x: &mut [f64],
        u: &[f64],
        dt: f64,
        substeps: usize,
        jacobian: &mut [f64],
    ) {
        let (n, w) = (self.n, self.n + self.m);
        let h = dt / substeps as f64;
        self.s.fill(0.0);
        for i in 0..n {
            self.s[i * w + i] = 1.0;
        }
        for step in 0..substeps {
            let time = t + step as f64 * h;
            for q in 0..4 {
                let c = FRACTION[q] * h;
                if q == 0 {
                    self.stage.copy_from_slice(x);
                    self.t.copy_from_slice(&self.s);
                } else {
                    for i in 0..n {
                        self.stage[i] = x[i] + c * self.k[q - 1][i];
                    }
                    for &e in &self.entries {
                        self.t[e] = self.s[e] + c * self.d[q - 1][e];
                    }
                }
                dynamics.field_and_jacobian(time + c, &self.stage, u, &mut self.k[q], &mut self.jac);
                let d = &mut self.d[q];
                for &e in &self.entries {
                    d[e] = 0.0;
                }
                for (&(i, j), &a) in self.pattern.iter().zip(&self.jac) {
                    if j >= n {
                        d[i * w + j] += a;
                    } else {
                        for &c in &self.columns[j] {
                            d[i * w + c] += a * self.t[j * w + c];
                        }
                    }
                }
            }
            for i in 0..n {
                x[i] += h * (0..4).map(|q| WEIGHT[q] * self.k[q][i]).sum::<f64>();
            }
            for &e in &self.entries {
                self.s[e] += h * (0..4).map(|q| WEIGHT[q] * self.d[q][e]).sum::<f64>();
            }
        }
        jacobian.copy_from_slice(&self.s);
    }

    /// Linearises every interval of the trajectory from `first` on.
    pub(crate) fn linearise(
        &mut self,
        dynamics: &mut dyn Dynamics,
        grid: Grid,
        trajectory: &Trajectory,
        intervals: std::ops::Range<usize>,
        out: &mut Linearisation,
    ) {
        let (n, w) = (self.n, self.n + self.m);
        out.end.resize(trajectory.steps() * n, 0.0);
        out.jacobian.resize(trajectory.steps() * n * w, 0.0);
        for k in intervals {
            let end = &mut out.end[k * n..(k + 1) * n];
            end.copy_from_slice(trajectory.x(k));
            let block = &mut out.jacobian[k * n * w..(k + 1) * n * w];
            let t = grid.t0 + k as f64 * grid.dt;
            self.advance_with_sensitivity(dynamics, t, end, trajectory.u(k), grid.dt, grid.substeps, block);
        }
    }

    /// End states only.
    pub(crate) fn end_states(
        &mut self,
        dynamics: &mut dyn Dynamics,
        grid: Grid,
        trajectory: &Trajectory,
        end: &mut Vec<f64>,
    ) {
        let n = self.n;
        end.resize(trajectory.steps() * n, 0.0);
        for (k, row) in end.chunks_exact_mut(n).enumerate() {
            row.copy_from_slice(trajectory.x(k));
            let t = grid.t0 + k as f64 * grid.dt;
            self.advance(dynamics, t, row, trajectory.u(k), grid.dt, grid.substeps);
        }
    }

    /// Replaces the states by those that follow from x_0 and the inputs.
    pub(crate) fn roll_out(&mut self, dynamics: &mut dyn Dynamics, grid: Grid, trajectory: &mut Trajectory) {
        for k in 0..trajectory.steps() {
            let mut x = trajectory.x(k).to_vec();
            let t = grid.t0 + k as f64 * grid.dt;
            self.advance(dynamics, t, &mut x, trajectory.u(k), grid.dt, grid.substeps);
            trajectory.x_mut(k + 1).copy_from_slice(&x);
        }
    }
}

/// Start time, interval and number of integration steps per interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    pub(crate) t0: f64,
    pub(crate) dt: f64,
    pub(crate) substeps: usize,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::dynamics::{FieldDynamics, SymbolicDynamics};
    use approx::assert_relative_eq;
    use bracketry_system::System;

    /// A system with friction, products of input and state, and time-free nonlinearity.
    fn oscillator() -> SymbolicDynamics {
        let text = r#"
            states = ["q", "v", "z"]
            inputs = ["a", "b"]
            dynamics = { q = "v", v = "-sin(q) - 0.7*sign(v)*(1 + z^2) + a", z = "b*v - z" }
        "#;
        let mut d = SymbolicDynamics::new(&System::parse("oscillator.toml", text).unwrap()).unwrap();
        d.set_smoothing(0.05);
        d
    }

    #[test]
    fn sensitivities_are_the_derivatives_of_the_flow() {
        let mut d = oscillator();
        let mut s = Shooter::new(&d);
        let (x, u) = ([0.3, 0.02, -0.4], [0.6, 1.5]);
        let mut flow = |x: &[f64], u: &[f64]| {
            let mut end = x.to_vec();
            s.advance(&mut d, 0.0, &mut end, u, 0.1, 5);
            end
        };
        let h = 1e-5;
        let mut expected = vec![0.0; 15];
        for j in 0..5 {
            let shifted = |by: f64| {
                let mut z = [x[0], x[1], x[2], u[0], u[1]];
                z[j] += by;
                z
            };
            let (plus, minus) = (shifted(h), shifted(-h));
            let (plus, minus) = (flow(&plus[..3], &plus[3..]), flow(&minus[..3], &minus[3..]));
            for i in 0..3 {
                expected[i * 5 + j] = (plus[i] - minus[i]) / (2.0 * h);
            }
        }
        let end = flow(&x, &u);
        let mut jacobian = vec![0.0; 15];
        let mut same = x.to_vec();
        let mut s = Shooter::new(&d);
        s.advance_with_sensitivity(&mut d, 0.0, &mut same, &u, 0.1, 5, &mut jacobian);
        assert_eq!(same, end);
        for (a, b) in jacobian.iter().zip(&expected) {
            assert_relative_eq!(a, b, epsilon = 1e-7, max_relative = 1e-6);
        }
        for (v, possible) in jacobian.iter().zip(s.closure()) {
            assert!(*possible || *v == 0.0, "an entry outside of the pattern");
        }
    }

    #[test]
    fn the_closure_of_a_chain_is_triangular() {
        // x1' = x2, x2' = u: everything depends on what comes later, nothing on what comes before.
        let text = r#"
            states = ["x1", "x2"]
            inputs = ["u"]
            dynamics = { x1 = "x2", x2 = "u" }
        "#;
        let d = SymbolicDynamics::new(&System::parse("chain.toml", text).unwrap()).unwrap();
        assert_eq!(Shooter::new(&d).closure(), [true, true, true, false, true, true]);
    }

    #[test]
    fn the_method_has_order_four() {
        let mut d = FieldDynamics::new(1, 1, |t, x, _u, dx, jac| {
            dx[0] = x[0] * t.cos();
            jac.copy_from_slice(&[t.cos(), 0.0]);
        });
        let mut s = Shooter::new(&d);
        let mut error = |steps| {
            let mut x = [1.0];
            s.advance(&mut d, 0.0, &mut x, &[0.0], 2.0, steps);
            (x[0] - 2f64.sin().exp()).abs()
        };
        let order = (error(20) / error(40)).log2();
        assert!((order - 4.0).abs() < 0.15, "{order}");
    }
}
