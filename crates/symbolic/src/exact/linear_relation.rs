//! Arguments of kernels that are rational combinations of those before them, found from values at the trial points.

use super::combinations::{Kernels, Known};
use super::lowering::{FRACTION_BOUND, Lowering, Stop};
use super::program::Reg;
use crate::node::Expr;

/// Trial points beyond the number of unknowns of a linear relation.
pub(super) const SPARE: usize = 6;

impl<const C: u64> Lowering<'_, C> {
    /// The rational coefficients by which register `value` is a combination of `basis`, to which registers are only appended between
    /// calls; `None` if it is independent. Errors name `e`.
    pub(super) fn relation(
        &mut self,
        e: Expr,
        kernels: Kernels,
        basis: &[Reg],
        value: Reg,
    ) -> Result<Option<Vec<(i64, i64)>>, Stop> {
        let mut known = std::mem::take(self.relations.of(kernels));
        let found = self.combination(e, &mut known, basis, value);
        *self.relations.of(kernels) = known;
        found
    }

    fn combination(
        &mut self,
        e: Expr,
        known: &mut Known<C>,
        basis: &[Reg],
        value: Reg,
    ) -> Result<Option<Vec<(i64, i64)>>, Stop> {
        let new = &basis[known.registers.len()..];
        let everywhere = |r: Reg, at: &[usize]| at.iter().all(|&i| self.trial(r, i).is_some());
        if known.registers.is_empty() || !new.iter().chain([&value]).all(|&r| everywhere(r, &known.at)) {
            let mut all = basis.to_vec();
            all.push(value);
            *known = Known { at: self.trials(&all, usize::MAX), ..Known::default() };
        }
        for &r in &basis[known.registers.len()..] {
            let values = self.values(r, &known.at);
            known.dependent |= !known.values.insert(&values);
            known.registers.push(r);
        }
        let needed = basis.len() + SPARE;
        if known.at.len() < needed {
            return Err(self.few_trials(e, 2 * needed, "its argument has no value at most points"));
        }
        if known.dependent {
            return Err(self.kernel(e, "arguments of such functions are related in a way that was not resolved"));
        }
        let Some(c) = known.values.of(&self.values(value, &known.at)) else { return Ok(None) };
        match c.iter().map(|c| c.to_fraction(FRACTION_BOUND)).collect() {
            Some(fractions) => Ok(Some(fractions)),
            None => Err(self.kernel(e, "its argument is an irrational multiple of others")),
        }
    }
}
