//! Fields with exact arithmetic.

use dashu_ratio::RBig;

use super::field::Residue;

/// An element of a field with exact arithmetic.
pub trait FieldElement: Clone + PartialEq {
    /// Neutral element of addition.
    const ZERO: Self;
    /// Neutral element of multiplication.
    const ONE: Self;
    /// The multiplicative inverse; `None` for 0.
    fn inverse(&self) -> Option<Self>;
    /// self · factor in place of self.
    fn scale(&mut self, factor: &Self);
    /// self − a·b in place of self.
    fn subtract_product(&mut self, a: &Self, b: &Self);
    /// True for 0.
    fn is_zero(&self) -> bool {
        *self == Self::ZERO
    }
}

impl<const C: u64> FieldElement for Residue<C> {
    const ZERO: Self = Self::ZERO;
    const ONE: Self = Self::ONE;

    fn inverse(&self) -> Option<Self> {
        self.inv()
    }

    fn scale(&mut self, factor: &Self) {
        *self *= *factor;
    }

    fn subtract_product(&mut self, a: &Self, b: &Self) {
        *self -= *a * *b;
    }
}

impl FieldElement for RBig {
    const ZERO: Self = Self::ZERO;
    const ONE: Self = Self::ONE;

    fn inverse(&self) -> Option<Self> {
        (*self != Self::ZERO).then(|| Self::ONE / self)
    }

    // Products with 0 would look for common divisors.
    fn scale(&mut self, factor: &Self) {
        if *self != Self::ZERO {
            *self *= factor;
        }
    }

    fn subtract_product(&mut self, a: &Self, b: &Self) {
        if *a != Self::ZERO && *b != Self::ZERO {
            *self -= a * b;
        }
    }
}

/// An integer modulo a prime `L` below 2^31.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SmallResidue<const L: u64>(u64);

impl<const L: u64> SmallResidue<L> {
    /// The class of `n`.
    pub(super) fn new(n: u64) -> Self {
        Self(n % L)
    }

    /// The representative in 0 … L − 1.
    pub(super) fn value(self) -> u64 {
        self.0
    }
}

impl<const L: u64> FieldElement for SmallResidue<L> {
    const ZERO: Self = Self(0);
    const ONE: Self = Self(1);

    fn inverse(&self) -> Option<Self> {
        (1..L).map(Self).find(|x| x.0 * self.0 % L == 1)
    }

    fn scale(&mut self, factor: &Self) {
        self.0 = self.0 * factor.0 % L;
    }

    fn subtract_product(&mut self, a: &Self, b: &Self) {
        self.0 = (self.0 + (L - a.0 * b.0 % L)) % L;
    }
}
