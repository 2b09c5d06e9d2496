//! The prime field of sampled ranks.

use bracketry_symbolic::{Residue, SECOND_OFFSET};

/// The prime is 2^61 less this: modulo it, the values at a point such as π/3 exist too, √2 … √53, √9.81, and the sines of π/1800.
pub(crate) const OFFSET: u64 = SECOND_OFFSET;
/// An integer modulo 2^61 − [`OFFSET`].
pub(crate) type Fp = Residue<OFFSET>;
/// Reduced row echelon form over this field.
pub(crate) type Echelon = bracketry_symbolic::Echelon<Fp>;

/// The row with 1 at place i and 0 elsewhere.
pub(crate) fn unit_row<const C: u64>(i: usize, n: usize) -> Vec<Residue<C>> {
    (0..n).map(|j| if i == j { Residue::ONE } else { Residue::ZERO }).collect()
}

/// The product of a matrix, given by its rows, with a vector.
pub(crate) fn times(rows: &[Vec<Fp>], v: &[Fp]) -> Vec<Fp> {
    rows.iter().map(|row| row.iter().zip(v).fold(Fp::ZERO, |s, (&x, &y)| s + x * y)).collect()
}

/// A span with its coordinate vectors apart: a sparse basis costs little.
#[derive(Clone)]
pub(crate) struct Span {
    /// Whether the span holds this coordinate vector.
    pub(crate) units: Vec<bool>,
    /// The rest, with zeros in their columns.
    rest: Echelon,
    /// Products that eliminations took so far.
    pub(crate) products: f64,
}

impl Span {
    /// Of vectors with `n` entries, none so far.
    pub(crate) fn empty(n: usize) -> Self {
        Span { units: vec![false; n], rest: Echelon::empty(n), products: 0.0 }
    }

    /// What is left of a row modulo the span.
    pub(crate) fn reduce(&mut self, mut row: Vec<Fp>) -> Vec<Fp> {
        self.clear_units(&mut row);
        self.products += (self.rest.rank() * row.len()) as f64;
        self.rest.reduce(row)
    }

    fn clear_units(&self, row: &mut [Fp]) {
        row.iter_mut().zip(&self.units).filter(|(_, unit)| **unit).for_each(|(x, _)| *x = Fp::ZERO);
    }

    /// Adds a row; false if it was in the span already.
    pub(crate) fn insert(&mut self, mut row: Vec<Fp>) -> bool {
        self.clear_units(&mut row);
        self.products += 2.0 * (self.rest.rank() * row.len()) as f64;
        if !self.rest.insert(row) {
            return false;
        }
        // Rows that have become coordinate vectors take the others' entries with them, which makes no further ones: each row
        // has zeros where the others lead.
        let alone = |row: &[Fp], p: usize| row[p + 1..].iter().all(|x| x.is_zero());
        let found: Vec<usize> =
            (0..self.rest.rank()).filter(|&r| alone(&self.rest.rows[r], self.rest.pivots[r])).collect();
        for r in found.into_iter().rev() {
            self.rest.rows.remove(r);
            self.units[self.rest.pivots.remove(r)] = true;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// What is independent and what is left of a row are as in the reduced echelon form.
        #[test]
        fn spans_are_those_of_the_echelon_form(
            entries in prop::collection::vec(prop_oneof![4 => Just(0u64), 1 => 0u64..5], 1..80),
            n in 1usize..9,
        ) {
            let (mut span, mut echelon) = (Span::empty(n), Echelon::empty(n));
            for row in entries.chunks_exact(n) {
                let row: Vec<Fp> = row.iter().map(|&v| Fp::new(v)).collect();
                prop_assert_eq!(span.reduce(row.clone()), echelon.reduce(row.clone()));
                prop_assert_eq!(span.insert(row.clone()), echelon.insert(row));
            }
        }
    }
}
