//! Which products have to be added where when variables of a stage program are eliminated.

use super::program::StageProgram;
use super::sparsity::Pattern;
use clarabel::algebra::CscMatrix;
use std::collections::BTreeMap;

/// work[to] += work[from]·coefficient[by].
#[derive(Clone, Copy)]
pub(super) struct Product {
    pub(super) to: u32,
    pub(super) from: u32,
    pub(super) by: u32,
}

/// Where a coefficient comes from.
#[derive(Clone, Copy)]
pub(super) enum Coefficient {
    Flow(usize),
    Defect(usize),
    NegativeDefect(usize),
    Offset(usize),
    NegativeOffset(usize),
    One,
}

/// An eliminated variable with what is needed to find its value and its multiplier again.
pub(super) struct Eliminated {
    pub(super) variable: usize,
    /// Variables it depends on, with their coefficients.
    pub(super) parents: Vec<(usize, u32)>,
    pub(super) constant: u32,
    /// Row of the multipliers, for a state.
    pub(super) multiplier: Option<usize>,
    /// Its row of the Hessian and its column of the constraints, when it was eliminated: (slot, variable), (slot, row).
    pub(super) curvature: Vec<(u32, usize)>,
    pub(super) rows: Vec<(u32, usize)>,
    pub(super) gradient: u32,
}

/// A slot of the work that is filled from an entry of the program.
#[derive(Clone, Copy)]
pub(super) enum Source {
    Hessian(usize),
    Gradient(usize),
    Row(usize),
    Right(usize),
}

/// Begin of the parts of the work.
#[derive(Clone, Copy)]
pub(super) struct Sections {
    pub(super) gradient: usize,
    pub(super) rows: usize,
    pub(super) right: usize,
    pub(super) dynamics_right: usize,
}

/// Structure while variables are being eliminated.
pub(super) struct Builder {
    pub(super) slots: usize,
    /// Slots of the Hessian: for every variable its neighbors.
    pub(super) hessian: Vec<BTreeMap<usize, u32>>,
    /// Slots of the constraints: for every variable its rows.
    pub(super) columns: Vec<BTreeMap<usize, u32>>,
    pub(super) gradient: Vec<u32>,
    pub(super) right: Vec<u32>,
    pub(super) products: Vec<Product>,
    pub(super) sources: Vec<Coefficient>,
}

impl Sections {
    pub(super) fn new(program: &StageProgram) -> Self {
        let gradient = program.hessian.len();
        let rows = gradient + program.gradient.len();
        let right = rows + program.rows.len();
        Self { gradient, rows, right, dynamics_right: right + program.right.len() }
    }

    /// Slots of the first interval, with the entries of the program that fill them.
    pub(super) fn first_loads(self, program: &StageProgram) -> Vec<(usize, Source)> {
        let end = program.first.get(1).copied().unwrap_or(program.gradient.len());
        let hessian = program.hessian_places.iter().enumerate().filter(|(_, (i, j))| *i < end && *j < end);
        let mut loads: Vec<_> = hessian.map(|(s, _)| (s, Source::Hessian(s))).collect();
        loads.extend((0..end).map(|v| (self.gradient + v, Source::Gradient(v))));
        let first = |row: usize| program.row_stage[row] == 0;
        let entries = program.row_places.iter().enumerate().filter(|(_, (row, _))| first(*row));
        loads.extend(entries.map(|(s, _)| (self.rows + s, Source::Row(s))));
        let rows = (0..program.right.len()).filter(|&row| first(row));
        loads.extend(rows.map(|row| (self.right + row, Source::Right(row))));
        loads
    }
}

/// Variables that state i at the end of interval k depends on, with the places of their coefficients in the flow.
pub(super) fn parents(program: &StageProgram, k: usize, i: usize) -> impl Iterator<Item = (usize, usize)> {
    let (n, w) = (program.states, program.states + program.inputs);
    let possible = (0..w).filter(move |&j| program.flow_pattern[i * w + j]);
    possible.filter_map(move |j| program.variable(k, j).map(|v| (v, (k * n + i) * w + j)))
}

impl Builder {
    /// The structure of a program, the constraints after `dynamics` rows of the dynamics.
    pub(super) fn new(program: &StageProgram, sections: Sections, dynamics: usize) -> Self {
        let Sections { gradient, rows, right, dynamics_right } = sections;
        let variables = program.gradient.len();
        let mut b = Self {
            slots: dynamics_right + dynamics,
            hessian: vec![BTreeMap::new(); variables],
            columns: vec![BTreeMap::new(); variables],
            gradient: (gradient..rows).map(|s| s as u32).collect(),
            right: (dynamics_right..dynamics_right + dynamics).chain(right..dynamics_right).map(|s| s as u32).collect(),
            products: Vec::new(),
            sources: Vec::new(),
        };
        for (s, &(i, j)) in program.hessian_places.iter().enumerate() {
            b.hessian[i].insert(j, s as u32);
            b.hessian[j].insert(i, s as u32);
        }
        for (s, &(row, variable)) in program.row_places.iter().enumerate() {
            b.columns[variable].insert(dynamics + row, (rows + s) as u32);
        }
        b
    }

