//! Partial condensing into dense blocks.
//!
//! The intervals of a block share one stage of a smaller problem: the state at its start and all its inputs are the variables,
//! the states within are affine in them. Hessian and gradient come from a backward recursion over the block, whose work
//! grows with the square of its length (Frison and Jørgensen 2013; Axehill 2015).

use super::super::program::StageProgram;
use super::super::recursion::Shape;
use bracketry_numerics::rows::{Strided, add_multiple, add_product, dot};

/// A place of the Hessian among (x_k, u_k) with its slot in the program.
#[derive(Clone, Copy)]
struct Curvature {
    slot: usize,
    places: (usize, usize),
}

/// Intervals first … first + length − 1 as one stage with the variables w = (u_last, …, u_first, x_first).
///
/// Matrices have columns for w and one more, for what is constant. Row by row at the distance `stride`.
pub(super) struct Block {
    pub(super) first: usize,
    pub(super) length: usize,
    /// Numbers of variables; the first block has no states: its own is given.
    pub(super) shape: Shape,
    /// States at the grid points first + 1 … first + length, n rows each.
    ends: Vec<f64>,
    /// Upper triangle of the Hessian, and the gradient in the last column.
    pub(super) hessian: Vec<f64>,
}

impl Block {
    /// Number of variables.
    pub(super) fn size(&self) -> usize {
        self.shape.size()
    }

    /// Distance of rows.
    pub(super) fn stride(&self) -> usize {
        self.shape.stride()
    }

    /// Column of the first input of the interval `i` of the block.
    pub(super) fn column(&self, i: usize) -> usize {
        self.shape.inputs / self.length * (self.length - 1 - i)
    }

    /// First column that the state at grid point `i` of the block depends on.
    pub(super) fn first_column(&self, i: usize) -> usize {
        if i == 0 { self.shape.inputs } else { self.column(i - 1) }
    }

    /// The gradient where w = 0.
    pub(super) fn gradient(&self) -> impl Iterator<Item = f64> {
        self.hessian.iter().skip(self.size()).step_by(self.stride()).copied()
    }

    /// The state at its end, n rows.
    pub(super) fn flow(&self, n: usize) -> &[f64] {
        self.state(self.length, n)
    }

    /// The state at grid point `i` ≥ 1 of the block, n rows.
    pub(super) fn state(&self, i: usize, n: usize) -> &[f64] {
        let size = n * self.stride();
        &self.ends[(i - 1) * size..i * size]
    }

    /// The values of the states at grid point `i` ≥ 1 for these variables.
    pub(super) fn state_value(&self, i: usize, n: usize, w: &[f64], to: &mut [f64]) {
        let (column, size) = (self.first_column(i), self.size());
        for (row, to) in self.state(i, n).chunks_exact(self.stride()).zip(to) {
            *to = dot(&row[column..size], &w[column..]) + row[size];
        }
    }

    /// Adds `factor` times state `a` at grid point `i`, from its first column on, to a row that begins there.
    pub(super) fn add_state(&self, (i, a): (usize, usize), n: usize, factor: f64, to: &mut [f64]) {
        if i > 0 {
            let start = a * self.stride();
            add_multiple(to, factor, &self.state(i, n)[start + self.first_column(i)..start + self.stride()]);
        } else if self.shape.states > 0 {
            to[a] += factor;
        }
    }
}

/// The blocks of a program.
pub(super) struct Blocks {
    pub(super) n: usize,
    m: usize,
    pub(super) all: Vec<Block>,
    /// Entries of the Hessian at every grid point.
    curvature: Vec<Vec<Curvature>>,
    /// The slope with respect to the state while a block is worked through, and the one before it.
    slope: Vec<f64>,
    next: Vec<f64>,
}

impl Blocks {
    /// Lays out blocks of `length` intervals; `None` where an entry of the Hessian couples two grid points.
    pub(super) fn new(program: &StageProgram, length: usize) -> Option<Self> {
        let (n, m, steps) = (program.states, program.inputs, program.steps);
        let mut curvature = vec![Vec::new(); steps + 1];
        for (slot, &(i, j)) in program.hessian_places.iter().enumerate() {
            let k = program.grid_point(i);
            if program.grid_point(j) != k {
                return None;
            }
            match (program.place_of(k, i), program.place_of(k, j)) {
                (Some(a), Some(b)) => curvature[k].push(Curvature { slot, places: (a.min(b), a.max(b)) }),
                // The diagonal entry of a slack.
                (None, None) if i == j => {}
                _ => return None,
            }
        }
        let mut all = Vec::new();
        for first in (0..steps).step_by(length) {
            let length = length.min(steps - first);
            let shape = Shape { inputs: length * m, states: if first > 0 { n } else { 0 } };
            let (ends, hessian) = (vec![0.0; length * n * shape.stride()], vec![0.0; shape.size() * shape.stride()]);
            all.push(Block { first, length, shape, ends, hessian });
        }
        let widest = all.iter().map(Block::stride).max()?;
        Some(Self { n, m, all, curvature, slope: vec![0.0; n * widest], next: vec![0.0; n * widest] })
    }

