//! An iterate and what is known of it.

use crate::qp::NonlinearProgram;
use crate::trajectory::PlannedTrajectory;
use crate::transcription::{Merit, ShootingLinearization, Transcription};

/// Primal and dual variables.
#[derive(Clone)]
pub(super) struct Iterate {
    pub(super) z: PlannedTrajectory,
    /// Slacks of soft constraints.
    pub(super) s: Vec<f64>,
    /// Distances t = c + s.
    pub(super) t: Vec<f64>,
    /// Multipliers of the dynamics, N rows of n.
    pub(super) y: Vec<f64>,
    /// Multipliers of the distances.
    pub(super) v: Vec<f64>,
}

/// Values at an iterate.
#[derive(Clone, Default)]
pub(super) struct Values {
    /// Cost and slacks, times the factor of the objective.
    pub(super) objective: f64,
    /// F(x_k, u_k) − x_{k+1}, N rows of n.
    pub(super) defects: Vec<f64>,
    /// c + s − t.
    pub(super) residuals: Vec<f64>,
    /// Sums of their absolute values in units of their sizes, and the largest.
    pub(super) infeasibility: f64,
    pub(super) largest: f64,
}

impl Values {
    pub(super) fn is_finite(&self) -> bool {
        self.objective.is_finite() && self.infeasibility.is_finite()
    }

    /// The merit with the barrier.
    pub(super) fn merit(&self, t: &[f64], barrier: f64) -> Merit {
        let logarithms: f64 = t.iter().map(|t| t.ln()).sum();
        let objective = self.objective - barrier * logarithms;
        Merit { objective, defects: self.infeasibility, worst_defect: self.largest }
    }
}

/// The problem as the method sees it.
pub(super) struct Evaluator<'a> {
    pub(super) problem: &'a mut Transcription,
    pub(super) program: &'a mut NonlinearProgram,
    pub(super) field: &'a [(usize, usize)],
    pub(super) lin: ShootingLinearization,
    /// Factor of the objective.
    pub(super) factor: f64,
    c: Vec<f64>,
    multipliers: Vec<f64>,
    of_rows: Vec<f64>,
}

impl<'a> Evaluator<'a> {
    pub(super) fn new(
        problem: &'a mut Transcription,
        program: &'a mut NonlinearProgram,
        field: &'a [(usize, usize)],
    ) -> Self {
        let (c, multipliers, of_rows) = (Vec::new(), Vec::new(), Vec::new());
        Self { problem, program, field, lin: ShootingLinearization::default(), factor: 1.0, c, multipliers, of_rows }
    }

    pub(super) fn states(&self) -> usize {
        self.problem.ocp.states()
    }

    pub(super) fn width(&self) -> usize {
        self.states() + self.problem.ocp.inputs()
    }

    /// Values c of all rows, with slacks.
    pub(super) fn constraints(&mut self, z: &PlannedTrajectory, s: &[f64]) -> Vec<f64> {
        let problem = &mut *self.problem;
        self.program.values(&mut problem.ocp, problem.k0, z, &self.lin, &mut self.c);
        let slack = |row: &crate::qp::NonlinearRow| row.slack.map_or(0.0, |i| s[i]);
        self.c.iter().zip(&self.program.rows).map(|(c, row)| c + slack(row)).collect()
    }

    /// Values at a point whose dynamics end in `ends`.
    fn values_with(&mut self, point: &Iterate, ends: &[f64]) -> Values {
        let c = self.constraints(&point.z, &point.s);
        let n = self.states();
        let problem = &mut *self.problem;
        let mut objective = problem.ocp.cost(problem.k0, &point.z) - self.program.absolute_cost(&self.c);
        let end = point.z.x(point.z.steps());
        objective += problem.ocp.targets.iter().map(|t| t.quadratic * (end[t.state] - t.value).powi(2)).sum::<f64>();
        objective +=
            self.program.slacks.iter().zip(&point.s).map(|(p, s)| p.linear * s + p.quadratic * s * s).sum::<f64>();
        let defects: Vec<f64> = ends.iter().enumerate().map(|(i, e)| e - point.z.x(i / n + 1)[i % n]).collect();
        let residuals: Vec<f64> = c.iter().zip(&point.t).map(|(c, t)| c - t).collect();
        let (mut infeasibility, mut largest) = (0.0, 0.0_f64);
        let scaled = defects.iter().enumerate().map(|(i, d)| d / problem.ocp.sizes()[i % n]);
        for v in scaled.chain(residuals.iter().zip(&self.program.rows).map(|(r, row)| r / row.scale)) {
            infeasibility += v.abs();
            largest = largest.max(v.abs());
        }
        Values { objective: self.factor * objective, defects, residuals, infeasibility, largest }
    }

