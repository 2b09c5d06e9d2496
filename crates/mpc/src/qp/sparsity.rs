//! Sparse matrices by their places.

use clarabel::algebra::CscMatrix;

/// Places of a sparse matrix, each with the slot that its value comes from.
pub(super) struct Pattern {
    rows: usize,
    columns: usize,
    entries: Vec<(usize, usize, u32)>,
}

impl Pattern {
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns, entries: Vec::new() }
    }

    /// Adds a place (row, column).
    pub(super) fn place(&mut self, row: usize, column: usize, slot: u32) {
        self.entries.push((column, row, slot));
    }

    /// The matrix with zeros, and the slots in the order of its values.
    pub(super) fn build(mut self) -> (CscMatrix<f64>, Vec<u32>) {
        self.entries.sort_unstable();
        let mut column_start = vec![0; self.columns + 1];
        for &(column, ..) in &self.entries {
            column_start[column + 1] += 1;
        }
        for c in 0..self.columns {
            column_start[c + 1] += column_start[c];
        }
        let row_index = self.entries.iter().map(|e| e.1).collect();
        let values = vec![0.0; self.entries.len()];
        let matrix = CscMatrix::new(self.rows, self.columns, column_start, row_index, values);
        (matrix, self.entries.into_iter().map(|e| e.2).collect())
    }
}
