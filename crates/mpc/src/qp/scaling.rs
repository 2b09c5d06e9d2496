//! Units of the variables, so that tolerances mean the same whatever units a model is written in.

use super::program::StageProgram;
use super::{QpBackend, QpStatus, StageSolution};
use crate::error::MpcError;

/// Smallest curvature of any variable in the units of this module: keeps the program strictly convex.
const REGULARISATION: f64 = 1e-9;
/// Smallest unit of the objective.
const SMALLEST_OBJECTIVE: f64 = 1e-12;

/// Hands a program to a solver with its variables in units of their sizes, every row in units of its largest entry, and an
/// objective that is not small.
///
/// An interior-point method stops at residuals measured against the largest numbers of the program: without this, a flow of
/// heat in thousands of watts decides how precisely a concentration is known.
pub(super) struct Scaled {
    solver: Box<dyn QpBackend>,
    /// Size of every variable.
    sizes: Vec<f64>,
    /// Sizes of states and inputs.
    columns: Vec<f64>,
    /// Unit of the objective.
    objective: f64,
    program: StageProgram,
    flow: Vec<f64>,
    largest: Vec<f64>,
    solution: StageSolution,
}

impl Scaled {
    /// `sizes` are those of all variables, `columns` those of states and inputs, all positive and finite.
    pub(super) fn new(
        solver: Box<dyn QpBackend>,
        program: &StageProgram,
        sizes: Vec<f64>,
        columns: Vec<f64>,
        solution: StageSolution,
    ) -> Self {
        let (n, w) = (program.states, program.states + program.inputs);
        Self {
            solver,
            sizes,
            columns,
            objective: 1.0,
            flow: vec![0.0; program.steps * n * w],
            largest: vec![0.0; program.right.len()],
            program: program.clone(),
            solution,
        }
    }

    /// The unit of the objective: what moving a state or an input by its size changes, but no more than 1.
    fn choose_objective(&mut self, program: &StageProgram) {
        let (mut curvature, mut slope) = (0.0_f64, 0.0_f64);
        let mut visit = |v: usize| {
            let d = self.sizes[v];
            curvature = curvature.max(program.hessian[v] * d * d);
            slope = slope.max((program.gradient[v] * d).abs());
        };
        for k in 0..program.steps {
            (0..program.inputs).for_each(|j| visit(program.input(k, j)));
            (0..program.states).for_each(|i| visit(program.state(k + 1, i)));
        }
        let size = if curvature > 0.0 { curvature } else { slope };
        self.objective = if size > 0.0 { size.clamp(SMALLEST_OBJECTIVE, 1.0) } else { 1.0 };
    }

    fn scale(&mut self, program: &StageProgram, flow: &[f64], intervals: usize) {
        let (p, d) = (&mut self.program, &self.sizes);
        for ((to, from), &(i, j)) in p.hessian.iter_mut().zip(&program.hessian).zip(&program.hessian_places) {
            *to = from * d[i] * d[j] / self.objective;
        }
        for v in 0..d.len() {
            p.hessian[v] += REGULARISATION;
            p.gradient[v] = program.gradient[v] * d[v] / self.objective;
        }
        let (n, m) = (program.states, program.inputs);
        let w = n + m;
        for k in 0..intervals {
            for i in 0..n {
                let row = (k * n + i) * w;
                for (j, size) in self.columns.iter().enumerate() {
                    self.flow[row + j] = flow[row + j] * size / self.columns[i];
                }
                p.defect[k * n + i] = program.defect[k * n + i] / self.columns[i];
            }
            for j in 0..m {
                p.offset[k * m + j] = program.offset[k * m + j] / self.columns[n + j];
            }
        }
        self.largest.fill(0.0);
        for (&(row, v), value) in program.row_places.iter().zip(&program.rows) {
            self.largest[row] = self.largest[row].max((value * d[v]).abs());
        }
        // The rows of a cone share their unit.
        let mut first = program.nonnegative;
        for &rows in &program.second_order {
            let cone = &mut self.largest[first..first + rows];
            let largest = cone.iter().fold(0.0, |a: f64, &b| a.max(b));
            cone.fill(largest);
            first += rows;
        }
        for unit in self.largest.iter_mut().filter(|u| **u == 0.0) {
            *unit = 1.0;
        }
        for ((to, from), &(row, v)) in p.rows.iter_mut().zip(&program.rows).zip(&program.row_places) {
            *to = from * d[v] / self.largest[row];
        }
        for ((to, from), unit) in p.right.iter_mut().zip(&program.right).zip(&self.largest) {
            *to = from / unit;
        }
    }
}

impl QpBackend for Scaled {
    fn load(&mut self, program: &StageProgram, flow: &[f64]) {
        self.choose_objective(program);
        self.scale(program, flow, program.steps);
        self.solver.load(&self.program, &self.flow);
    }

    fn load_first(&mut self, program: &StageProgram, flow: &[f64]) {
        self.scale(program, flow, 1);
        self.solver.load_first(&self.program, &self.flow);
    }

    fn set_limits(&mut self, max_iterations: u32, time_limit: f64) -> Result<(), MpcError> {
        self.solver.set_limits(max_iterations, time_limit)
    }

    fn solve(&mut self, _program: &StageProgram, solution: &mut StageSolution) -> Result<QpStatus, MpcError> {
        let status = self.solver.solve(&self.program, &mut self.solution)?;
        for ((to, from), size) in solution.z.iter_mut().zip(&self.solution.z).zip(&self.sizes) {
            *to = from * size;
        }
        let n = self.program.states;
        for (i, (to, from)) in solution.multipliers.iter_mut().zip(&self.solution.multipliers).enumerate() {
            *to = from * self.objective / self.columns[i % n];
        }
        solution.iterations = self.solution.iterations;
        Ok(status)
    }
}
