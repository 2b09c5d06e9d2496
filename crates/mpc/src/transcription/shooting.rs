//! Multiple shooting: the flow over every interval and its exact derivatives.

use crate::dynamics::Dynamics;
use crate::integrator::{
    Collocation, Differentiated, ExplicitRungeKutta, Integrator, Interval, OneStepMethod, Stages, Tableau,
};
use crate::trajectory::Trajectory;

/// End states of every interval, and their derivatives.
#[derive(Clone, Debug, Default)]
pub struct Linearization {
    /// F(x_k, u_k), N rows of n entries.
    pub end: Vec<f64>,
    /// ∂F/∂(x, u), N blocks of n rows of n + m entries.
    pub jacobian: Vec<f64>,
    /// Second derivatives ∇²_(x, u) λ_kᵀF of the Lagrangian's dynamics, N blocks of n + m rows of n + m entries; empty where the
    /// exact Hessian is not asked for.
    pub curvature: Vec<f64>,
}

/// Start, interval, number of integration steps per interval and parameters over the horizon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid<'a> {
    /// Grid point of the run at which the horizon starts.
    pub(crate) k0: usize,
    pub(crate) dt: f64,
    pub(crate) substeps: usize,
    /// Live parameters at the grid points of the run; the last row holds on.
    pub(crate) parameters: &'a [Vec<f64>],
}

impl Grid<'_> {
    /// Interval k of the horizon under the input `u`; the dynamics get its parameters.
    pub(crate) fn enter<'a>(&self, dynamics: &mut dyn Dynamics, k: usize, u: &'a [f64]) -> Interval<'a> {
        if let Some(last) = self.parameters.len().checked_sub(1) {
            dynamics.set_parameters(&self.parameters[(self.k0 + k).min(last)]);
        }
        Interval { t: (self.k0 + k) as f64 * self.dt, dt: self.dt, substeps: self.substeps, u }
    }
}

/// The integrator and what it can reach.
pub(crate) struct Shooter {
    n: usize,
    m: usize,
    /// Entries that the flow's derivative can have: the reflexive and transitive closure of the field's pattern.
    closure: Vec<bool>,
    method: Box<dyn OneStepMethod>,
    /// Whether the equations of an implicit step could not be solved since the last [`Shooter::take_failure`].
    failed: bool,
    /// Memory of the second derivatives.
    stages: Stages,
    end: Vec<f64>,
    jacobian: Vec<f64>,
}

