//! Vectors that are found to be combinations of others, one after the other.

use super::field::Residue;
use super::program::Reg;

/// Which arguments are compared with each other.
#[derive(Clone, Copy)]
pub(super) enum Kernels {
    Angles,
    Exponents,
}

/// What is known of the arguments so far.
#[derive(Default)]
pub(super) struct LinearRelations<const C: u64> {
    angles: Known<C>,
    exponents: Known<C>,
}

/// Registers, the trial points at which all have values, and these values.
pub(super) struct Known<const C: u64> {
    pub(super) registers: Vec<Reg>,
    pub(super) at: Vec<usize>,
    pub(super) values: Combinations<C>,
    /// One of the registers is a combination of those before it.
    pub(super) dependent: bool,
}

impl<const C: u64> LinearRelations<C> {
    pub(super) fn of(&mut self, kernels: Kernels) -> &mut Known<C> {
        match kernels {
            Kernels::Angles => &mut self.angles,
            Kernels::Exponents => &mut self.exponents,
        }
    }
}

impl<const C: u64> Default for Known<C> {
    fn default() -> Self {
        Self { registers: Vec::new(), at: Vec::new(), values: Combinations::empty(), dependent: false }
    }
}

/// Independent vectors, reduced as they come, so that asking for a combination costs one reduction.
pub(super) struct Combinations<const C: u64> {
    rows: Vec<Row<C>>,
}

/// A combination of the vectors so far that is 1 at its pivot and 0 at those before.
struct Row<const C: u64> {
    pivot: usize,
    values: Vec<Residue<C>>,
    coefficients: Vec<Residue<C>>,
}

impl<const C: u64> Combinations<C> {
    pub(super) fn empty() -> Self {
        Self { rows: Vec::new() }
    }

    /// The coefficients by which `v` is a combination of the vectors so far; `None` if it is independent of them.
    pub(super) fn of(&self, v: &[Residue<C>]) -> Option<Vec<Residue<C>>> {
        let (rest, coefficients) = self.reduce(v);
        rest.iter().all(|x| x.is_zero()).then_some(coefficients)
    }

    /// Adds a vector of the same length as the others; false if it is a combination of them.
    pub(super) fn insert(&mut self, v: &[Residue<C>]) -> bool {
        let (mut values, mut coefficients) = self.reduce(v);
        let Some((pivot, scale)) = values.iter().enumerate().find_map(|(p, x)| Some((p, x.inv()?))) else {
            return false;
        };
        for c in &mut coefficients {
            *c = -*c;
        }
        coefficients.push(Residue::ONE);
        values.iter_mut().chain(&mut coefficients).for_each(|x| *x *= scale);
        self.rows.push(Row { pivot, values, coefficients });
        true
    }

    /// What is left of a vector, and the combination that was subtracted.
    fn reduce(&self, v: &[Residue<C>]) -> (Vec<Residue<C>>, Vec<Residue<C>>) {
        let mut rest = v.to_vec();
        let mut coefficients = vec![Residue::ZERO; self.rows.len()];
        for row in &self.rows {
            let f = rest[row.pivot];
            if f.is_zero() {
                continue;
            }
            rest.iter_mut().zip(&row.values).for_each(|(x, &y)| *x -= f * y);
            coefficients.iter_mut().zip(&row.coefficients).for_each(|(x, &y)| *x += f * y);
        }
        (rest, coefficients)
    }
}
