//! Products of powers that are constant, found by characters.

use dashu_ratio::RBig;

use super::character::{Character, small_fraction};
use super::field::gcd;
use super::lowering::{FRACTION_BOUND, Lowering};
use super::program::Reg;

/// What characters say about h, given h_1 … h_k.
pub(super) enum Relation {
    /// No power of h is a constant times a product of powers of the others.
    None,
    /// h^d = t·Π h_j^(n_j)
    Product {
        /// t
        constant: RBig,
        /// d > 0
        power: u64,
        /// n_j
        exponents: Vec<i64>,
    },
    /// There may be a relation, but not of this form.
    Unresolved,
}

impl<const C: u64> Lowering<'_, C> {
    /// Trial points at which all registers have values other than 0.
    pub(super) fn nonzero_trials(&self, registers: &[Reg], n: usize) -> Vec<usize> {
        let at = self.trials(registers, n);
        let nonzero = |i: &usize| registers.iter().all(|&r| self.trial(r, *i).is_some_and(|v| !v.is_zero()));
        at.into_iter().filter(nonzero).collect()
    }

    /// The multiplicative relation of register `h` with `others`, from its values at the points `at`.
    pub(super) fn multiplicative_relation(&self, others: &[Reg], h: Reg, at: &[usize]) -> Relation {
        let character = self.character.get_or_init(Character::new);
        let column = |r: Reg| -> Vec<u64> { self.values(r, at).into_iter().map(|v| character.of(v)).collect() };
        // The column of ones stands for the unknown constant.
        let mut columns = vec![vec![1; at.len()]];
        columns.extend(others.iter().map(|&r| column(r)));
        let c = match character.combination(&columns, &column(h)) {
            Err(()) => return Relation::Unresolved,
            Ok(None) => return Relation::None,
            Ok(Some(c)) => c,
        };
        let fractions = c[1..].iter().map(|&c| small_fraction(c, character.order)).collect::<Option<Vec<_>>>();
        fractions.and_then(|f| self.constant_product(others, h, at, &f)).unwrap_or(Relation::Unresolved)
    }

    /// The relation with the given exponents, if its constant is the same positive rational at all points.
    fn constant_product(&self, others: &[Reg], h: Reg, at: &[usize], c: &[(i64, i64)]) -> Option<Relation> {
        let power = c.iter().fold(1, |l, &(_, d)| l / gcd(l, d as u64) * d as u64);
        let exponents: Vec<i64> = c.iter().map(|&(n, d)| n * (power as i64 / d)).collect();
        let mut constants = at.iter().map(|&i| {
            let mut q = self.trial(h, i)?.pow(power);
            for (&r, &n) in others.iter().zip(&exponents) {
                let p = self.trial(r, i)?.pow(n.unsigned_abs());
                q *= if n > 0 { p.inv()? } else { p };
            }
            Some(q)
        });
        let t = constants.next()??;
        if constants.any(|r| r != Some(t)) {
            return None;
        }
        let constant = t.to_rational(FRACTION_BOUND).filter(|t| *t > RBig::ZERO)?;
        Some(Relation::Product { constant, power, exponents })
    }
}
