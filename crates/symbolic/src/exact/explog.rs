//! Exponentials and logarithms: pairs (a, exp a), independent unless Σ c_j a_j = 0 for rational c_j.
//!
//! By the structure theorem for elementary extensions (Risch 1979) the only
//! algebraic relations are those that come from such linear ones. Between
//! exponents they are found from values; between logarithms from characters
//! of order ℓ of their arguments, which turn products into sums modulo ℓ.

use dashu_ratio::RBig;

use super::circle::MAX_MULTIPLE;
use super::combinations::Kernels;
use super::constants::factors;
use super::field::{Residue, gcd};
use super::kernels::Power;
use super::lowering::{Lowering, Stop};
use super::program::{Generator, Reg, Step};
use super::relation::Relation;
use crate::node::Expr;

/// Trial points beyond the number of unknowns of a multiplicative relation.
const SPARE: usize = 16;

impl<const C: u64> Lowering<'_, C> {
    /// Register of exp(a), for the register of a; errors name `e`.
    pub(super) fn exponential(&mut self, e: Expr, a: Reg) -> Result<Reg, Stop> {
        if let Some(&r) = self.explog.exponentials.get(&a) {
            return Ok(r);
        }
        let basis: Vec<Reg> = self.explog.basis.iter().map(|b| b.0).collect();
        let r = match self.relation(e, Kernels::Exponents, &basis, a)? {
            None => {
                let parts = self.requirements.exponents.get(&basis.len()).copied().unwrap_or(1);
                let slot = self.generator(Generator::Free);
                let g = self.push(Step::Slot(slot));
                self.explog.basis.push((a, Power::Free(g, parts)));
                self.integer_power(g, parts as i64)
            }
            Some(c) => self.product_of_powers(e, &c)?,
        };
        self.explog.exponentials.insert(a, r);
        Ok(r)
    }

    /// Π exp(a_j)^(c_j)
    fn product_of_powers(&mut self, e: Expr, c: &[(i64, i64)]) -> Result<Reg, Stop> {
        let mut restart = false;
        let mut factors = Vec::new();
        for (j, &(n, d)) in c.iter().enumerate().filter(|(_, c)| c.0 != 0) {
            let (power, d) = (self.explog.basis[j].1, d.unsigned_abs());
            let Power::Free(_, parts) = power else {
                let r = self.root_of_argument(e, power, d)?;
                factors.push((r, n));
                continue;
            };
            if parts.is_multiple_of(d) {
                factors.push((power.base(), n.saturating_mul((parts / d) as i64)));
            } else {
                self.requirements.exponents.insert(j, parts / gcd(parts, d) * d);
                restart = true;
            }
        }
        if restart {
            return Err(Stop::Restart);
        }
        let mut product = None;
        for (r, n) in factors {
            if n.unsigned_abs() > MAX_MULTIPLE {
                return Err(super::Undecided::TooComplex.into());
            }
            let p = self.integer_power(r, n);
            product = Some(product.map_or(p, |q| self.push(Step::Mul(q, p))));
        }
        Ok(product.unwrap_or_else(|| self.constant(Residue::ONE)))
    }

    /// Register of exp(log(h)/d).
    fn root_of_argument(&mut self, e: Expr, power: Power, d: u64) -> Result<Reg, Stop> {
        let levels = d.trailing_zeros();
        let r = match power {
            _ if levels == 0 => power.base(),
            Power::Argument(_, h) => self.root(h, levels)?,
            Power::Integer(n, _) => {
                let c = self.rational_root(e, &RBig::from(n), levels)?;
                self.constant(c)
            }
            Power::Free(r, _) => r,
        };
        self.odd_root(e, r, d >> levels)
    }

    /// Register of log(h).
    pub(super) fn logarithm(&mut self, h: Expr) -> Result<Reg, Stop> {
        if let Some(&r) = self.explog.logarithms.get(&h) {
            return Ok(r);
        }
        let r = self.new_logarithm(h)?;
        self.explog.logarithms.insert(h, r);
        Ok(r)
    }

    fn new_logarithm(&mut self, h: Expr) -> Result<Reg, Stop> {
        if let Some(q) = self.exact.get(&h).cloned() {
            return self.logarithm_of_rational(h, &q);
        }
        let value = self.registers[&h];
        if self.program.is_constant(value) {
            return Err(self.kernel(h, "it is an irrational constant under a logarithm"));
        }
        // Integer constants do not take part: their characters are constant.
        let free: Vec<usize> = (0..self.explog.basis.len())
            .filter(|&j| !self.program.is_constant(self.explog.basis[j].1.base()))
            .collect();
        let bases: Vec<Reg> = free.iter().map(|&j| self.explog.basis[j].1.base()).collect();
        let mut all = bases.clone();
        all.push(value);
        let at = self.nonzero_trials(&all, all.len() + SPARE);
        if at.len() < all.len() + SPARE / 2 {
            return Err(self.few_trials(
                h,
                2 * (all.len() + SPARE),
                "it has no value at most points, under a logarithm",
            ));
        }
        match self.multiplicative_relation(&bases, value, &at) {
            Relation::None => {
                let slot = self.generator(Generator::Free);
                let r = self.push(Step::Slot(slot));
                self.explog.basis.push((r, Power::Argument(value, h)));
                Ok(r)
            }
            Relation::Unresolved => Err(self.kernel(h, "it may be related to other logarithms and exponentials")),
            Relation::Product { constant, power, exponents } => {
                // log h = (log t + Σ n_j a_j)/d
                let mut sum = self.logarithm_of_rational(h, &constant)?;
                for (j, n) in free.into_iter().zip(exponents).filter(|(_, n)| *n != 0) {
                    let (a, source) = self.explog.basis[j];
                    // The generator is exp(a/parts).
                    let parts = if let Power::Free(_, parts) = source { parts } else { 1 };
                    let share = Residue::from_i64(n) * Residue::new(parts).inv().unwrap_or_default();
                    let term = self.scaled(share, a);
                    sum = self.push(Step::Add(sum, term));
                }
                Ok(self.scaled(Residue::new(power).inv().unwrap_or_default(), sum))
            }
        }
    }

    /// log q as the sum of the logarithms of the prime factors of q, each a generator.
    fn logarithm_of_rational(&mut self, e: Expr, q: &RBig) -> Result<Reg, Stop> {
        if *q <= RBig::ZERO {
            return Err(self.kernel(e, "it is not positive under a logarithm"));
        }
        let Some(factors) = factors(q, &mut self.found) else {
            return Err(self.kernel(e, "the number under a logarithm is too large to be factored"));
        };
        let mut sum = self.constant(Residue::ZERO);
        for (n, k) in factors {
            let known = self.explog.basis.iter().find(|(_, p)| matches!(p, Power::Integer(m, _) if *m == n));
            let log = if let Some(&(r, _)) = known {
                r
            } else {
                let slot = self.generator(Generator::Free);
                let r = self.push(Step::Slot(slot));
                let base = self.constant(Residue::new(n));
                self.explog.basis.push((r, Power::Integer(n, base)));
                r
            };
            let term = self.scaled(Residue::from_i64(k), log);
            sum = self.push(Step::Add(sum, term));
        }
        Ok(sum)
    }
}