    pub(super) fn values(&mut self, point: &Iterate) -> Values {
        let mut ends = std::mem::take(&mut self.problem.ends);
        self.problem.end_states(&point.z, &mut ends);
        let values = self.values_with(point, &ends);
        self.problem.ends = ends;
        values
    }

    /// Linearizes the dynamics, and fills in first and, if `curved`, second derivatives.
    pub(super) fn differentiate(&mut self, point: &Iterate, curved: bool) -> Values {
        self.multipliers.clear();
        self.of_rows.clear();
        self.of_rows.resize(self.program.all_rows(), 0.0);
        if curved {
            self.multipliers.extend(point.y.iter().map(|y| y / self.factor));
            for (row, v) in self.program.rows.iter().zip(&point.v) {
                self.of_rows[row.number] = v / self.factor;
            }
            self.problem.linearize_with_curvatures(&point.z, &self.multipliers, self.field, &mut self.lin);
        } else {
            self.lin.curvature.clear();
            self.problem.linearize(&point.z, 0, point.z.steps(), &mut self.lin);
        }
        let problem = &mut *self.problem;
        self.program.differentiate(&mut problem.ocp, problem.k0, &point.z, &self.lin, &self.of_rows);
        let ends = std::mem::take(&mut self.lin.end);
        let values = self.values_with(point, &ends);
        self.lin.end = ends;
        values
    }

    /// The gradient of the cost, N blocks of n + m entries and n at the end.
    pub(super) fn gradient(&self) -> Vec<f64> {
        let (w, steps) = (self.width(), self.problem.ocp.steps);
        let mut q = vec![0.0; steps * w + self.states()];
        q.chunks_mut(w).enumerate().for_each(|(k, q)| self.program.add_gradient(k, self.factor, q));
        q
    }

    /// Largest entry of the gradient in units of the sizes.
    pub(super) fn steepest(&self) -> f64 {
        let w = self.width();
        let slopes = self.gradient();
        slopes.iter().enumerate().map(|(i, q)| (q * self.program.size(i % w)).abs()).fold(0.0, f64::max)
    }

    /// How far a point is from the conditions of optimality for a barrier: largest entry of the gradient of the Lagrangian,
    /// infeasibility and complementarity.
    pub(super) fn error(&self, point: &Iterate, values: &Values, barrier: f64) -> f64 {
        let (n, w) = (self.states(), self.width());
        let mut q = self.gradient();
        for (i, v) in point.v.iter().enumerate() {
            let block = self.program.rows[i].k * w;
            self.program.row(i).for_each(|(place, a)| q[block + place] -= a * v);
        }
        for k in 0..point.z.steps() {
            let y = &point.y[k * n..(k + 1) * n];
            for (row, y) in self.lin.jacobian[k * n * w..(k + 1) * n * w].chunks_exact(w).zip(y) {
                q[k * w..(k + 1) * w].iter_mut().zip(row).for_each(|(q, a)| *q -= a * y);
            }
            q[(k + 1) * w..(k + 1) * w + n].iter_mut().zip(y).for_each(|(q, y)| *q += y);
        }
        let sizes: Vec<f64> = (0..w).map(|v| self.program.size(v)).collect();
        // The first state is fixed.
        let slopes = q.iter().enumerate().skip(n).filter(|(i, _)| !self.program.is_fixed(i / w, i % w));
        let slopes = slopes.map(|(i, q)| (q * sizes[i % w]).abs());
        let of_slacks = self.program.slacks.iter().zip(&point.s).map(|(p, s)| {
            let held: f64 = p.softens.iter().chain(&p.bound).map(|&row| point.v[row]).sum();
            ((self.factor * (p.linear + 2.0 * p.quadratic * s) - held) * p.scale).abs()
        });
        let slope = slopes.chain(of_slacks).fold(0.0, f64::max);
        let gap = point.t.iter().zip(&point.v).map(|(t, v)| (t * v - barrier).abs()).fold(0.0, f64::max);
        let forces = point.y.iter().enumerate().map(|(i, y)| (y * sizes[i % n]).abs());
        let held = || point.v.iter().zip(&self.program.rows).map(|(v, row)| v * row.scale);
        let of_rows = if point.v.is_empty() { 0.0 } else { held().sum::<f64>() / point.v.len() as f64 };
        let count = (point.y.len() + point.v.len()) as f64;
        let of_all = (forces.sum::<f64>() + held().sum::<f64>()) / count;
        let relative = |mean: f64| mean.max(LARGE) / LARGE;
        (slope / relative(of_all)).max(gap / relative(of_rows)).max(values.largest)
    }
}

/// Mean of multipliers above which the conditions of optimality are relative to them.
const LARGE: f64 = 100.0;
