//! Characters: homomorphisms from the field to small cyclic groups.

use rustc_hash::FxHashMap;

use super::echelon::combination_modulo;
use super::field::{Residue, THIRD_OFFSET};

/// Homomorphism from the field's multiplicative group to the integers modulo a prime ℓ that divides p − 1.
pub(super) struct Character<const C: u64> {
    pub(super) order: u64,
    /// The powers g^0 … g^(m − 1) of a root of unity of this order, m² ≥ ℓ.
    small: FxHashMap<u64, u64>,
    /// g^(−m)
    giant: Residue<C>,
}

/// Exponents in relations have numerators and denominators up to this; 2·24² < ℓ makes them unique.
const MAX_EXPONENT: i64 = 24;

impl<const C: u64> Character<C> {
    /// ℓ = 1321 for p = 2^61 − 1, 8681 for the second prime, and 7351 for the third.
    pub(super) fn new() -> Self {
        let order: u64 = match C {
            1 => 1321,
            THIRD_OFFSET => 7351,
            _ => 8681,
        };
        let exponent = (Residue::<C>::MODULUS - 1) / order;
        let candidates = (2..1000).map(|g| Residue::<C>::new(g).pow(exponent));
        let root = candidates.into_iter().find(|&r| r != Residue::ONE).unwrap_or(Residue::ONE);
        let m = order.isqrt() + 1;
        let mut small = FxHashMap::default();
        let mut r = Residue::ONE;
        for k in 0..m {
            small.insert(r.value(), k);
            r *= root;
        }
        Self { order, small, giant: r.inv().unwrap_or(Residue::ONE) }
    }

    /// The coefficients modulo ℓ by which `target` is a combination of `columns`.
    ///
    /// `Ok(None)` if it is independent of them; `Err(())` if the columns themselves are dependent.
    pub(super) fn combination(&self, columns: &[Vec<u64>], target: &[u64]) -> Result<Option<Vec<u64>>, ()> {
        match self.order {
            1321 => combination_modulo::<1321>(columns, target),
            7351 => combination_modulo::<7351>(columns, target),
            _ => combination_modulo::<8681>(columns, target),
        }
    }

    /// The discrete logarithm of v^((p − 1)/ℓ) by baby steps and giant steps (Shanks 1971).
    pub(super) fn of(&self, v: Residue<C>) -> u64 {
        let mut r = v.pow((Residue::<C>::MODULUS - 1) / self.order);
        let m = self.small.len() as u64;
        for giant in 0..m {
            if let Some(k) = self.small.get(&r.value()) {
                return (giant * m + k) % self.order;
            }
            r *= self.giant;
        }
        0
    }
}

/// The fraction n/d with |n|, d ≤ 24 in the class of `c` modulo ℓ, if there is one.
pub(super) fn small_fraction(c: u64, order: u64) -> Option<(i64, i64)> {
    (1..=MAX_EXPONENT).find_map(|d| {
        let n = (c * d as u64 % order) as i64;
        let n = if n > order as i64 / 2 { n - order as i64 } else { n };
        (n.abs() <= MAX_EXPONENT).then_some((n, d))
    })
}
