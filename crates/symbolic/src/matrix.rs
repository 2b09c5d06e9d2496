//! Matrices of expressions, by their rows.
//!
//! `simplify` is applied to what is formed on the way: the form of the result, and how far it grows, is the caller's choice.

use rustc_hash::FxHashMap;

use crate::node::Expr;
use crate::pool::Pool;

impl Pool {
    /// The determinant of a square matrix, from the minors of its last rows (Laplace): at most n 2^n products.
    ///
    /// ```
    /// use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let rows = [["a", "b"], ["c", "d"]].map(|row| row.map(|e| p.parse(e).unwrap()).to_vec());
    /// let d = p.determinant(&rows, Pool::simplify);
    /// assert_eq!(p.text(d), "a*d - b*c");
    /// ```
    pub fn determinant(&mut self, rows: &[Vec<Expr>], mut simplify: impl FnMut(&mut Self, Expr) -> Expr) -> Expr {
        // minors[set of columns]: determinant of the last rows in these columns.
        let mut minors = vec![(0usize, self.int(1))];
        for row in rows.iter().rev() {
            let mut larger: FxHashMap<usize, Vec<Expr>> = FxHashMap::default();
            for &(set, minor) in &minors {
                for (j, &entry) in row.iter().enumerate().filter(|(j, _)| set >> j & 1 == 0) {
                    if self.is_zero(entry) {
                        continue;
                    }
                    let before = (set & ((1 << j) - 1)).count_ones();
                    let product = self.mul(entry, minor);
                    let term = if before % 2 == 0 { product } else { self.neg(product) };
                    larger.entry(set | 1 << j).or_default().push(term);
                }
            }
            let mut sums: Vec<(usize, Vec<Expr>)> = larger.into_iter().collect();
            sums.sort_unstable_by_key(|m| m.0);
            minors.clear();
            for (set, terms) in sums {
                let sum = self.sum(terms);
                let minor = simplify(self, sum);
                minors.push((set, minor));
            }
        }
        minors.first().map_or_else(|| self.int(0), |m| m.1)
    }

    /// The solution of A x = b for a matrix with the given determinant other than 0 (Cramer's rule): it divides by the determinant
    /// alone.
    pub fn cramer(
        &mut self,
        a: &[Vec<Expr>],
        b: &[Expr],
        determinant: Expr,
        mut simplify: impl FnMut(&mut Self, Expr) -> Expr,
    ) -> Vec<Expr> {
        (0..a.len())
            .map(|j| {
                let mut replaced = a.to_vec();
                replaced.iter_mut().zip(b).for_each(|(row, &b)| row[j] = b);
                let top = self.determinant(&replaced, &mut simplify);
                self.div(top, determinant)
            })
            .collect()
    }

    /// Scales row `i` to 1 in column `j`, where it must not vanish, and clears that column in all other rows (Gauss–Jordan).
    pub fn eliminate_column(
        &mut self,
        rows: &mut [Vec<Expr>],
        (i, j): (usize, usize),
        mut simplify: impl FnMut(&mut Self, Expr) -> Expr,
    ) {
        let leading = rows[i][j];
        for e in &mut rows[i] {
            let quotient = self.div(*e, leading);
            *e = simplify(self, quotient);
        }
        let pivot = rows[i].clone();
        for row in rows.iter_mut().enumerate().filter(|(k, _)| *k != i).map(|(_, row)| row) {
            let factor = row[j];
            if self.is_zero(factor) {
                continue;
            }
            for (e, &p) in row.iter_mut().zip(&pivot) {
                let product = self.mul(factor, p);
                let difference = self.sub(*e, product);
                *e = simplify(self, difference);
            }
        }
    }
}
