//! Polynomials up to a positive factor: integer coefficients without a common divisor.
//!
//! Remainders, signs, and isolating intervals need no more, and integers need no greatest common divisor for every operation, as fractions do.

use std::cmp::Ordering;

use dashu_base::{Abs, BitTest, Gcd, Sign, UnsignedAbs};
use dashu_int::{IBig, UBig};

use crate::Rational;
use crate::exact::Fp;

/// Σ c_k x^k with c_k at index k, the last not zero.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct IntegerPolynomial(Vec<IBig>);

impl IntegerPolynomial {
    /// The multiple of a polynomial by a positive number that has integer coefficients without a common divisor.
    pub(super) fn of(coefficients: &[Rational]) -> Self {
        let scale = coefficients.iter().fold(UBig::ONE, |s, c| {
            let d = c.denominator();
            &s / (&s).gcd(d) * d
        });
        let integer = |c: &Rational| c.numerator() * IBig::from(&scale / c.denominator());
        Self::without_content(coefficients.iter().map(integer).collect())
    }

    fn without_content(mut coefficients: Vec<IBig>) -> Self {
        while coefficients.last().is_some_and(|c| *c == IBig::ZERO) {
            coefficients.pop();
        }
        let mut content = UBig::ZERO;
        for c in coefficients.iter().rev() {
            content =
                if content == UBig::ZERO { c.clone().unsigned_abs() } else { (&content).gcd(c.clone().unsigned_abs()) };
            if content == UBig::ONE {
                return Self(coefficients);
            }
        }
        let content = IBig::from(content);
        for c in &mut coefficients {
            *c /= &content;
        }
        Self(coefficients)
    }

    pub(super) fn rational(&self) -> Vec<Rational> {
        self.0.iter().cloned().map(Rational::from).collect()
    }

