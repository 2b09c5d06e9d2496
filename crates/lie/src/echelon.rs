//! Rows over the prime field, reduced as they arrive.

use bracketry_symbolic::Fp;

/// A set of independent rows in reduced echelon form that grows one row at a time.
#[derive(Clone, Default)]
pub(crate) struct Echelon {
    /// (pivot column, row with 1 in that column), in order of arrival.
    rows: Vec<(usize, Vec<Fp>)>,
}

impl Echelon {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Rows whose span is that of `rows`.
    pub(crate) fn of(rows: &[Vec<Fp>]) -> Self {
        let mut e = Self::new();
        for r in rows {
            e.insert(r.clone());
        }
        e
    }

    pub(crate) fn rank(&self) -> usize {
        self.rows.len()
    }

    /// What is left of `row` modulo the span.
    pub(crate) fn reduce(&self, mut row: Vec<Fp>) -> Vec<Fp> {
        for (p, r) in &self.rows {
            let c = row[*p];
            if c != Fp::ZERO {
                for (x, &y) in row.iter_mut().zip(r) {
                    *x -= c * y;
                }
            }
        }
        row
    }

    pub(crate) fn contains(&self, row: &[Fp]) -> bool {
        self.reduce(row.to_vec()).iter().all(|x| *x == Fp::ZERO)
    }

    /// For every column, whether the span holds the row that is 1 there and 0 elsewhere.
    pub(crate) fn units(&self, columns: usize) -> Vec<bool> {
        let mut units = vec![false; columns];
        for (p, row) in &self.rows {
            units[*p] = row.iter().enumerate().all(|(j, x)| j == *p || *x == Fp::ZERO);
        }
        units
    }

    /// Adds a row; false if it was in the span already.
    pub(crate) fn insert(&mut self, row: Vec<Fp>) -> bool {
        let mut row = self.reduce(row);
        let Some(p) = row.iter().position(|x| *x != Fp::ZERO) else { return false };
        let Some(inverse) = row[p].inv() else { return false };
        for x in &mut row {
            *x *= inverse;
        }
        for (_, r) in &mut self.rows {
            let c = r[p];
            if c != Fp::ZERO {
                for (x, &y) in r.iter_mut().zip(&row) {
                    *x -= c * y;
                }
            }
        }
        self.rows.push((p, row));
        true
    }

    /// A basis of {c : row · c = 0 for all rows}, for rows of length `columns`.
    ///
    /// One vector per column without pivot, with 1 in that column and 0 in the other ones.
    pub(crate) fn nullspace(&self, columns: usize) -> Vec<Vec<Fp>> {
        let mut pivot = vec![None; columns];
        for (i, (p, _)) in self.rows.iter().enumerate() {
            pivot[*p] = Some(i);
        }
        (0..columns)
            .filter(|&j| pivot[j].is_none())
            .map(|j| {
                let mut c = vec![Fp::ZERO; columns];
                c[j] = Fp::ONE;
                for (p, r) in &self.rows {
                    c[*p] = -r[j];
                }
                c
            })
            .collect()
    }
}
