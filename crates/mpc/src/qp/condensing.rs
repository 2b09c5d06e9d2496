//! Exact elimination of variables from the stage program.
//!
//! An eliminated variable q = Σ a_p p + c is replaced wherever it occurs:
//!
//! ```text
//! ½ H_qq q² + q Σ_r H_qr r + g_q q    and    Σ_rows R_q q
//! ```
//!
//! Which products have to be added where depends on the structure alone, so it is worked out once, as a list of operations
//! `work[to] += work[from]·coefficient[by]`, and replayed with every new set of numbers. Going from the end of the horizon to
//! its start this is the backward recursion of condensing, with O(N²) operations (Frison and Jørgensen 2013), and it serves
//! partial condensing (Axehill 2015) and single states just as well.

use super::backend::StageSolution;
use super::elimination::{Builder, Coefficient, Eliminated, Product, Sections, Source, parents};
use super::program::StageProgram;
use clarabel::algebra::CscMatrix;

/// The elimination as a list of operations.
pub(super) struct Condensing {
    work: Vec<f64>,
    /// The work before the numbers of the first interval come in.
    saved: Vec<f64>,
    coefficients: Vec<f64>,
    coefficient_sources: Vec<Coefficient>,
    /// Coefficients of the first interval.
    first_coefficients: Vec<usize>,
    /// Operations that do not touch numbers of the first interval, and those that do.
    early: Vec<Product>,
    late: Vec<Product>,
    /// Slots of the first interval.
    first_loads: Vec<(usize, Source)>,
    /// Entries −A, −B of the dynamics that stay: slot, place in the flow; those of the first interval come first.
    flow_loads: Vec<(usize, usize)>,
    first_flow_loads: usize,
    /// Entries 1 of the dynamics that stay.
    ones: Vec<usize>,
    eliminated: Vec<Eliminated>,
    sections: Sections,
    /// Variables that stay, rows of the dynamics that stay: (interval, state).
    kept: Vec<usize>,
    dynamics: Vec<(usize, usize)>,
    gather_p: Gather,
    gather_a: Gather,
    gather_q: Gather,
    gather_b: Gather,
    /// Sizes of the objective, and of the variables and rows that stay.
    objective_scale: f64,
    scale: Vec<f64>,
    row_scale: Vec<f64>,
}

/// Slots of values that a solver wants, with the factors that scale them.
type Gather = Vec<(u32, f64)>;

/// Slots of a matrix's values with the factors of their columns and rows.
fn scaled(matrix: &CscMatrix<f64>, slots: Vec<u32>, scale: &[f64], of_row: impl Fn(usize) -> f64) -> Gather {
    let columns = (0..matrix.n).flat_map(|c| vec![c; matrix.colptr[c + 1] - matrix.colptr[c]]);
    let factors = columns.zip(&matrix.rowval).map(|(c, &r)| scale[c] * of_row(r));
    slots.into_iter().zip(factors).collect()
}

