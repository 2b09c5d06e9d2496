//! Multiple shooting: the flow over every interval and its exact derivatives.

use crate::dynamics::Dynamics;
use crate::integrator::{
    Collocation, Differentiated, ExplicitRungeKutta, Integrator, Interval, MapIteration, OneStepMethod, Stages,
};
use crate::ocp::{Moves, Ocp};
use crate::trajectory::PlannedTrajectory;
use bracketry_numerics::collocation::Tableau;

/// End states of every interval, and their derivatives.
#[derive(Clone, Debug, Default)]
pub struct ShootingLinearization {
    /// F(x_k, u_k), N rows of n entries.
    pub end: Vec<f64>,
    /// ∂F/∂(x, u), N blocks of n rows of n + m entries.
    pub jacobian: Vec<f64>,
    /// Second derivatives ∇²_(x, u) λ_kᵀF of the Lagrangian's dynamics, N blocks of n + m rows of n + m entries; empty where the
    /// exact Hessian is not asked for.
    pub curvature: Vec<f64>,
}

/// Start, number of integration steps per interval, and problem.
#[derive(Clone, Copy)]
pub(crate) struct Grid<'a> {
    /// Grid point of the run at which the horizon starts.
    pub(crate) k0: usize,
    pub(crate) substeps: usize,
    /// The problem, for its intervals and live parameters.
    pub(crate) ocp: &'a Ocp,
}

impl Grid<'_> {
    /// Interval k of the horizon under the input `u`; the dynamics get its parameters.
    pub(crate) fn enter<'a>(&self, dynamics: &mut dyn Dynamics, k: usize, u: &'a [f64]) -> Interval<'a> {
        let (of_run, of_branches) =
            (self.ocp.parameter_row(self.ocp.sample(self.k0, k)), self.ocp.branch_parameters(k));
        if !of_branches.is_empty() {
            dynamics.set_parameters(&[of_run.unwrap_or(&[]), of_branches].concat());
        } else if let Some(parameters) = of_run {
            dynamics.set_parameters(parameters);
        }
        Interval { t: self.ocp.time(self.k0, k), dt: self.ocp.length(k), substeps: self.substeps, u }
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
    hessian: Vec<f64>,
    lambda: Vec<f64>,
    /// Inputs that are the last states at the end of an interval, in this order.
    previous: Vec<usize>,
    moves: Moves,
}

impl Shooter {
    /// For the states of the dynamics, then the previous inputs of the problem.
    pub(crate) fn of_problem(dynamics: &dyn Dynamics, ocp: &Ocp) -> Self {
        let mut shooter = Self::new(dynamics, ocp.integrator);
        let (n, m, extra) = (shooter.n, shooter.m, ocp.previous_inputs.len());
        if extra == 0 {
            return shooter;
        }
        let w = n + extra + m;
        let mut closure = vec![false; (n + extra) * w];
        for i in 0..n {
            for j in 0..n + m {
                closure[i * w + if j < n { j } else { j + extra }] = shooter.closure[i * (n + m) + j];
            }
        }
        for (i, p) in ocp.previous_inputs.iter().enumerate() {
            closure[(n + i) * w + n + extra + p.input] = true;
        }
        shooter.moves = ocp.moves();
        // Of what stands at one place at some grid point, an entry is possible at all of them.
        for &(from, to) in [0, 1].iter().flat_map(|k| shooter.moves.at(*k)) {
            for i in 0..n + extra {
                closure[i * w + to] |= closure[i * w + from];
            }
        }
        shooter.closure = closure;
        shooter.previous = ocp.previous_inputs.iter().map(|p| p.input).collect();
        shooter
    }

