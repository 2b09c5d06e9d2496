//! Where the numbers of the quadratic program stand.

use clarabel::algebra::CscMatrix;

/// Compressed columns that are filled slot by slot.
pub(crate) struct Pattern {
    rows: usize,
    columns: usize,
    entries: Vec<(usize, usize)>,
}

impl Pattern {
    pub(crate) fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns, entries: Vec::new() }
    }

    /// Adds a place (row, column) and returns its slot.
    pub(crate) fn place(&mut self, row: usize, column: usize) -> usize {
        self.entries.push((row, column));
        self.entries.len() - 1
    }

    /// The matrix with zeros, and the position in its value array of every slot.
    pub(crate) fn build(self) -> (CscMatrix<f64>, Vec<usize>) {
        let mut order: Vec<usize> = (0..self.entries.len()).collect();
        order.sort_unstable_by_key(|&s| (self.entries[s].1, self.entries[s].0));
        let mut position = vec![0; order.len()];
        let mut column_start = vec![0; self.columns + 1];
        let mut row_index = Vec::with_capacity(order.len());
        for (p, &s) in order.iter().enumerate() {
            position[s] = p;
            row_index.push(self.entries[s].0);
            column_start[self.entries[s].1 + 1] += 1;
        }
        for c in 0..self.columns {
            column_start[c + 1] += column_start[c];
        }
        let values = vec![0.0; order.len()];
        (CscMatrix::new(self.rows, self.columns, column_start, row_index, values), position)
    }
}

/// Where the variables of a stage stand.
#[derive(Clone, Copy)]
pub(crate) struct Index {
    pub(crate) n: usize,
    pub(crate) m: usize,
    pub(crate) nb: usize,
    pub(crate) steps: usize,
}

impl Index {
    pub(crate) fn stride(self) -> usize {
        self.n + self.m + self.nb
    }
    /// Stage k ≥ 1 starts with dx_k.
    pub(crate) fn x(self, k: usize, i: usize) -> usize {
        self.m + (k - 1) * self.stride() + i
    }
    /// The last stage has no input: its slacks follow the states.
    pub(crate) fn slack(self, k: usize, place: usize) -> usize {
        self.x(k, self.n) + place
    }
    pub(crate) fn u(self, k: usize, j: usize) -> usize {
        if k == 0 { j } else { self.x(k, self.n) + self.nb + j }
    }
    pub(crate) fn tau(self, j: usize) -> usize {
        self.steps * self.stride() + j
    }
    /// Variable v of the list (x, u) at grid point k; `None` for x_0, which is fixed.
    pub(crate) fn variable(self, k: usize, v: usize) -> Option<usize> {
        if v >= self.n {
            Some(self.u(k, v - self.n))
        } else if k > 0 {
            Some(self.x(k, v))
        } else {
            None
        }
    }
}
