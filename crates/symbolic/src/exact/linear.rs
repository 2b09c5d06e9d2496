//! Dense linear algebra over the prime fields.

use super::field::Residue;

/// Reduced row echelon form of a matrix, which can grow row by row.
///
/// ```
/// use bracketry_symbolic::{Echelon, Fp};
/// let row = |v: [i64; 3]| v.map(Fp::from_i64).to_vec();
/// let mut span = Echelon::<1>::empty(3);
/// assert!(span.insert(row([1, 2, 3])));
/// assert!(span.insert(row([0, 1, 1])));
/// assert!(!span.insert(row([2, 5, 7])));
/// assert!(span.contains(&row([1, 3, 4])) && !span.contains(&row([0, 0, 1])));
/// assert_eq!((span.rank(), span.independent.as_slice()), (2, [0, 1].as_slice()));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Echelon<const C: u64 = 1> {
    /// The rows other than zero of the reduced row echelon form.
    pub rows: Vec<Vec<Residue<C>>>,
    /// Column of the leading 1 of each row, ascending.
    pub pivots: Vec<usize>,
    /// Numbers of the inserted rows that were independent of those before them.
    pub independent: Vec<usize>,
    columns: usize,
    inserted: usize,
}

impl<const C: u64> Echelon<C> {
    /// No rows yet, of `columns` entries each.
    pub fn empty(columns: usize) -> Self {
        Self { rows: Vec::new(), pivots: Vec::new(), independent: Vec::new(), columns, inserted: 0 }
    }

    /// Reduces the matrix with the given rows, all of length `columns` (shorter ones count as filled with zeros).
    pub fn new(matrix: &[Vec<Residue<C>>], columns: usize) -> Self {
        let mut e = Self::empty(columns);
        for row in matrix {
            if e.rows.len() == columns {
                break;
            }
            e.insert(row.clone());
        }
        e
    }

    /// What is left of a row modulo the span: 0 in every pivot column. A shorter row counts as filled with zeros, and
    /// entries beyond the last column are left out.
    #[must_use]
    pub fn reduce(&self, mut row: Vec<Residue<C>>) -> Vec<Residue<C>> {
        row.resize(self.columns, Residue::ZERO);
        for (r, &p) in self.rows.iter().zip(&self.pivots) {
            eliminate(&mut row, r, p);
        }
        row
    }

    /// True if the row is in the span.
    pub fn contains(&self, row: &[Residue<C>]) -> bool {
        self.reduce(row.to_vec()).iter().all(|v| v.is_zero())
    }