    /// For the states of the dynamics alone.
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
        let method: Box<dyn OneStepMethod> = match integrator {
            Integrator::Map => Box::new(MapIteration::new(n, m, pattern)),
            Integrator::Rk4 => Box::new(ExplicitRungeKutta::new(n, m, pattern, &closure)),
            Integrator::GaussLegendre { stages } => {
                Box::new(Collocation::new(n, m, pattern, Tableau::gauss_legendre(stages)))
            }
            Integrator::RadauIIA { stages } => Box::new(Collocation::new(n, m, pattern, Tableau::radau_iia(stages))),
        };
        Self {
            n,
            m,
            closure,
            method,
            failed: false,
            stages: Stages::default(),
            end: Vec::new(),
            jacobian: Vec::new(),
            hessian: Vec::new(),
            lambda: Vec::new(),
            previous: Vec::new(),
            moves: Moves::default(),
        }
    }

    /// Number of states, previous inputs included.
    fn states(&self) -> usize {
        self.n + self.previous.len()
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
        let (x, previous) = x.split_at_mut(self.n);
        self.failed |= !self.method.advance(dynamics, interval, x);
        previous.iter_mut().zip(&self.previous).for_each(|(v, &j)| *v = interval.u[j]);
    }

    /// As [`Shooter::advance`], and the derivative of the end state with respect to (x, u) into `jacobian`.
    pub(crate) fn advance_with_sensitivity(
        &mut self,
        dynamics: &mut dyn Dynamics,
        interval: Interval<'_>,
        x: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let (x, previous) = x.split_at_mut(self.n);
        if previous.is_empty() {
            self.failed |= !self.method.differentiate(dynamics, interval, Differentiated { x, jacobian, stages: None });
            return;
        }
        previous.iter_mut().zip(&self.previous).for_each(|(v, &j)| *v = interval.u[j]);
        self.jacobian.resize(self.n * (self.n + self.m), 0.0);
        let to = Differentiated { x, jacobian: &mut self.jacobian, stages: None };
        self.failed |= !self.method.differentiate(dynamics, interval, to);
        spread_flow(&self.jacobian, (self.n, self.m), &self.previous, jacobian);
    }

    /// Linearizes some intervals of the trajectory.
    pub(crate) fn linearize(
        &mut self,
        dynamics: &mut dyn Dynamics,
        grid: Grid<'_>,
        trajectory: &PlannedTrajectory,
        intervals: std::ops::Range<usize>,
        out: &mut ShootingLinearization,
    ) {
        let (n, w) = (self.states(), self.states() + self.m);
        out.end.resize(trajectory.steps() * n, 0.0);
        out.jacobian.resize(trajectory.steps() * n * w, 0.0);
        for k in intervals {
            let interval = grid.enter(dynamics, k, trajectory.u(k));
            let end = &mut out.end[k * n..(k + 1) * n];
            end.copy_from_slice(trajectory.x(k));
            let jacobian = &mut out.jacobian[k * n * w..(k + 1) * n * w];
            self.advance_with_sensitivity(dynamics, interval, end, jacobian);
            carry_columns(self.moves.at(k), w, jacobian);
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
        let (n, extra) = (self.n, self.previous.len());
        self.end.clear();
        self.end.extend_from_slice(&x[..n]);
        self.jacobian.resize(n * (n + self.m), 0.0);
        let stages = &mut self.stages;
        stages.clear();
        let (end, jacobian) = (&mut self.end, &mut self.jacobian);
        let to = Differentiated { x: end, jacobian, stages: Some(stages) };
        if self.method.differentiate(dynamics, interval, to) {
            self.method.adjoints(interval.step(), stages, &mut lambda[..n]);
            if extra == 0 {
                stages.hessian(dynamics, interval.u, field, out);
                return;
            }
            // Previous inputs are linear: what they add is zero.
            let w = n + self.m;
            self.hessian.resize(w * w, 0.0);
            stages.hessian(dynamics, interval.u, field, &mut self.hessian);
            out.fill(0.0);
            let place = |i: usize| if i < n { i } else { i + extra };
            for (i, row) in self.hessian.chunks_exact(w).enumerate() {
                for (j, v) in row.iter().enumerate() {
                    out[place(i) * (w + extra) + place(j)] = *v;
                }
            }
        } else {
            out.fill(f64::NAN);
        }
    }

    /// The curvature of every interval for the multipliers y of x_{k+1} − F(x_k, u_k) = 0 in the Lagrangian, N rows of n.
    pub(crate) fn curvatures(
        &mut self,
        dynamics: &mut dyn Dynamics,
        grid: Grid<'_>,
        trajectory: &PlannedTrajectory,
        multipliers: &[f64],
        field: &[(usize, usize)],
        out: &mut Vec<f64>,
    ) {
        let (n, w) = (self.states(), self.states() + self.m);
        out.resize(trajectory.steps() * w * w, 0.0);
        let mut lambda = std::mem::take(&mut self.lambda);
        lambda.resize(n, 0.0);
        for (k, block) in out.chunks_exact_mut(w * w).enumerate() {
            let interval = grid.enter(dynamics, k, trajectory.u(k));
            lambda.iter_mut().zip(&multipliers[k * n..(k + 1) * n]).for_each(|(l, y)| *l = -y);
            self.curvature(dynamics, interval, trajectory.x(k), &mut lambda, field, block);
            carry_block(self.moves.at(k), w, block);
        }
        self.lambda = lambda;
    }

    /// Linearizes all intervals and adds their curvature as [`Shooter::curvatures`] does, in one pass.
    pub(crate) fn linearize_with_curvatures(
        &mut self,
        dynamics: &mut dyn Dynamics,
        grid: Grid<'_>,
        trajectory: &PlannedTrajectory,
        (multipliers, field): (&[f64], &[(usize, usize)]),
        out: &mut ShootingLinearization,
    ) {
        let (n, w, steps) = (self.states(), self.states() + self.m, trajectory.steps());
        out.end.resize(steps * n, 0.0);
        out.jacobian.resize(steps * n * w, 0.0);
        out.curvature.resize(steps * w * w, 0.0);
        let mut lambda = std::mem::take(&mut self.lambda);
        lambda.resize(n, 0.0);
        for (k, block) in out.curvature.chunks_exact_mut(w * w).enumerate() {
            let interval = grid.enter(dynamics, k, trajectory.u(k));
            lambda.iter_mut().zip(&multipliers[k * n..(k + 1) * n]).for_each(|(l, y)| *l = -y);
            self.curvature(dynamics, interval, trajectory.x(k), &mut lambda, field, block);
            let end = &mut out.end[k * n..(k + 1) * n];
            end[..self.n].copy_from_slice(&self.end);
            let previous = end[self.n..].iter_mut().zip(&self.previous);
            previous.for_each(|(v, &j)| *v = interval.u[j]);
            let jacobian = &mut out.jacobian[k * n * w..(k + 1) * n * w];
            spread_flow(&self.jacobian, (self.n, self.m), &self.previous, jacobian);
            carry_columns(self.moves.at(k), w, jacobian);
            carry_block(self.moves.at(k), w, block);
        }
        self.lambda = lambda;
    }

    /// End states only.
    pub(crate) fn end_states(
        &mut self,
        dynamics: &mut dyn Dynamics,
        grid: Grid<'_>,
        trajectory: &PlannedTrajectory,
        end: &mut Vec<f64>,
    ) {
        let n = self.states();
        end.resize(trajectory.steps() * n, 0.0);
        for (k, row) in end.chunks_exact_mut(n).enumerate() {
            let interval = grid.enter(dynamics, k, trajectory.u(k));
            row.copy_from_slice(trajectory.x(k));
            self.advance(dynamics, interval, row);
        }
    }

    /// Replaces the states by those that follow from x_0 and the inputs.
    pub(crate) fn roll_out(&mut self, dynamics: &mut dyn Dynamics, grid: Grid<'_>, trajectory: &mut PlannedTrajectory) {
        for k in 0..trajectory.steps() {
            let mut x = trajectory.x(k).to_vec();
            let interval = grid.enter(dynamics, k, trajectory.u(k));
            self.advance(dynamics, interval, &mut x);
            trajectory.x_mut(k + 1).copy_from_slice(&x);
        }
    }
}

