//! The inequalities of a program as functions of a block's variables, each bounded from one or two sides.

use super::super::program::{Side, StageProgram};
use super::blocks::{Block, Blocks};
use bracketry_numerics::rows::{add_multiple, add_weighted_squares, dot};

/// A slack s that both sides of a function share.
#[derive(Clone, Copy)]
pub(super) struct Slack {
    pub(super) variable: usize,
    /// The row −s ≤ …, if there is one.
    pub(super) bound: Option<usize>,
}

/// aᵀw − s ≤ r_upper and −aᵀw − s ≤ r_lower. The row of a function of one side is `upper`, whatever it bounds.
pub(super) struct Function {
    pub(super) upper: usize,
    pub(super) lower: Option<usize>,
    pub(super) slack: Option<Slack>,
    /// Places among (x_k, u_k) and slots of the upper row.
    entries: Vec<(usize, usize)>,
    /// Its value where w = 0.
    pub(super) constant: f64,
}

impl Function {
    /// Its rows, with the sign of aᵀw in them.
    pub(super) fn sides(&self) -> impl Iterator<Item = (usize, f64)> {
        std::iter::once((self.upper, 1.0)).chain(self.lower.map(|row| (row, -1.0)))
    }
}

/// Gradients of a group of functions.
enum Gradients {
    /// Column and value of the one entry.
    Single(Vec<(usize, f64)>),
    /// Row by row from one column on; the last entry is the constant.
    Dense(Vec<f64>),
}

/// Where a gradient stands; those of one group in one place.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    block: usize,
    single: bool,
    /// Grid point of the block.
    i: usize,
    /// First column.
    column: usize,
}

struct Group {
    place: Place,
    functions: std::ops::Range<usize>,
    gradients: Gradients,
}

/// The inequalities of a program.
pub(super) struct Constraints {
    pub(super) functions: Vec<Function>,
    groups: Vec<Group>,
}

impl Place {
    fn new(blocks: &Blocks, k: usize, entries: &[(usize, usize)]) -> Self {
        let (block, i) = blocks.find(k);
        let of = &blocks.all[block];
        let has_input = entries.iter().any(|&(place, _)| place >= blocks.n);
        let single = entries.is_empty() || (entries.len() == 1 && (has_input || i == 0));
        let column = if has_input { of.column(i) } else { of.first_column(i) };
        if single { Self { block, single, i: 0, column: 0 } } else { Self { block, single, i, column } }
    }
}

impl Constraints {
    /// Lays out the rows of a program; `None` where they are of another kind: cones, rows that couple grid points, a slack
    /// that several functions share.
    pub(super) fn new(program: &StageProgram, blocks: &Blocks) -> Option<Self> {
        if !program.second_order.is_empty() {
            return None;
        }
        let rows = program.right.len();
        let mut entries = vec![Vec::new(); rows];
        let mut slack_of = vec![None; rows];
        for (slot, &(row, variable)) in program.row_places.iter().enumerate() {
            let k = program.row_stage[row];
            if program.grid_point(variable) != k {
                return None;
            }
            match program.place_of(k, variable) {
                Some(place) => entries[row].push((place, slot)),
                None if slack_of[row].replace(variable).is_none() => {}
                None => return None,
            }
        }
        let (mut bounds, mut lower) = (vec![None; program.variables()], vec![None; rows]);
        for (row, side) in program.sides.iter().enumerate() {
            match *side {
                Side::First => {}
                Side::OppositeOf(first) => lower[first] = Some(row),
                Side::SlackBound => bounds[slack_of[row]?] = Some(row),
            }
        }
        let mut found = Vec::new();
        for row in (0..rows).filter(|&row| program.sides[row] == Side::First) {
            let of_slack = |variable: usize| Slack { variable, bound: bounds[variable].take() };
            let slack = slack_of[row].map(of_slack);
            let entries = std::mem::take(&mut entries[row]);
            let place = Place::new(blocks, program.row_stage[row], &entries);
            found.push((place, Function { upper: row, lower: lower[row], slack, entries, constant: 0.0 }));
        }
        let slacks = found.iter().filter_map(|(_, f)| f.slack).map(|s| s.variable);
        let mut slacks: Vec<usize> = slacks.collect();
        slacks.sort_unstable();
        if bounds.iter().any(Option::is_some) || slacks.windows(2).any(|pair| pair[0] == pair[1]) {
            return None;
        }
        found.sort_by_key(|(place, f)| (*place, f.upper));
        let mut groups = Vec::new();
        for chunk in found.chunk_by(|a, b| a.0 == b.0) {
            let first = groups.last().map_or(0, |g: &Group| g.functions.end);
            let (place, functions) = (chunk[0].0, first..first + chunk.len());
            let length = blocks.all[place.block].stride() - place.column;
            let gradients = if place.single {
                let column = |f: &Function| blocks.column_of(program.row_stage[f.upper], &f.entries);
                Gradients::Single(chunk.iter().map(|(_, f)| (column(f), 0.0)).collect())
            } else {
                Gradients::Dense(vec![0.0; chunk.len() * length])
            };
            groups.push(Group { place, functions, gradients });
        }
        Some(Self { functions: found.into_iter().map(|(_, f)| f).collect(), groups })
    }

