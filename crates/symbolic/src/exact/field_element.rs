//! Fields with exact arithmetic.

use std::cmp::Ordering;

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

/// A field of real numbers.
pub trait OrderedField: FieldElement {
    /// A rational number.
    fn of(q: RBig) -> Self;
    /// The sum.
    #[must_use]
    fn plus(&self, other: &Self) -> Self;
    /// The product.
    #[must_use]
    fn times(&self, other: &Self) -> Self;
    /// The number with the other sign.
    #[must_use]
    fn negative(&self) -> Self;
    /// The sign; `None` where it is not known.
    fn sign(&self) -> Option<Ordering>;
    /// A rational number nearby, the number itself where it is known to be rational; `None` where its value is not known.
    fn approximation(&self) -> Option<RBig>;
    /// Whether the sign is known to be positive.
    fn is_positive(&self) -> bool {
        self.sign() == Some(Ordering::Greater)
    }
    /// Whether the sign is known to be negative.
    fn is_negative(&self) -> bool {
        self.sign() == Some(Ordering::Less)
    }
}

impl OrderedField for RBig {
    fn of(q: RBig) -> Self {
        q
    }

    fn plus(&self, other: &Self) -> Self {
        self + other
    }

    fn times(&self, other: &Self) -> Self {
        self * other
    }

    fn negative(&self) -> Self {
        -self.clone()
    }

    fn sign(&self) -> Option<Ordering> {
        Some(self.cmp(&Self::ZERO))
    }

    fn approximation(&self) -> Option<RBig> {
        Some(self.clone())
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