/// Adds columns, of `width` columns, to those at whose place they stand, see [`Moves`].
fn carry_columns(moves: &[(usize, usize)], width: usize, matrix: &mut [f64]) {
    for &(from, to) in moves {
        for row in matrix.chunks_exact_mut(width) {
            row[to] += std::mem::take(&mut row[from]);
        }
    }
}

/// The same for rows and columns of a symmetric block of `width` variables.
pub(crate) fn carry_block(moves: &[(usize, usize)], width: usize, block: &mut [f64]) {
    carry_columns(moves, width, block);
    for &(from, to) in moves {
        for c in 0..width {
            block[to * width + c] += std::mem::take(&mut block[from * width + c]);
        }
    }
}

/// The derivative of the end state with respect to (x, u) from that of the dynamics' states, n rows of n + m: room for the
/// previous inputs, which are these inputs at the end of the interval.
pub(crate) fn spread_flow(flow: &[f64], (n, m): (usize, usize), previous: &[usize], out: &mut [f64]) {
    let extra = previous.len();
    let w = n + extra + m;
    out.fill(0.0);
    for (from, to) in flow.chunks_exact(n + m).zip(out.chunks_exact_mut(w)) {
        to[..n].copy_from_slice(&from[..n]);
        to[n + extra..].copy_from_slice(&from[n..]);
    }
    for (i, &j) in previous.iter().enumerate() {
        out[(n + i) * w + n + extra + j] = 1.0;
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
