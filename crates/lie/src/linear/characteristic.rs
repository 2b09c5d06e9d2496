//! Characteristic polynomials of rational matrices, by residues.
//!
//! In exact arithmetic the numbers of a Hessenberg form grow with every column. Modulo a prime they do not; coefficients follow from as many
//! primes as their bound needs (Chinese remainder theorem).

use bracketry_symbolic::{Rational, UnivariatePolynomial};
use dashu_int::ops::{BitTest, Gcd};
use dashu_int::{IBig, UBig};

/// det(λ − M) of a square matrix, given by its rows.
pub(super) fn characteristic_polynomial(rows: &[Vec<Rational>]) -> UnivariatePolynomial {
    let n = rows.len();
    // N = s M has integer entries, and det(λ − M) = s^−n det(s λ − N).
    let scale = rows.iter().flatten().fold(UBig::ONE, |s, x| {
        let d = x.denominator();
        &s / (&s).gcd(d) * d
    });
    let factor = Rational::from(scale.clone());
    let integers: Vec<Vec<IBig>> =
        rows.iter().map(|r| r.iter().map(|x| (x * &factor).numerator().clone()).collect()).collect();
    // The coefficient of λ^(n−k) is a sum of binomial(n, k) minors, each at most (√k max |N_ij|)^k (Hadamard).
    let entry = integers.iter().flatten().map(BitTest::bit_len).max().unwrap_or(0);
    let bits = n + n * (entry + n.max(1).ilog2() as usize / 2 + 1) + 2;
    let mut coefficients = vec![IBig::ZERO; n + 1];
    let mut known = IBig::ONE;
    for field in (1..).filter_map(Field::new) {
        let p = IBig::from(field.prime);
        let residue = |x: &IBig| u64::try_from((x % &p + &p) % &p).unwrap_or_default();
        let matrix = integers.iter().map(|row| row.iter().map(residue).collect()).collect();
        let weight = field.inverse(residue(&known));
        for (c, r) in coefficients.iter_mut().zip(field.characteristic_polynomial(matrix)) {
            let step = field.times(field.minus(r, residue(c)), weight);
            *c += &known * IBig::from(step);
        }
        known *= p;
        if known.bit_len() > bits {
            break;
        }
    }
    let mut power = Rational::ONE;
    let mut scaled: Vec<Rational> = Vec::with_capacity(n + 1);
    for c in coefficients.into_iter().rev() {
        let signed = if &c * IBig::from(2) > known { c - &known } else { c };
        scaled.push(Rational::from(signed) / &power);
        power *= &factor;
    }
    scaled.reverse();
    UnivariatePolynomial::new(scaled)
}

/// Integers modulo a prime a little below 2^61.
struct Field {
    prime: u64,
    /// 2^61 less the prime.
    offset: u64,
}

const BITS: u32 = 61;

impl Field {
    /// Modulo 2^61 − `offset`; none where that is no prime.
    fn new(offset: u64) -> Option<Self> {
        let field = Field { prime: (1 << BITS) - offset, offset };
        field.is_prime().then_some(field)
    }

    /// The test of Miller (1976) and Rabin (1980), with bases that decide for all numbers of 64 bits (Sorenson and Webster 2017).
    fn is_prime(&self) -> bool {
        let n = self.prime;
        if n.is_multiple_of(2) {
            return false;
        }
        let twos = (n - 1).trailing_zeros();
        [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37].into_iter().all(|base| {
            let mut x = self.power(base, (n - 1) >> twos);
            x == 1
                || (0..twos).any(|_| {
                    let found = x == n - 1;
                    x = self.times(x, x);
                    found
                })
        })
    }

    fn times(&self, a: u64, b: u64) -> u64 {
        // 2^61 is the offset modulo the prime.
        let fold = |x: u128| (x & ((1 << BITS) - 1)) + (x >> BITS) * u128::from(self.offset);
        let folded = fold(fold(fold(u128::from(a) * u128::from(b)))) as u64;
        if folded >= self.prime { folded - self.prime } else { folded }
    }

    fn minus(&self, a: u64, b: u64) -> u64 {
        if a >= b { a - b } else { a + self.prime - b }
    }

    fn power(&self, mut base: u64, mut exponent: u64) -> u64 {
        let mut result = 1;
        while exponent > 0 {
            if exponent % 2 == 1 {
                result = self.times(result, base);
            }
            base = self.times(base, base);
            exponent /= 2;
        }
        result
    }

    fn inverse(&self, a: u64) -> u64 {
        self.power(a, self.prime - 2)
    }

    /// Coefficients of det(λ − H), the constant one first (Cohen 1993, algorithm 2.2.9).
    fn characteristic_polynomial(&self, mut h: Vec<Vec<u64>>) -> Vec<u64> {
        self.hessenberg(&mut h);
        // p_k, of the leading k × k block: (λ − h_kk) p_(k−1) − Σ h_ik h_(i+1,i) … h_(k,k−1) p_(i−1).
        let mut blocks: Vec<Vec<u64>> = vec![vec![1]];
        for k in 0..h.len() {
            let mut p = vec![0; k + 2];
            p[1..].copy_from_slice(&blocks[k]);
            let mut below = 1;
            for i in (0..=k).rev() {
                let factor = self.times(below, h[i][k]);
                for (x, y) in p.iter_mut().zip(&blocks[i]) {
                    *x = self.minus(*x, self.times(factor, *y));
                }
                if i > 0 {
                    below = self.times(below, h[i][i - 1]);
                }
                if below == 0 {
                    break;
                }
            }
            blocks.push(p);
        }
        blocks.swap_remove(h.len())
    }

    /// Replaces a square matrix by a similar one with zeros below the first subdiagonal.
    fn hessenberg(&self, h: &mut [Vec<u64>]) {
        let n = h.len();
        for k in 1..n.saturating_sub(1) {
            let Some(pivot) = (k..n).find(|&i| h[i][k - 1] != 0) else { continue };
            h.swap(k, pivot);
            for row in h.iter_mut() {
                row.swap(k, pivot);
            }
            let scale = self.inverse(h[k][k - 1]);
            for i in k + 1..n {
                let factor = self.times(h[i][k - 1], scale);
                if factor == 0 {
                    continue;
                }
                let (upper, lower) = h.split_at_mut(i);
                for (x, y) in lower[0].iter_mut().zip(&upper[k]).skip(k - 1) {
                    *x = self.minus(*x, self.times(factor, *y));
                }
                for row in h.iter_mut() {
                    let step = self.times(factor, row[i]);
                    row[k] = self.minus(row[k], self.minus(0, step));
                }
            }
        }
    }
}