impl Condensing {
    /// Works out the elimination of the states marked in `eliminate` (by grid point 1 … N and state) and of inputs that are
    /// shared within a block, and returns it with the matrices P, A it fills: the rows of the dynamics that stay, then those of
    /// the program.
    pub(super) fn new(
        program: &StageProgram,
        eliminate: impl Fn(usize, usize) -> bool,
    ) -> (Self, CscMatrix<f64>, CscMatrix<f64>) {
        let (n, steps) = (program.states, program.steps);
        let w = n + program.inputs;
        let sections = Sections::new(program);
        let dynamics: Vec<(usize, usize)> =
            (0..steps).flat_map(|k| (0..n).map(move |i| (k, i))).filter(|&(k, i)| !eliminate(k + 1, i)).collect();
        let mut b = Builder::new(program, sections, dynamics.len());
        let (mut ones, mut flow_loads, mut first_flow_loads) = (Vec::new(), Vec::new(), 0);
        for (row, &(k, i)) in dynamics.iter().enumerate() {
            ones.push(b.constraint(row, program.state(k + 1, i)) as usize);
            for (v, place) in parents(program, k, i) {
                flow_loads.push((b.constraint(row, v) as usize, place));
                first_flow_loads += usize::from(k == 0);
            }
        }
        let (eliminated, early) = b.eliminate_backward(program, eliminate);
        let late = std::mem::take(&mut b.products);
        let mut gone = vec![false; program.gradient.len()];
        for e in &eliminated {
            gone[e.variable] = true;
        }
        let kept: Vec<usize> = (0..gone.len()).filter(|&v| !gone[v]).collect();
        let [(p, slots_p), (a, slots_a)] = b.matrices(&kept);
        let first_coefficients = (0..b.sources.len())
            .filter(|&c| match b.sources[c] {
                Coefficient::Flow(i) => i < n * w,
                Coefficient::Defect(i) | Coefficient::NegativeDefect(i) => i < n,
                _ => false,
            })
            .collect();
        let scale: Vec<f64> = kept.iter().map(|&v| program.scale[v]).collect();
        let of_dynamics = dynamics.iter().map(|&(k, i)| program.scale[program.state(k + 1, i)]);
        let row_scale: Vec<f64> = of_dynamics.chain(program.row_scale.iter().copied()).collect();
        let substitution = Self {
            work: vec![0.0; b.slots],
            saved: vec![0.0; b.slots],
            coefficients: vec![1.0; b.sources.len()],
            coefficient_sources: b.sources,
            first_coefficients,
            early,
            late,
            first_loads: sections.first_loads(program),
            flow_loads,
            first_flow_loads,
            ones,
            eliminated,
            sections,
            gather_p: scaled(&p, slots_p, &scale, |r| scale[r]),
            gather_a: scaled(&a, slots_a, &scale, |r| 1.0 / row_scale[r]),
            gather_q: kept.iter().zip(&scale).map(|(&v, &s)| ((sections.gradient + v) as u32, s)).collect(),
            gather_b: b.right.into_iter().zip(&row_scale).map(|(slot, s)| (slot, 1.0 / s)).collect(),
            objective_scale: 1.0,
            scale,
            row_scale,
            kept,
            dynamics,
        };
        (substitution, p, a)
    }

    /// Rows of the dynamics that stay.
    pub(super) fn equalities(&self) -> usize {
        self.dynamics.len()
    }

    /// Takes in every number.
    pub(super) fn load(&mut self, program: &StageProgram, flow: &[f64]) {
        let s = self.sections;
        self.work[s.dynamics_right..].fill(0.0);
        self.work[..s.gradient].copy_from_slice(&program.hessian);
        self.work[s.gradient..s.rows].copy_from_slice(&program.gradient);
        self.work[s.rows..s.right].copy_from_slice(&program.rows);
        self.work[s.right..s.dynamics_right].copy_from_slice(&program.right);
        for (slot, &(k, i)) in self.work[s.dynamics_right..].iter_mut().zip(&self.dynamics) {
            *slot = program.defect[k * program.states + i];
        }
        for &slot in &self.ones {
            self.work[slot] = 1.0;
        }
        for &(slot, place) in &self.flow_loads {
            self.work[slot] = -flow[place];
        }
        for c in 0..self.coefficients.len() {
            self.load_coefficient(c, program, flow);
        }
        for &(slot, _) in &self.first_loads {
            self.work[slot] = 0.0;
        }
        replay(&self.early, &mut self.work, &self.coefficients);
        self.saved.copy_from_slice(&self.work);
        self.finish(program);
    }

