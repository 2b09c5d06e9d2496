//! Arithmetic modulo a prime just below 2^61, and rational reconstruction.

use crate::random::SplitMix64;
use std::fmt;
use std::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use dashu_base::{BitTest, UnsignedAbs};
use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;

/// An integer modulo the prime 2^61 − `C`; see [`Fp`] for the one in general use.
///
/// 2^61 − `C` must be a prime above 2^60 that is 3 modulo 4, so that −1 is no square and a root of a square is a single power.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Residue<const C: u64>(u64);

/// An integer modulo the Mersenne prime 2^61 − 1.
pub type Fp = Residue<1>;

/// [`Residue<SECOND_OFFSET>`] are the integers modulo 2^61 − 70094276963553, for expressions with roots: all primes up to
/// 167 and 28019 (of 9.80665) are squares modulo it, cube, fifth, seventh, 11th and 13th roots are unique, and it holds the
/// sines and cosines of π/1800.
pub const SECOND_OFFSET: u64 = 70_094_276_963_553;

/// [`Residue<THIRD_OFFSET>`] are the integers modulo 2^61 − 615950913, for what one of the other two fields lacks: the
/// primes up to 53, 109 and 28019 are squares modulo it, and it holds the sines and cosines of π/4320.
pub const THIRD_OFFSET: u64 = 615_950_913;

/// Constants with fewer bits above and below the line are never mistaken for another fraction.
const HARMLESS_BITS: usize = 39;

const MASK: u64 = (1 << 61) - 1;

impl<const C: u64> Residue<C> {
    /// The prime.
    pub const MODULUS: u64 = (1 << 61) - C;
    /// Neutral element of addition.
    pub const ZERO: Self = Self(0);
    /// Neutral element of multiplication.
    pub const ONE: Self = Self(1);

    /// The class of `n`.
    pub fn new(n: u64) -> Self {
        Self(n % Self::MODULUS)
    }

    /// The class of `n`.
    pub fn from_i64(n: i64) -> Self {
        let r = Self::new(n.unsigned_abs());
        if n < 0 { -r } else { r }
    }

    /// The representative in 0 … p − 1.
    pub fn value(self) -> u64 {
        self.0
    }

    /// True for the class of 0.
    pub fn is_zero(self) -> bool {
        self.0 == 0
    }

    /// ⌊2^122 / p⌋
    const INVERSE: u64 = ((1 << 122) / Self::MODULUS as u128) as u64;

    /// The class of a product of two representatives.
    fn reduce(x: u128) -> Self {
        if C == 1 {
            // 2^61 ≡ 1
            let r = (x as u64 & MASK) + (x >> 61) as u64;
            return Self(if r >= Self::MODULUS { r - Self::MODULUS } else { r });
        }
        // The quotient from the leading digits is at most 2 too small (Barrett 1986).
        let quotient = (((x >> 60) * u128::from(Self::INVERSE)) >> 62) as u64;
        let mut r = (x as u64).wrapping_sub(quotient.wrapping_mul(Self::MODULUS));
        while r >= Self::MODULUS {
            r -= Self::MODULUS;
        }
        Self(r)
    }

    /// `self` to the power `k`.
    #[must_use]
    pub fn pow(self, mut k: u64) -> Self {
        let (mut base, mut r) = (self, Self::ONE);
        while k > 0 {
            if k & 1 == 1 {
                r *= base;
            }
            base *= base;
            k >>= 1;
        }
        r
    }

    /// The multiplicative inverse; `None` for 0.
    pub fn inv(self) -> Option<Self> {
        // Extended Euclid: a·s ≡ r throughout.
        if self.0 == 0 {
            return None;
        }
        let (mut r0, mut r1) = (Self::MODULUS as i64, self.0 as i64);
        let (mut s0, mut s1) = (0_i64, 1_i64);
        while r1 != 0 {
            let q = r0 / r1;
            (r0, r1) = (r1, r0 - q * r1);
            (s0, s1) = (s1, s0 - q * s1);
        }
        Some(Self(if s0 < 0 { (s0 + Self::MODULUS as i64) as u64 } else { s0 as u64 }))
    }