    /// The block of a grid point, and its number there.
    pub(super) fn find(&self, k: usize) -> (usize, usize) {
        let block = (k / self.all[0].length).min(self.all.len() - 1);
        (block, k - self.all[block].first)
    }

    /// The column of the one variable, an input or a state at the start of a block, among entries at a grid point.
    pub(super) fn column_of(&self, k: usize, entries: &[(usize, usize)]) -> usize {
        let (block, i) = self.find(k);
        let block = &self.all[block];
        match entries.first() {
            Some(&(place, _)) if place < self.n => block.shape.inputs + place,
            Some(&(place, _)) => block.column(i) + place - self.n,
            None => 0,
        }
    }

    /// Takes in the numbers of block `j`.
    pub(super) fn condense(&mut self, j: usize, program: &StageProgram, flow: &[f64]) {
        self.simulate(j, program, flow);
        self.accumulate(j, program, flow);
    }

    /// The states of the block.
    fn simulate(&mut self, j: usize, program: &StageProgram, flow: &[f64]) {
        let (n, m) = (self.n, self.m);
        let (w, block) = (n + m, &mut self.all[j]);
        let (stride, inputs) = (block.stride(), block.shape.inputs);
        for i in 0..block.length {
            let k = block.first + i;
            let (column, known) = (block.column(i), block.first_column(i));
            let flow = &flow[k * n * w..(k + 1) * n * w];
            let (before, after) = block.ends.split_at_mut(i * n * stride);
            for (r, to) in after[..n * stride].chunks_exact_mut(stride).enumerate() {
                to.fill(0.0);
                to[column..column + m].copy_from_slice(&flow[r * w + n..(r + 1) * w]);
                to[stride - 1] = program.defect[k * n + r];
                if i == 0 && block.shape.states > 0 {
                    to[inputs..inputs + n].copy_from_slice(&flow[r * w..r * w + n]);
                }
            }
            if i > 0 {
                let before = (&before[(i - 1) * n * stride..], stride);
                add_product(after, stride, Strided::new(flow, w), before, (n, n), known..stride);
            }
        }
    }

    /// Hessian and gradient of the block.
    fn accumulate(&mut self, j: usize, program: &StageProgram, flow: &[f64]) {
        let (n, m) = (self.n, self.m);
        let (w, last) = (n + m, j + 1 == self.all.len());
        let Self { all, curvature, slope, next, .. } = self;
        let block = &mut all[j];
        let (stride, size, inputs) = (block.stride(), block.size(), block.shape.inputs);
        let mut hessian = std::mem::take(&mut block.hessian);
        hessian.fill(0.0);
        slope[..n * stride].fill(0.0);
        let mut curved = false;
        for i in (0..=block.length).rev() {
            let k = block.first + i;
            if i == block.length && !last {
                // The state at the end belongs to the next block.
                continue;
            }
            let known = block.first_column(i);
            next[..n * stride].fill(0.0);
            if i < block.length {
                let flow = &flow[k * n * w..(k + 1) * n * w];
                let column = block.column(i);
                if curved {
                    let of_inputs = Strided { values: &flow[n..], row: 1, column: w };
                    let to = &mut hessian[column * stride..];
                    add_product(to, stride, of_inputs, (slope, stride), (m, n), column..stride);
                    if known < size {
                        let of_states = Strided { values: flow, row: 1, column: w };
                        add_product(next, stride, of_states, (slope, stride), (n, n), known..stride);
                    }
                }
                for l in 0..m {
                    hessian[(column + l) * stride + size] += program.gradient[program.input(k, l)];
                }
            }
            let has_state = i > 0 || block.shape.states > 0;
            for a in (0..n).filter(|_| has_state) {
                next[a * stride + size] += program.gradient[program.state(k, a)];
            }
            for c in &curvature[k] {
                let (h, (a, b)) = (program.hessian[c.slot], c.places);
                let row = |a: usize| a * stride + known..(a + 1) * stride;
                if h == 0.0 {
                } else if b < n {
                    block.add_state((i, b), n, h, &mut next[row(a)]);
                    if a != b {
                        block.add_state((i, a), n, h, &mut next[row(b)]);
                    }
                } else {
                    let of = |v: usize| block.column(i) + v - n;
                    if a < n {
                        block.add_state((i, a), n, h, &mut hessian[row(of(b))]);
                    } else {
                        hessian[of(a) * stride + of(b)] += h;
                    }
                }
            }
            std::mem::swap(slope, next);
            curved = true;
        }
        for a in 0..block.shape.states {
            let (to, from) = ((inputs + a) * stride, a * stride);
            hessian[to + inputs + a..to + stride].copy_from_slice(&slope[from + inputs + a..from + stride]);
        }
        self.all[j].hessian = hessian;
    }
}
