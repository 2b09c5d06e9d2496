//! Angles of points with rational slopes, by the primes of the Gaussian integers.
//!
//! arg(x + i y) = Σ k_p arg(a_p + i b_p) + m π/4 over the primes p = a_p² + b_p², a_p > b_p > 0, that divide x² + y². Since
//! factors in ℤ\[i\] are unique, these angles and π are linearly independent over the rationals, and by Baker's theorem
//! (1966) over the algebraic numbers.

use std::f64::consts::FRAC_PI_4;

use dashu_base::{Gcd, UnsignedAbs};
use dashu_int::IBig;
use dashu_ratio::RBig;

use super::constants::factors;

/// Factors below are primes: [`factors`] divides by all numbers below 2^16.
const PRIME: u64 = 1 << 32;
/// Larger exponents leave the multiple of π/4 to rounding.
const MAX_EXPONENT: i64 = 1 << 20;

/// An angle as a combination of those of Gaussian primes and π/4.
pub(super) struct GaussianAngle {
    /// p and k_p.
    pub(super) primes: Vec<(u64, i64)>,
    /// m.
    pub(super) eighths: i64,
}

impl GaussianAngle {
    /// Angle of the point (x, y); `None` for (0, 0), which has none, and if x² + y² is too large to be factored.
    pub(super) fn of(x: &RBig, y: &RBig, found: &mut Vec<u64>) -> Option<Self> {
        let (a, b) =
            (x.numerator() * IBig::from(y.denominator().clone()), y.numerator() * IBig::from(x.denominator().clone()));
        if a.is_zero() && b.is_zero() {
            return None;
        }
        let g = IBig::from((&a).gcd(&b));
        let (a, b) = (a / &g, b / &g);
        let norm = RBig::from(&a * &a + &b * &b);
        let mut angle = b.to_f64().value().atan2(a.to_f64().value());
        let mut primes = Vec::new();
        for (p, k) in factors(&norm, found)? {
            if p == 2 {
                continue;
            }
            if p >= PRIME || k > MAX_EXPONENT {
                return None;
            }
            let (c, d) = sum_of_squares(p)?;
            // a + i b is divisible by c + i d or by its conjugate, not by both.
            let (c, d, p) = (IBig::from(c), IBig::from(d), IBig::from(p));
            let divides = ((&a * &c + &b * &d) % &p).is_zero() && ((&b * &c - &a * &d) % &p).is_zero();
            let k = if divides { k } else { -k };
            angle -= k as f64 * d.to_f64().value().atan2(c.to_f64().value());
            primes.push((u64::try_from(p.unsigned_abs()).ok()?, k));
        }
        let eighths = (angle / FRAC_PI_4).round();
        ((angle / FRAC_PI_4 - eighths).abs() < 1e-6).then_some(Self { primes, eighths: eighths as i64 })
    }
}

/// c > d > 0 with p = c² + d², for a prime p that is 1 modulo 4.
fn sum_of_squares(p: u64) -> Option<(u64, u64)> {
    (1..=p.isqrt()).find_map(|d| {
        let c = (p - d * d).isqrt();
        (c * c + d * d == p).then_some((c.max(d), c.min(d)))
    })
}
