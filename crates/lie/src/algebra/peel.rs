//! Rows that stand alone in a column, which ranks of sparse matrices need not eliminate.

use bracketry_symbolic::{Expr, Pool, Rational};

use crate::algebra::field::Field;

/// A matrix without its plain unit rows.
///
/// A row whose one entry, but for those in the columns of unit rows before it, is a number other than zero is a unit
/// row modulo them. The span of the rows is that of the unit rows and of the rest, which needs no entry in their columns.
pub(crate) struct Peeled {
    /// Numbers of the rows that are unit rows modulo those before them, with their columns, in order.
    pub(crate) units: Vec<(usize, usize)>,
    /// Numbers of the rows that are not, without those that vanish modulo the unit rows.
    pub(crate) rest: Vec<usize>,
    /// The columns in which the rest has entries, ascending.
    pub(crate) columns: Vec<usize>,
}

impl Peeled {
    /// Peels `rows` of the same length. A column in which a row of the rest has an entry is none of a later unit row, so that
    /// each row depends on those before it as it does here.
    pub(crate) fn of(pool: &Pool, rows: &[Field]) -> Self {
        let n = rows.first().map_or(0, Vec::len);
        let (mut peeled, mut used) = (vec![false; n], vec![false; n]);
        let (mut units, mut rest) = (Vec::new(), Vec::new());
        for (i, row) in rows.iter().enumerate() {
            let open: Vec<usize> = (0..n).filter(|&j| !peeled[j] && !pool.is_zero(row[j])).collect();
            let is_number = |e: Expr| pool.number(e).is_some_and(|r| *r != Rational::ZERO);
            match open[..] {
                [] => {}
                [j] if !used[j] && is_number(row[j]) => {
                    peeled[j] = true;
                    units.push((i, j));
                }
                _ => {
                    for j in open {
                        used[j] = true;
                    }
                    rest.push(i);
                }
            }
        }
        let columns = (0..n).filter(|&j| used[j]).collect();
        Peeled { units, rest, columns }
    }

    /// The rest of the matrix in its own columns.
    pub(crate) fn rest(&self, rows: &[Field]) -> Vec<Field> {
        self.rest.iter().map(|&i| self.columns.iter().map(|&j| rows[i][j]).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use bracketry_symbolic::Bindings;
    use proptest::prelude::*;

    proptest! {
        /// Unit rows and independent rows of the rest are those that are independent of the rows before them.
        #[test]
        fn the_first_independent_rows_are_those_of_the_whole_matrix(
            entries in prop::collection::vec(prop_oneof![3 => Just(0i8), 1 => -2i8..3, 1 => Just(9)], 1..60),
            n in 1usize..8,
        ) {
            let mut pool = Pool::new();
            let entry = |pool: &mut Pool, v: i8| if v == 9 { pool.parse("x").unwrap() } else { pool.int(v.into()) };
            let rows: Vec<Field> = entries
                .chunks_exact(n)
                .map(|r| r.iter().map(|&v| entry(&mut pool, v)).collect())
                .collect();
            prop_assume!(!rows.is_empty());
            let whole = pool.rank(&rows, &Bindings::new()).unwrap().independent;
            let peeled = Peeled::of(&pool, &rows);
            let mut found: Vec<usize> = peeled.units.iter().map(|u| u.0).collect();
            if !peeled.rest.is_empty() {
                let rest = pool.rank(&peeled.rest(&rows), &Bindings::new()).unwrap();
                found.extend(rest.independent.iter().map(|&i| peeled.rest[i]));
            }
            found.sort_unstable();
            prop_assert_eq!(found, whole);
        }
    }
}