    /// Takes in the numbers of the first interval, all others being those of the last [`Condensing::load`].
    pub(super) fn load_first(&mut self, program: &StageProgram, flow: &[f64]) {
        self.work.copy_from_slice(&self.saved);
        let s = self.sections;
        for (slot, &(k, i)) in self.work[s.dynamics_right..].iter_mut().zip(&self.dynamics) {
            if k > 0 {
                break;
            }
            *slot = program.defect[i];
        }
        for &(slot, place) in &self.flow_loads[..self.first_flow_loads] {
            self.work[slot] = -flow[place];
        }
        for i in 0..self.first_coefficients.len() {
            self.load_coefficient(self.first_coefficients[i], program, flow);
        }
        self.finish(program);
    }

    fn load_coefficient(&mut self, c: usize, program: &StageProgram, flow: &[f64]) {
        self.coefficients[c] = match self.coefficient_sources[c] {
            Coefficient::Flow(i) => flow[i],
            Coefficient::Defect(i) => program.defect[i],
            Coefficient::NegativeDefect(i) => -program.defect[i],
            Coefficient::Offset(i) => program.offset[i],
            Coefficient::NegativeOffset(i) => -program.offset[i],
            Coefficient::One => 1.0,
        };
    }

    /// Adds the numbers of the first interval and what follows from them.
    fn finish(&mut self, program: &StageProgram) {
        self.objective_scale = program.objective_scale;
        for &(slot, source) in &self.first_loads {
            self.work[slot] += match source {
                Source::Hessian(i) => program.hessian[i],
                Source::Gradient(i) => program.gradient[i],
                Source::Row(i) => program.rows[i],
                Source::Right(i) => program.right[i],
            };
        }
        replay(&self.late, &mut self.work, &self.coefficients);
    }

    /// Writes the values of P and A and the vectors q and b, all divided by their sizes.
    pub(super) fn gather(&self, p: &mut [f64], q: &mut [f64], a: &mut [f64], b: &mut [f64]) {
        let c = 1.0 / self.objective_scale;
        let parts =
            [(p, &self.gather_p, c), (q, &self.gather_q, c), (a, &self.gather_a, 1.0), (b, &self.gather_b, 1.0)];
        for (to, from, common) in parts {
            for (v, &(slot, factor)) in to.iter_mut().zip(from) {
                *v = common * factor * self.work[slot as usize];
            }
        }
    }

    /// Values of all variables and multipliers of all dynamics and rows from those of the solver.
    pub(super) fn recover(&self, x: &[f64], multipliers: &[f64], to: &mut StageSolution, states: usize) {
        let StageSolution { z, multipliers: y, row_multipliers, .. } = to;
        for ((&v, &s), &x) in self.kept.iter().zip(&self.scale).zip(x) {
            z[v] = s * x;
        }
        for e in self.eliminated.iter().rev() {
            let sum = e.parents.iter().map(|&(p, a)| self.coefficients[a as usize] * z[p]);
            z[e.variable] = sum.sum::<f64>() + self.coefficients[e.constant as usize];
        }
        for ((&(k, i), &s), &v) in self.dynamics.iter().zip(&self.row_scale).zip(multipliers) {
            y[k * states + i] = v * self.objective_scale / s;
        }
        for e in &self.eliminated {
            let Some(at) = e.multiplier else { continue };
            let curvature = e.curvature.iter().map(|&(s, r)| self.work[s as usize] * z[r]);
            let rows = e
                .rows
                .iter()
                .map(|&(s, r)| self.work[s as usize] * multipliers[r] * self.objective_scale / self.row_scale[r]);
            y[at] = -(self.work[e.gradient as usize] + curvature.sum::<f64>() + rows.sum::<f64>());
        }
        let rows = self.dynamics.len()..;
        let scaled = multipliers[rows.clone()].iter().zip(&self.row_scale[rows]);
        row_multipliers.clear();
        row_multipliers.extend(scaled.map(|(v, s)| v * self.objective_scale / s));
    }
}

fn replay(products: &[Product], work: &mut [f64], coefficients: &[f64]) {
    for p in products {
        let add = work[p.from as usize] * coefficients[p.by as usize];
        work[p.to as usize] += add;
    }
}