    /// Eliminates the marked states and the shared inputs from the end of the horizon to its start; also returns the
    /// operations that do not touch numbers of the first interval, the others stay in `products`.
    pub(super) fn eliminate_backward(
        &mut self,
        program: &StageProgram,
        eliminate: impl Fn(usize, usize) -> bool,
    ) -> (Vec<Eliminated>, Vec<Product>) {
        let (n, m) = (program.states, program.inputs);
        let (mut eliminated, mut early) = (Vec::new(), Vec::new());
        let one = self.coefficient(Coefficient::One);
        for k in (0..program.steps).rev() {
            if k == 0 {
                early = std::mem::take(&mut self.products);
            }
            for i in (0..n).filter(|&i| eliminate(k + 1, i)) {
                let flow = |(v, place)| (v, self.coefficient(Coefficient::Flow(place)));
                let parents = parents(program, k, i).map(flow).collect();
                let constant = self.coefficient(Coefficient::Defect(k * n + i));
                let negative = self.coefficient(Coefficient::NegativeDefect(k * n + i));
                let q = program.state(k + 1, i);
                eliminated.push(self.eliminate(q, parents, constant, negative, Some(k * n + i)));
            }
            for (j, parent) in (0..m).filter_map(|j| Some((j, program.equal_input(k, j)?))) {
                let constant = self.coefficient(Coefficient::Offset(k * m + j));
                let negative = self.coefficient(Coefficient::NegativeOffset(k * m + j));
                let q = program.input(k, j);
                eliminated.push(self.eliminate(q, vec![(parent, one)], constant, negative, None));
            }
        }
        (eliminated, early)
    }

    /// The matrices P, A of the variables that stay, each with the slots of its values.
    pub(super) fn matrices(&self, kept: &[usize]) -> [(CscMatrix<f64>, Vec<u32>); 2] {
        let mut number = vec![0; self.hessian.len()];
        for (i, &v) in kept.iter().enumerate() {
            number[v] = i;
        }
        let mut hessian = Pattern::new(kept.len(), kept.len());
        let mut constraints = Pattern::new(self.right.len(), kept.len());
        for &v in kept {
            for (&r, &s) in self.hessian[v].range(v..) {
                hessian.place(number[v], number[r], s);
            }
            for (&row, &s) in &self.columns[v] {
                constraints.place(row, number[v], s);
            }
        }
        [hessian.build(), constraints.build()]
    }

    fn slot(&mut self) -> u32 {
        self.slots += 1;
        self.slots as u32 - 1
    }

    fn coefficient(&mut self, source: Coefficient) -> u32 {
        self.sources.push(source);
        self.sources.len() as u32 - 1
    }

    fn hessian(&mut self, i: usize, j: usize) -> u32 {
        if let Some(&s) = self.hessian[i].get(&j) {
            return s;
        }
        let s = self.slot();
        self.hessian[i].insert(j, s);
        self.hessian[j].insert(i, s);
        s
    }

    pub(super) fn constraint(&mut self, row: usize, variable: usize) -> u32 {
        if let Some(&s) = self.columns[variable].get(&row) {
            return s;
        }
        let s = self.slot();
        self.columns[variable].insert(row, s);
        s
    }

    fn product(&mut self, to: u32, from: u32, by: u32) {
        self.products.push(Product { to, from, by });
    }

    /// Replaces variable q = Σ a_p p + c; `constant` and `negative` are the coefficients c and −c.
    fn eliminate(
        &mut self,
        q: usize,
        parents: Vec<(usize, u32)>,
        constant: u32,
        negative: u32,
        multiplier: Option<usize>,
    ) -> Eliminated {
        let neighbors = std::mem::take(&mut self.hessian[q]);
        let own = neighbors.get(&q).copied();
        let gradient = self.gradient[q];
        for (&r, &s) in neighbors.iter().filter(|(r, _)| **r != q) {
            self.hessian[r].remove(&q);
            self.product(self.gradient[r], s, constant);
            for &(p, a) in &parents {
                let to = self.hessian(p, r);
                self.product(to, s, a);
                if p == r {
                    self.product(to, s, a);
                }
            }
        }
        if let Some(s) = own {
            for (i, &(p, a)) in parents.iter().enumerate() {
                let scaled = self.slot();
                self.product(scaled, s, a);
                self.product(self.gradient[p], scaled, constant);
                for &(r, b) in &parents[i..] {
                    let to = self.hessian(p, r);
                    self.product(to, scaled, b);
                }
            }
        }
        for &(p, a) in &parents {
            self.product(self.gradient[p], gradient, a);
        }
        let rows = std::mem::take(&mut self.columns[q]);
        for (&row, &s) in &rows {
            self.product(self.right[row], s, negative);
            for &(p, a) in &parents {
                let to = self.constraint(row, p);
                self.product(to, s, a);
            }
        }
        Eliminated {
            variable: q,
            parents,
            constant,
            multiplier,
            curvature: neighbors.into_iter().map(|(r, s)| (s, r)).collect(),
            rows: rows.into_iter().map(|(r, s)| (s, r)).collect(),
            gradient,
        }
    }
}
