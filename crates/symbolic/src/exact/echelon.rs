//! Reduced row echelon forms over a field.

use super::field_element::{FieldElement, SmallResidue};

/// Reduced row echelon form of a matrix, which can grow row by row.
///
/// ```
/// use bracketry_symbolic::{Echelon, Fp};
/// let row = |v: [i64; 3]| v.map(Fp::from_i64).to_vec();
/// let mut span = Echelon::empty(3);
/// assert!(span.insert(row([1, 2, 3])));
/// assert!(span.insert(row([0, 1, 1])));
/// assert!(!span.insert(row([2, 5, 7])));
/// assert!(span.contains(&row([1, 3, 4])) && !span.contains(&row([0, 0, 1])));
/// assert_eq!((span.rank(), span.independent.as_slice()), (2, [0, 1].as_slice()));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Echelon<F> {
    /// The rows other than zero of the reduced row echelon form.
    pub rows: Vec<Vec<F>>,
    /// Column of the leading 1 of each row, ascending.
    pub pivots: Vec<usize>,
    /// Numbers of the inserted rows that were independent of those before them.
    pub independent: Vec<usize>,
    columns: usize,
    inserted: usize,
}

impl<F: FieldElement> Echelon<F> {
    /// No rows yet, of `columns` entries each.
    pub fn empty(columns: usize) -> Self {
        Self { rows: Vec::new(), pivots: Vec::new(), independent: Vec::new(), columns, inserted: 0 }
    }

    /// Reduces the matrix with the given rows, all of length `columns` (shorter ones count as filled with zeros).
    pub fn new(matrix: &[Vec<F>], columns: usize) -> Self {
        let mut e = Self::empty(columns);
        for row in matrix {
            if e.rows.len() == columns {
                break;
            }
            e.insert(row.clone());
        }
        e
    }

    /// The smallest subspace with the vectors of `start`, of length `n`, that a linear map takes into itself.
    pub fn invariant(start: &[Vec<F>], n: usize, map: impl Fn(&[F]) -> Vec<F>) -> Self {
        let mut span = Self::empty(n);
        let mut open = start.to_vec();
        while let Some(v) = open.pop() {
            if span.insert(v.clone()) {
                open.push(map(&v));
            }
        }
        span
    }

    /// What is left of a row modulo the span: 0 in every pivot column. A shorter row counts as filled with zeros, and
    /// entries beyond the last column are left out.
    #[must_use]
    pub fn reduce(&self, mut row: Vec<F>) -> Vec<F> {
        row.resize(self.columns, F::ZERO);
        for (r, &p) in self.rows.iter().zip(&self.pivots) {
            eliminate(&mut row, r, p);
        }
        row
    }

    /// True if the row is in the span.
    pub fn contains(&self, row: &[F]) -> bool {
        self.reduce(row.to_vec()).iter().all(F::is_zero)
    }

    /// Adds a row; false if it was in the span already.
    pub fn insert(&mut self, row: Vec<F>) -> bool {
        let number = self.inserted;
        self.inserted += 1;
        let mut row = self.reduce(row);
        let Some((p, scale)) = row.iter().enumerate().find_map(|(p, lead)| Some((p, lead.inverse()?))) else {
            return false;
        };
        for v in &mut row[p..] {
            v.scale(&scale);
        }
        for r in &mut self.rows {
            eliminate(r, &row, p);
        }
        let at = self.pivots.partition_point(|&q| q < p);
        self.pivots.insert(at, p);
        self.rows.insert(at, row);
        self.independent.push(number);
        true
    }

    /// Number of independent rows.
    pub fn rank(&self) -> usize {
        self.rows.len()
    }

    /// The columns without a pivot, ascending.
    pub fn free_columns(&self) -> impl Iterator<Item = usize> {
        (0..self.columns).filter(|c| self.pivots.binary_search(c).is_err())
    }

    /// A basis of the vectors v with M·v = 0, one for each column without a pivot, with 1 there.
    pub fn null_space(&self) -> Vec<Vec<F>> {
        self.free_columns()
            .map(|c| {
                let mut v = vec![F::ZERO; self.columns];
                v[c] = F::ONE;
                for (r, &p) in self.rows.iter().zip(&self.pivots) {
                    v[p].subtract_product(&r[c], &F::ONE);
                }
                v
            })
            .collect()
    }
}

/// row −= row[p]·pivot, where pivot[p] = 1 is its first entry other than zero.
fn eliminate<F: FieldElement>(row: &mut [F], pivot: &[F], p: usize) {
    let f = row[p].clone();
    if f.is_zero() {
        return;
    }
    for (v, w) in row.iter_mut().zip(pivot).skip(p) {
        v.subtract_product(&f, w);
    }
}

/// The coefficients by which `target` is a combination of `columns`.
///
/// `Ok(None)` if it is independent of them; `Err(())` if the columns themselves are dependent.
pub(super) fn combination<F: FieldElement>(columns: &[Vec<F>], target: &[F]) -> Result<Option<Vec<F>>, ()> {
    let k = columns.len();
    let row = |i: usize| columns.iter().chain([&target.to_vec()]).map(|c| c[i].clone()).collect();
    let rows: Vec<Vec<F>> = (0..target.len()).map(row).collect();
    let e = Echelon::new(&rows, k + 1);
    if e.pivots.get(..k).is_none_or(|p| p.iter().enumerate().any(|(i, &q)| i != q)) {
        return Err(());
    }
    if e.rank() > k {
        return Ok(None);
    }
    Ok(Some(e.rows.iter().map(|r| r[k].clone()).collect()))
}

/// [`combination`] of numbers modulo a small prime.
pub(super) fn combination_modulo<const L: u64>(columns: &[Vec<u64>], target: &[u64]) -> Result<Option<Vec<u64>>, ()> {
    let classes = |c: &[u64]| -> Vec<SmallResidue<L>> { c.iter().map(|&v| SmallResidue::new(v)).collect() };
    let columns: Vec<_> = columns.iter().map(|c| classes(c)).collect();
    Ok(combination(&columns, &classes(target))?.map(|c| c.into_iter().map(SmallResidue::value).collect()))
}