impl Shooter {
    pub(crate) fn new(dynamics: &dyn Dynamics, integrator: Integrator) -> Self {
        let (n, m) = (dynamics.states(), dynamics.inputs());
        let w = n + m;
        let pattern = dynamics.jacobian_pattern();
        let mut closure = vec![false; n * w];
        for i in 0..n {
            closure[i * w + i] = true;
        }
        for &(i, j) in pattern {
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
        let method: Box<dyn OneStepMethod> = if integrator.is_implicit() {
            Box::new(Collocation::new(n, m, pattern, Tableau::new(integrator)))
        } else {
            Box::new(ExplicitRungeKutta::new(n, m, pattern, &closure))
        };
        Self { n, m, closure, method, failed: false, stages: Stages::default(), end: Vec::new(), jacobian: Vec::new() }
    }

    /// Which entries of ∂F/∂(x, u) can differ from zero, n rows of n + m.
    pub(crate) fn closure(&self) -> &[bool] {
        &self.closure
    }

    /// Whether an implicit step has failed since this was last asked. Its end state is no number.
    pub(crate) fn take_failure(&mut self) -> bool {
        std::mem::take(&mut self.failed)
    }

    /// Advances `x` over the interval.
    pub(crate) fn advance(&mut self, dynamics: &mut dyn Dynamics, interval: Interval<'_>, x: &mut [f64]) {
        self.failed |= !self.method.advance(dynamics, interval, x);
    }

    /// As [`Shooter::advance`], and the derivative of the end state with respect to (x, u) into `jacobian`.
    pub(crate) fn advance_with_sensitivity(
        &mut self,
        dynamics: &mut dyn Dynamics,
        interval: Interval<'_>,
        x: &mut [f64],
        jacobian: &mut [f64],
    ) {
        self.failed |= !self.method.differentiate(dynamics, interval, Differentiated { x, jacobian, stages: None });
    }

    /// Linearizes some intervals of the trajectory.
    pub(crate) fn linearize(
        &mut self,
        dynamics: &mut dyn Dynamics,
        grid: Grid<'_>,
        trajectory: &Trajectory,
        intervals: std::ops::Range<usize>,
        out: &mut Linearization,
    ) {
        let (n, w) = (self.n, self.n + self.m);
        out.end.resize(trajectory.steps() * n, 0.0);
        out.jacobian.resize(trajectory.steps() * n * w, 0.0);
        for k in intervals {
            let interval = grid.enter(dynamics, k, trajectory.u(k));
            let end = &mut out.end[k * n..(k + 1) * n];
            end.copy_from_slice(trajectory.x(k));
            self.advance_with_sensitivity(dynamics, interval, end, &mut out.jacobian[k * n * w..(k + 1) * n * w]);
        }
    }

    /// ∇²_(x, u) λᵀF over one interval from the state `x`, n + m rows of n + m entries; `field` holds the places of the field's
    /// second derivatives. `lambda` is lost.
    pub(crate) fn curvature(
        &mut self,
        dynamics: &mut dyn Dynamics,
        interval: Interval<'_>,
        x: &[f64],
        lambda: &mut [f64],
        field: &[(usize, usize)],
        out: &mut [f64],
    ) {
        self.end.clear();
        self.end.extend_from_slice(x);
        self.jacobian.resize(self.n * (self.n + self.m), 0.0);
        let stages = &mut self.stages;
        stages.clear();
        let (end, jacobian) = (&mut self.end, &mut self.jacobian);
        let to = Differentiated { x: end, jacobian, stages: Some(stages) };
        if self.method.differentiate(dynamics, interval, to) {
            self.method.adjoints(interval.step(), stages, lambda);
            stages.hessian(dynamics, interval.u, field, out);
        } else {
            out.fill(f64::NAN);
        }
    }

    /// The curvature of every interval for the multipliers y of x_{k+1} − F(x_k, u_k) = 0 in the Lagrangian, N rows of n.
    pub(crate) fn curvatures(
        &mut self,
        dynamics: &mut dyn Dynamics,
        grid: Grid<'_>,
        trajectory: &Trajectory,
        multipliers: &[f64],
        field: &[(usize, usize)],
        out: &mut Vec<f64>,
    ) {
        let (n, w) = (self.n, self.n + self.m);
        out.resize(trajectory.steps() * w * w, 0.0);
        let mut lambda = vec![0.0; n];
        for (k, block) in out.chunks_exact_mut(w * w).enumerate() {
            let interval = grid.enter(dynamics, k, trajectory.u(k));
            lambda.iter_mut().zip(&multipliers[k * n..(k + 1) * n]).for_each(|(l, y)| *l = -y);
            self.curvature(dynamics, interval, trajectory.x(k), &mut lambda, field, block);
        }
    }

    /// End states only.
    pub(crate) fn end_states(
        &mut self,
        dynamics: &mut dyn Dynamics,
        grid: Grid<'_>,
        trajectory: &Trajectory,
        end: &mut Vec<f64>,
    ) {
        let n = self.n;
        end.resize(trajectory.steps() * n, 0.0);
        for (k, row) in end.chunks_exact_mut(n).enumerate() {
            let interval = grid.enter(dynamics, k, trajectory.u(k));
            row.copy_from_slice(trajectory.x(k));
            self.advance(dynamics, interval, row);
        }
    }

    /// Replaces the states by those that follow from x_0 and the inputs.
    pub(crate) fn roll_out(&mut self, dynamics: &mut dyn Dynamics, grid: Grid<'_>, trajectory: &mut Trajectory) {
        for k in 0..trajectory.steps() {
            let mut x = trajectory.x(k).to_vec();
            let interval = grid.enter(dynamics, k, trajectory.u(k));
            self.advance(dynamics, interval, &mut x);
            trajectory.x_mut(k + 1).copy_from_slice(&x);
        }
    }
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
        let mut s = Shooter::new(&d, Integrator::Rk4);
        let (x, u) = ([0.3, 0.02, -0.4], [0.6, 1.5]);
        let mut flow = |x: &[f64], u: &[f64]| {
            let mut end = x.to_vec();
            s.advance(&mut d, Interval { t: 0.0, dt: 0.1, substeps: 5, u }, &mut end);
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
        let mut s = Shooter::new(&d, Integrator::Rk4);
        let interval = Interval { t: 0.0, dt: 0.1, substeps: 5, u: &u };
        s.advance_with_sensitivity(&mut d, interval, &mut same, &mut jacobian);
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
        assert_eq!(Shooter::new(&d, Integrator::Rk4).closure(), [true, true, true, false, true, true]);
    }

    #[test]
    fn the_method_has_order_four() {
        let mut d = FieldDynamics::new(1, 1, |t, x, _u, dx, jac| {
            dx[0] = x[0] * t.cos();
            jac.copy_from_slice(&[t.cos(), 0.0]);
        });
        let mut s = Shooter::new(&d, Integrator::Rk4);
        let mut error = |steps| {
            let mut x = [1.0];
            s.advance(&mut d, Interval { t: 0.0, dt: 2.0, substeps: steps, u: &[0.0] }, &mut x);
            (x[0] - 2f64.sin().exp()).abs()
        };
        let order = (error(20) / error(40)).log2();
        assert!((order - 4.0).abs() < 0.15, "{order}");
    }
}