    /// The groups of block `j`, which stand together.
    fn groups_of(&self, j: usize) -> std::ops::Range<usize> {
        let first = |j| self.groups.partition_point(|g| g.place.block < j);
        first(j)..first(j + 1)
    }

    /// Takes in the gradients of block `j`, which has been condensed.
    pub(super) fn load(&mut self, j: usize, block: &Block, n: usize, program: &StageProgram) {
        let groups = self.groups_of(j);
        for group in &mut self.groups[groups] {
            let functions = &mut self.functions[group.functions.clone()];
            match &mut group.gradients {
                Gradients::Single(entries) => {
                    for (f, entry) in functions.iter().zip(entries) {
                        entry.1 = f.entries.first().map_or(0.0, |&(_, slot)| program.rows[slot]);
                    }
                }
                Gradients::Dense(rows) => {
                    let Place { i, column, .. } = group.place;
                    for (f, row) in functions.iter_mut().zip(rows.chunks_exact_mut(block.stride() - column)) {
                        row.fill(0.0);
                        for &(place, slot) in &f.entries {
                            let v = program.rows[slot];
                            if place < n {
                                block.add_state((i, place), n, v, &mut row[block.first_column(i) - column..]);
                            } else {
                                row[block.column(i) + place - n - column] += v;
                            }
                        }
                        f.constant = row[row.len() - 1];
                    }
                }
            }
        }
    }

    /// The linear part aᵀw of every function.
    pub(super) fn values(&self, w: &[Vec<f64>], to: &mut [f64]) {
        for group in &self.groups {
            let (w, to) = (&w[group.place.block], &mut to[group.functions.clone()]);
            match &group.gradients {
                Gradients::Single(entries) => to.iter_mut().zip(entries).for_each(|(t, &(c, v))| *t = v * w[c]),
                Gradients::Dense(rows) => {
                    let w = &w[group.place.column..];
                    let rows = rows.chunks_exact(w.len() + 1);
                    to.iter_mut().zip(rows).for_each(|(t, row)| *t = dot(&row[..w.len()], w));
                }
            }
        }
    }

    /// Adds Σ force·a of the functions of block `j` to a gradient.
    pub(super) fn add_forces(&self, j: usize, forces: &[f64], to: &mut [f64]) {
        for group in &self.groups[self.groups_of(j)] {
            let forces = &forces[group.functions.clone()];
            match &group.gradients {
                Gradients::Single(entries) => forces.iter().zip(entries).for_each(|(f, &(c, v))| to[c] += v * f),
                Gradients::Dense(rows) => {
                    let to = &mut to[group.place.column..];
                    let rows = rows.chunks_exact(to.len() + 1);
                    forces.iter().zip(rows).for_each(|(f, row)| add_multiple(to, *f, &row[..to.len()]));
                }
            }
        }
    }

    /// Adds Σ weight·a aᵀ of the functions of block `j` to the upper triangle of a matrix.
    pub(super) fn add_squares(&self, j: usize, block: &Block, weights: &[f64], to: &mut [f64]) {
        let stride = block.stride();
        for group in &self.groups[self.groups_of(j)] {
            let weights = &weights[group.functions.clone()];
            match &group.gradients {
                Gradients::Single(entries) => {
                    weights.iter().zip(entries).for_each(|(f, &(c, v))| to[c * stride + c] += f * v * v);
                }
                Gradients::Dense(rows) => {
                    let column = group.place.column;
                    let length = stride - column;
                    add_weighted_squares(to, stride, column, (rows, length), length - 1, weights);
                }
            }
        }
    }
}