    /// True if `self` is a square other than 0.
    pub fn is_residue(self) -> bool {
        self.pow((Self::MODULUS - 1) / 2) == Self::ONE
    }

    /// The square root that is itself a square; `None` if `self` is not a square.
    pub fn sqrt(self) -> Option<Self> {
        let r = self.pow(Self::MODULUS.div_ceil(4));
        (r * r == self).then_some(r)
    }

    /// The class of an exact rational; `None` if the prime divides its denominator.
    pub fn from_rational(r: &RBig) -> Option<Self> {
        let p = UBig::from(Self::MODULUS);
        let den = Self(u64::try_from(r.denominator() % &p).ok()?).inv()?;
        let num = Self(u64::try_from(r.numerator().unsigned_abs() % &p).ok()?);
        let q = num * den;
        Some(if *r.numerator() < IBig::ZERO { -q } else { q })
    }

    /// The class of an exact rational, if nothing is mistaken in this field: neither is the class of a number other
    /// than zero that of 0, nor that of a long fraction the class of one with at most `bound` above and below.
    ///
    /// A fraction of random long integers is refused with probability 2·`bound`²/p.
    pub(super) fn faithful(r: &RBig, bound: u64) -> Option<Self> {
        let class = Self::from_rational(r)?;
        let harmless = |bits: usize| bits <= HARMLESS_BITS;
        if harmless(r.numerator().bit_len()) && harmless(r.denominator().bit_len()) {
            return Some(class);
        }
        match class.to_rational(bound) {
            Some(short) if short != *r => None,
            _ => Some(class),
        }
    }

    /// The fraction n/d with |n| ≤ `bound` and 0 < d ≤ `bound` in this class
    /// (Wang's rational reconstruction), if there is one.
    ///
    /// It is unique because `bound` counts as 2^30 − 1 at most.
    pub fn to_fraction(self, bound: u64) -> Option<(i64, i64)> {
        let bound = bound.min((1 << 30) - 1) as i64;
        let (mut r0, mut r1) = (Self::MODULUS as i64, self.0 as i64);
        let (mut s0, mut s1) = (0_i64, 1_i64);
        while r1 > bound {
            let q = r0 / r1;
            (r0, r1) = (r1, r0 - q * r1);
            (s0, s1) = (s1, s0 - q * s1);
        }
        if s1 == 0 || s1.abs() > bound || gcd(r1.unsigned_abs(), s1.unsigned_abs()) != 1 {
            return None;
        }
        Some(if s1 < 0 { (-r1, -s1) } else { (r1, s1) })
    }

    /// [`Residue::to_fraction`] as a rational number.
    pub fn to_rational(self, bound: u64) -> Option<RBig> {
        let (n, d) = self.to_fraction(bound)?;
        Some(RBig::from(n) / RBig::from(d))
    }
}

/// Greatest common divisor.
pub(crate) fn gcd(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl<const C: u64> Add for Residue<C> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let s = self.0 + o.0;
        Self(if s >= Self::MODULUS { s - Self::MODULUS } else { s })
    }
}

impl<const C: u64> Sub for Residue<C> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl<const C: u64> Neg for Residue<C> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(if self.0 == 0 { 0 } else { Self::MODULUS - self.0 })
    }
}

impl<const C: u64> Mul for Residue<C> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self::reduce(u128::from(self.0) * u128::from(o.0))
    }
}

impl<const C: u64> AddAssign for Residue<C> {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<const C: u64> SubAssign for Residue<C> {
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<const C: u64> MulAssign for Residue<C> {
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}

impl<const C: u64> fmt::Display for Residue<C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<const C: u64> fmt::Debug for Residue<C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl SplitMix64 {
    /// A uniformly distributed residue other than 0.
    pub(crate) fn residue<const C: u64>(&mut self) -> Residue<C> {
        loop {
            let v = self.next_u64() >> 3;
            if v > 0 && v < Residue::<C>::MODULUS {
                return Residue(v);
            }
        }
    }
}
