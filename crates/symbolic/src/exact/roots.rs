//! Roots of degree 2^K: which radicands are squares times products of others is read off their quadratic characters.

use dashu_ratio::RBig;

use super::constants::factors;
use super::echelon::combination_modulo;
use super::field::Residue;
use super::kernels::Radicand;
use super::lowering::{Lowering, Stop};
use super::program::{Generator, Reg, Step};
use super::relation::Relation;
use crate::node::Expr;

/// Trial points beyond the number of radicands: an accidental relation has probability 2^−64.
const SPARE: usize = 64;
const MAX_LEVELS: u32 = 16;

impl<const C: u64> Lowering<'_, C> {
    /// Register of base^(1/2^levels).
    pub(super) fn root(&mut self, base: Expr, levels: u32) -> Result<Reg, Stop> {
        let (r, all) = if let Some(&known) = self.roots.known.get(&base) {
            known
        } else {
            let all = self.requirements.levels.get(&base).copied().unwrap_or(0).max(levels);
            if all > MAX_LEVELS {
                return Err(self.kernel(base, "the degree of its root is too large"));
            }
            let r = self.new_root(base, all)?;
            self.roots.known.insert(base, (r, all));
            (r, all)
        };
        if all < levels {
            self.requirements.levels.insert(base, levels);
            return Err(Stop::Restart);
        }
        Ok(self.integer_power(r, 1 << (all - levels)))
    }

    fn new_root(&mut self, base: Expr, levels: u32) -> Result<Reg, Stop> {
        if let Some(q) = self.exact.get(&base).cloned() {
            let c = self.rational_root(base, &q, levels)?;
            return Ok(self.constant(c));
        }
        let value = self.registers[&base];
        if self.program.is_constant(value) {
            return Err(self.kernel(base, "it is an irrational constant under a root"));
        }
        self.refuse_open_sign(value)?;
        let mut all: Vec<Reg> = self.roots.free.iter().map(|f| f.value).collect();
        all.push(value);
        let at = self.nonzero_trials(&all, all.len() + 2 * SPARE);
        if at.len() < all.len() + SPARE {
            return Err(self.few_trials(base, all.len() + 2 * SPARE, "it has no value at most points, under a root"));
        }
        let others = &all[..all.len() - 1];
        let few = &at[..at.len().min(all.len() + 16)];
        if let Relation::Product { constant, power, exponents } = self.multiplicative_relation(others, value, few) {
            return self.product_root(base, levels, &constant, power, &exponents);
        }
        // Quadratic characters as exponents of −1; the constants (column of ones) are in front.
        let character =
            |&r: &Reg| -> Vec<u64> { self.values(r, &at).into_iter().map(|v| u64::from(!v.is_residue())).collect() };
        let mut columns = vec![vec![1; at.len()]];
        // A radicand whose root occurs in `base` is a square wherever `base` has a value.
        columns.extend(others.iter().map(character).filter(|c| c.contains(&1)));
        match combination_modulo::<2>(&columns, &character(&value)) {
            Err(()) => Err(self.kernel(base, "roots are related in a way that was not resolved")),
            Ok(None) => {
                let root = self.signed_root(value, levels);
                self.roots.free.push(Radicand { base, value, root, levels });
                Ok(root)
            }
            Ok(Some(_)) => {
                // √(c s²) = ±√c s: the sign is that of s, which changes from place to place.
                self.roots.ambiguous += 1;
                let root = self.signed_root(value, levels);
                self.open_sign(root);
                Ok(root)
            }
        }
    }

    /// The root of a generic sign.
    fn signed_root(&mut self, value: Reg, levels: u32) -> Reg {
        let slot = self.generator(Generator::Sign);
        let sign = self.push(Step::Slot(slot));
        let root = self.push(Step::Root(value, levels));
        self.roots.conditions += 1;
        self.roots.extension = self.roots.extension.max(1.0) * f64::from(1 << levels);
        self.push(Step::Mul(sign, root))
    }

    /// Root of r, where r^power = t·Π r_j^(n_j) over the free radicands.
    fn product_root(&mut self, base: Expr, levels: u32, t: &RBig, power: u64, n: &[i64]) -> Result<Reg, Stop> {
        let d = power.trailing_zeros();
        let mut root = {
            let c = self.rational_root(base, t, levels + d)?;
            self.constant(c)
        };
        for (j, n) in n.iter().copied().enumerate().filter(|(_, n)| *n != 0) {
            let f = &self.roots.free[j];
            let missing = (levels + d).saturating_sub(f.levels + n.trailing_zeros());
            if missing > 0 {
                self.requirements.levels.insert(f.base, f.levels + missing);
                return Err(Stop::Restart);
            }
            // The root r_j^(1/2^levels_j) to the power n_j 2^(levels_j − levels − d).
            let shift = i64::from(f.levels) - i64::from(levels + d);
            let k = if shift >= 0 { n << shift } else { n >> -shift };
            let r = self.integer_power(f.root, k);
            root = self.push(Step::Mul(root, r));
        }
        self.odd_root(base, root, power >> d)
    }

    /// q^(1/2^levels) as a product of powers of the roots of the prime factors of q.
    pub(super) fn rational_root(&mut self, e: Expr, q: &RBig, levels: u32) -> Result<Residue<C>, Stop> {
        if *q == RBig::ZERO {
            return Ok(Residue::ZERO);
        }
        if *q < RBig::ZERO {
            return Err(self.kernel(e, "it is negative under a root"));
        }
        let Some(factors) = factors(q, &mut self.found) else {
            return Err(self.kernel(e, "the number under a root is too large to be factored"));
        };
        let mut product = Residue::ONE;
        for (n, k) in factors {
            let mut r = Residue::<C>::new(n);
            // A whole power of n needs no root of n.
            let shift = k.trailing_zeros().min(levels);
            for _ in shift..levels {
                r = match r.sqrt() {
                    Some(r) => r,
                    None => return Err(self.other_prime(e, "the field lacks a root of this number")),
                };
            }
            let r = r.pow(k.unsigned_abs() >> shift);
            product *= if k < 0 { r.inv().unwrap_or_default() } else { r };
        }
        Ok(product)
    }
}