    pub(super) fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn degree(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    pub(super) fn coefficients(&self) -> &[IBig] {
        &self.0
    }

    #[must_use]
    pub(super) fn negative(mut self) -> Self {
        for c in &mut self.0 {
            *c = -std::mem::take(c);
        }
        self
    }

    #[must_use]
    pub(super) fn derivative(&self) -> Self {
        Self::without_content(self.0.iter().enumerate().skip(1).map(|(k, c)| c * IBig::from(k)).collect())
    }

    /// A positive multiple of the remainder of the division by a polynomial that is not zero.
    #[must_use]
    pub(super) fn remainder(&self, divisor: &Self) -> Self {
        let (d, mut rest) = (divisor.degree(), self.0.clone());
        let Some(leading) = divisor.0.last() else { return self.clone() };
        while rest.len() > d {
            let Some(top) = rest.pop() else { break };
            if top == IBig::ZERO {
                continue;
            }
            let common = IBig::from(leading.clone().unsigned_abs().gcd(top.clone().unsigned_abs()));
            let factor = leading.clone().abs() / &common;
            let times = top / &common * leading.sign();
            if factor != IBig::ONE {
                for c in &mut rest {
                    *c *= &factor;
                }
            }
            let shift = rest.len() - d;
            for (r, c) in rest[shift..].iter_mut().zip(&divisor.0) {
                *r -= &times * c;
            }
        }
        Self::without_content(rest)
    }

    /// Whether the images modulo a prime show that there is no common divisor but constants.
    fn is_coprime_modulo_a_prime(&self, other: &Self) -> bool {
        let image = |p: &Self| -> Vec<Fp> {
            p.0.iter().filter_map(|c| Fp::from_rational(&Rational::from(c.clone()))).collect()
        };
        let (mut a, mut b) = (image(self), image(other));
        let leads = |p: &[Fp]| p.last().is_some_and(|c| !c.is_zero());
        if !leads(&a) && !leads(&b) {
            return false;
        }
        let trim = |p: &mut Vec<Fp>| {
            while p.last().is_some_and(|c| c.is_zero()) {
                p.pop();
            }
        };
        trim(&mut a);
        trim(&mut b);
        while let Some(inverse) = b.last().and_then(|c| c.inv()) {
            while a.len() >= b.len() {
                let Some(top) = a.pop() else { break };
                let factor = top * inverse;
                let shift = a.len() + 1 - b.len();
                for (r, &c) in a[shift..].iter_mut().zip(&b) {
                    *r -= factor * c;
                }
            }
            trim(&mut a);
            std::mem::swap(&mut a, &mut b);
        }
        a.len() == 1
    }

    /// The greatest common divisor up to a factor; 0 for two zero polynomials.
    pub(super) fn gcd(&self, other: &Self) -> Self {
        if !self.is_zero() && !other.is_zero() && self.is_coprime_modulo_a_prime(other) {
            return Self(vec![IBig::ONE]);
        }
        let (mut a, mut b) = (self.clone(), other.clone());
        while !b.is_zero() {
            let rest = a.remainder(&b);
            a = std::mem::replace(&mut b, rest);
        }
        a
    }

    /// f, g, and the negative remainders of Euclid's algorithm, up to positive factors (Sturm).
    pub(super) fn signed_remainders(f: Self, g: Self) -> Vec<Self> {
        let mut chain = vec![f, g];
        while let [.., a, b] = &chain[..]
            && !b.is_zero()
        {
            let rest = a.remainder(b).negative();
            chain.push(rest);
        }
        chain.pop();
        chain
    }

    /// The sign of the value at x.
    pub(super) fn sign_at(&self, x: &Rational) -> Ordering {
        // q^n p(x) for x = p/q
        let (p, q) = (x.numerator(), IBig::from(x.denominator().clone()));
        let mut coefficients = self.0.iter().rev();
        let Some(mut sum) = coefficients.next().cloned() else { return Ordering::Equal };
        let mut power = IBig::ONE;
        for c in coefficients {
            power *= &q;
            sum = sum * p + c * &power;
        }
        sum.cmp(&IBig::ZERO)
    }

    /// Number of sign changes in the sequence of coefficients.
    fn variations(coefficients: &[IBig]) -> usize {
        let mut last: Option<Sign> = None;
        let mut count = 0;
        for c in coefficients.iter().filter(|c| **c != IBig::ZERO) {
            count += usize::from(last.is_some_and(|s| s != c.sign()));
            last = Some(c.sign());
        }
        count
    }

    /// Open intervals that hold one positive root each, and roots that are known, of a polynomial with simple roots, by the rule of
    /// signs of Descartes (Collins and Akritas 1976).
    pub(super) fn positive_roots(&self) -> Vec<Isolated> {
        let n = self.degree();
        // All roots are smaller than 2^bits, twice the largest |c_(n−k)/c_n|^(1/k) (Fujiwara 1916); those of p(2^bits x) between 0 and 1
        // are sought.
        let size = |k: usize| self.0[k].bit_len() as i64;
        let of = |k: usize| 1 + (size(k) - size(n) + 1).div_euclid((n - k) as i64) + 1;
        let bits = (0..n).filter(|&k| self.0[k] != IBig::ZERO).map(of).max().unwrap_or(0).max(0) as usize;
        let scaled: Vec<IBig> = self.0.iter().enumerate().map(|(k, c)| c << (bits * k)).collect();
        let scale = Rational::from(IBig::ONE << bits);
        // Polynomials on (c, c + 1)/2^k, moved to (0, 1).
        let mut open = vec![(scaled, IBig::ZERO, 0_usize)];
        let mut isolated = Vec::new();
        while let Some((p, c, k)) = open.pop() {
            let mut reversed: Vec<IBig> = p.iter().rev().cloned().collect();
            shift_by_one(&mut reversed);
            let at = |c: &IBig, k: usize| Rational::from(c.clone()) * &scale / Rational::from(IBig::ONE << k);
            match Self::variations(&reversed) {
                0 => {}
                1 => isolated.push(Isolated::Between([at(&c, k), at(&(&c + IBig::ONE), k)])),
                _ => {
                    let degree = p.len() - 1;
                    let left: Vec<IBig> = p.into_iter().enumerate().map(|(j, x)| x << (degree - j)).collect();
                    let mut right = left.clone();
                    shift_by_one(&mut right);
                    let (c, k) = (c << 1, k + 1);
                    let middle = &c + IBig::ONE;
                    if right.first().is_some_and(|x| *x == IBig::ZERO) {
                        isolated.push(Isolated::At(at(&middle, k)));
                        right.remove(0);
                    }
                    open.push((right, middle, k));
                    open.push((left, c, k));
                }
            }
            debug_assert!(isolated.len() <= n);
        }
        isolated
    }
}

/// Where a simple root is.
#[derive(Clone, Debug)]
pub(super) enum Isolated {
    /// It is this number.
    At(Rational),
    /// It is the only one between these.
    Between([Rational; 2]),
}

/// p(x + 1) in place of p(x).
fn shift_by_one(p: &mut [IBig]) {
    for i in 0..p.len().saturating_sub(1) {
        for j in (i..p.len() - 1).rev() {
            let (low, high) = p.split_at_mut(j + 1);
            low[j] += &high[0];
        }
    }
}
