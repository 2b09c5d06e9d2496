//! An interior-point method of our own for programs without cones: the stages are condensed to dense blocks, and the linear
//! systems are solved by the Riccati recursion over them, the form of HPIPM (Frison and Diehl 2020).

mod blocks;
mod constraints;
mod iteration;
#[cfg(test)]
mod tests;

use super::backend::{QpBackend, QpSettings, QpStatus, StageSolution};
use super::program::StageProgram;
use crate::error::MpcError;
use blocks::Blocks;
use constraints::Constraints;
use iteration::{InteriorPoint, Outcome};
use std::time::Instant;

/// The method with its memory.
pub(super) struct Stagewise {
    settings: QpSettings,
    blocks: Blocks,
    constraints: Constraints,
    method: InteriorPoint,
    flow: Vec<f64>,
    /// Hz + g + Rᵀv.
    slope: Vec<f64>,
}

impl Stagewise {
    /// Lays out blocks of `length` intervals; `None` where the program has cones, inputs that are equal to others, or
    /// something that couples grid points.
    pub(super) fn new(program: &StageProgram, settings: QpSettings, length: usize) -> Option<Self> {
        let (m, steps) = (program.inputs, program.steps);
        if m == 0 || steps == 0 || (0..steps * m).any(|i| program.equal_input(i / m, i % m).is_some()) {
            return None;
        }
        let blocks = Blocks::new(program, length)?;
        let constraints = Constraints::new(program, &blocks)?;
        let method = InteriorPoint::new(&blocks, &constraints, program.right.len());
        Some(Self { settings, blocks, constraints, method, flow: Vec::new(), slope: Vec::new() })
    }

    /// Length of the blocks that is about the fastest.
    pub(super) fn best_length(program: &StageProgram) -> usize {
        program.states.div_ceil(program.inputs.max(1)).clamp(3, 8)
    }

    /// The blocks (A_k, B_k) as they were loaded.
    pub(super) fn flow(&self) -> &[f64] {
        &self.flow
    }

    fn load_block(&mut self, j: usize, program: &StageProgram) {
        self.blocks.condense(j, program, &self.flow);
        self.constraints.load(j, &self.blocks.all[j], self.blocks.n, program);
    }

    /// Steps, slacks, and multipliers in the numbering of the program.
    fn recover(&mut self, program: &StageProgram, solution: &mut StageSolution) {
        let (n, m) = (program.states, program.inputs);
        let at = &self.method.at;
        for (block, w) in self.blocks.all.iter().zip(&at.w) {
            for i in 0..block.length {
                let k = block.first + i;
                let (u, x) = (program.input(k, 0), program.state(k + 1, 0));
                solution.z[u..u + m].copy_from_slice(&w[block.column(i)..block.column(i) + m]);
                block.state_value(i + 1, n, w, &mut solution.z[x..x + n]);
            }
        }
        for (f, s) in self.constraints.functions.iter().zip(&at.s) {
            if let Some(slack) = f.slack {
                solution.z[slack.variable] = *s;
            }
        }
        solution.row_multipliers.clear();
        solution.row_multipliers.extend_from_slice(&at.v);
        // y_k = −(Hz + g + Rᵀv) + A_{k+1}ᵀ y_{k+1}, the slope with respect to dx_{k+1}.
        let slope = &mut self.slope;
        slope.clone_from(&program.gradient);
        for (&(i, j), h) in program.hessian_places.iter().zip(&program.hessian) {
            slope[i] += h * solution.z[j];
            if i != j {
                slope[j] += h * solution.z[i];
            }
        }
        for (&(row, variable), r) in program.row_places.iter().zip(&program.rows) {
            slope[variable] += r * at.v[row];
        }
        let w = n + m;
        for k in (0..program.steps).rev() {
            let (y, after) = solution.multipliers[k * n..].split_at_mut(n);
            let x = program.state(k + 1, 0);
            y.iter_mut().zip(&slope[x..x + n]).for_each(|(y, g)| *y = -g);
            for (row, after) in self.flow[(k + 1) * n * w..].chunks_exact(w).zip(after.iter().take(n)) {
                y.iter_mut().zip(&row[..n]).for_each(|(y, a)| *y += a * after);
            }
        }
    }
}

impl QpBackend for Stagewise {
    fn load(&mut self, program: &StageProgram, flow: &[f64]) {
        self.flow.clear();
        self.flow.extend_from_slice(flow);
        (0..self.blocks.all.len()).for_each(|j| self.load_block(j, program));
    }

    fn load_first(&mut self, program: &StageProgram, flow: &[f64]) {
        let first = program.states * (program.states + program.inputs);
        self.flow[..first].copy_from_slice(&flow[..first]);
        self.load_block(0, program);
    }

    fn set_limits(&mut self, max_iterations: u32, time_limit: f64) -> Result<(), MpcError> {
        self.settings.max_iterations = max_iterations;
        self.settings.time_limit = time_limit;
        self.settings.check()
    }

    fn solve(&mut self, program: &StageProgram, solution: &mut StageSolution) -> Result<QpStatus, MpcError> {
        self.settings.check()?;
        if !(program.is_finite() && self.flow.iter().all(|v| v.is_finite())) {
            return Ok(QpStatus::NotANumber);
        }
        let (start, limit) = (Instant::now(), self.settings.time_limit);
        let spent = || limit.is_finite() && start.elapsed().as_secs_f64() > limit;
        let accuracy = (self.settings.tolerance, self.settings.max_iterations);
        let (outcome, iterations) = self.method.solve(program, &self.blocks, &self.constraints, accuracy, spent);
        solution.iterations = iterations;
        if outcome == Outcome::Failed {
            return Ok(QpStatus::Failed);
        }
        self.recover(program, solution);
        let whole = solution.z.iter().all(|v| v.is_finite());
        Ok(match outcome {
            _ if !whole => QpStatus::Failed,
            Outcome::Limit => QpStatus::Limit,
            Outcome::Solved | Outcome::Failed => QpStatus::Solved,
        })
    }
}