    /// Adds a row; false if it was in the span already.
    pub fn insert(&mut self, row: Vec<Residue<C>>) -> bool {
        let number = self.inserted;
        self.inserted += 1;
        let mut row = self.reduce(row);
        let Some((p, lead)) = row.iter().copied().enumerate().find(|(_, v)| !v.is_zero()) else {
            return false;
        };
        let scale = lead.inv().unwrap_or(Residue::ONE);
        for v in &mut row[p..] {
            *v *= scale;
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

    /// A basis of the vectors v with M·v = 0, one for each column without a pivot.
    pub fn nullspace(&self) -> Vec<Vec<Residue<C>>> {
        let free = (0..self.columns).filter(|c| self.pivots.binary_search(c).is_err());
        free.map(|c| {
            let mut v = vec![Residue::ZERO; self.columns];
            v[c] = Residue::ONE;
            for (r, &p) in self.rows.iter().zip(&self.pivots) {
                v[p] = -r[c];
            }
            v
        })
        .collect()
    }
}

/// row −= row[p]·pivot, where pivot[p] = 1.
fn eliminate<const C: u64>(row: &mut [Residue<C>], pivot: &[Residue<C>], p: usize) {
    let f = row[p];
    if f.is_zero() {
        return;
    }
    for (v, &w) in row.iter_mut().zip(pivot) {
        *v -= f * w;
    }
}

/// The coefficients by which `target` is a combination of `columns`.
///
/// `Ok(None)` if it is independent of them; `Err(())` if the columns themselves are dependent.
pub(super) fn combination<const C: u64>(
    columns: &[Vec<Residue<C>>],
    target: &[Residue<C>],
) -> Result<Option<Vec<Residue<C>>>, ()> {
    let k = columns.len();
    let rows: Vec<Vec<Residue<C>>> =
        (0..target.len()).map(|i| columns.iter().map(|c| c[i]).chain([target[i]]).collect()).collect();
    let e = Echelon::new(&rows, k + 1);
    if e.pivots.get(..k).is_none_or(|p| p.iter().enumerate().any(|(i, &q)| i != q)) {
        return Err(());
    }
    if e.rank() > k {
        return Ok(None);
    }
    Ok(Some(e.rows.iter().map(|r| r[k]).collect()))
}

/// [`combination`] modulo a small prime `l`.
pub(super) fn combination_mod(l: u64, columns: &[Vec<u64>], target: &[u64]) -> Result<Option<Vec<u64>>, ()> {
    let k = columns.len();
    let mut rows: Vec<Vec<u64>> =
        (0..target.len()).map(|i| columns.iter().map(|c| c[i]).chain([target[i]]).collect()).collect();
    // Every column must have its pivot in the row of its own number.
    for c in 0..k {
        let i = (c..rows.len()).find(|&i| rows[i][c] != 0).ok_or(())?;
        rows.swap(c, i);
        let inverse = (1..l).find(|x| x * rows[c][c] % l == 1).ok_or(())?;
        rows[c].iter_mut().for_each(|v| *v = *v * inverse % l);
        let pivot = rows[c].clone();
        for (j, r) in rows.iter_mut().enumerate() {
            if j != c && r[c] != 0 {
                let f = l - r[c];
                r.iter_mut().zip(&pivot).for_each(|(v, w)| *v = (*v + f * w) % l);
            }
        }
    }
    if rows[k..].iter().any(|r| r[k] != 0) {
        return Ok(None);
    }
    Ok(Some(rows[..k].iter().map(|r| r[k]).collect()))
}

#[cfg(test)]
mod tests {
    use super::super::field::{Fp, Random};
    use super::*;

    fn product(a: &[Vec<Fp>], b: &[Vec<Fp>]) -> Vec<Vec<Fp>> {
        let columns = b.first().map_or(0, Vec::len);
        a.iter()
            .map(|r| (0..columns).map(|j| r.iter().zip(b).fold(Fp::ZERO, |s, (&x, row)| s + x * row[j])).collect())
            .collect()
    }

    fn random(rng: &mut Random, rows: usize, columns: usize) -> Vec<Vec<Fp>> {
        (0..rows).map(|_| (0..columns).map(|_| rng.residue()).collect()).collect()
    }

    #[test]
    fn rank_of_a_product_is_its_inner_dimension_and_its_nullspace_is_annihilated() {
        let mut rng = Random::new(3);
        for (m, k, n) in [(1, 1, 1), (4, 2, 7), (7, 3, 4), (5, 5, 5), (9, 0, 3), (32, 17, 32)] {
            let (a, b) = (random(&mut rng, m, k), random(&mut rng, k, n));
            let ab = if k == 0 { vec![vec![Fp::ZERO; n]; m] } else { product(&a, &b) };
            let e = Echelon::new(&ab, n);
            assert_eq!(e.rank(), k);
            assert_eq!(e.independent, (0..k).collect::<Vec<_>>());
            assert!(ab.iter().all(|r| e.contains(r)));
            // Reducing is a projection, and a row plus what it lacks is in the span.
            let v: Vec<Fp> = (0..n).map(|_| rng.residue()).collect();
            let rest = e.reduce(v.clone());
            assert_eq!(e.reduce(rest.clone()), rest);
            assert!(e.contains(&v.iter().zip(&rest).map(|(&x, &y)| x - y).collect::<Vec<_>>()));
            assert_eq!(e.contains(&v), k == n);
            let kernel = e.nullspace();
            assert_eq!(kernel.len(), n - k);
            for v in kernel {
                assert!(ab.iter().all(|r| r.iter().zip(&v).fold(Fp::ZERO, |s, (&x, &y)| s + x * y).is_zero()));
            }
        }
    }

    #[test]
    fn combinations_modulo_small_primes() {
        let columns = vec![vec![1, 0, 2, 5], vec![0, 1, 3, 1]];
        let target = vec![2, 6, 2 * 2 + 6 * 3, 2 * 5 + 6].into_iter().map(|x: u64| x % 7).collect::<Vec<_>>();
        assert_eq!(combination_mod(7, &columns, &target), Ok(Some(vec![2, 6])));
        assert_eq!(combination_mod(7, &columns, &[0, 0, 0, 1]), Ok(None));
        assert_eq!(combination_mod(7, &[vec![0, 0]], &[0, 1]), Err(()));
    }
}
