//! Polynomials in one variable with rational coefficients, and their real roots.

use crate::Rational;

/// A polynomial Σ c_k x^k: c_k at index k, the last not zero; no coefficients for zero.
///
/// ```
/// use bracketry_symbolic::{Rational, UnivariatePolynomial};
/// let p = UnivariatePolynomial::new([-2, 0, 1].map(Rational::from).to_vec());
/// assert_eq!(p.roots().iter().map(|r| r.value).collect::<Vec<_>>(), [-2f64.sqrt(), 2f64.sqrt()]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct UnivariatePolynomial(Vec<Rational>);

/// A real root: an interval with rational ends that holds no other, so narrow that its ends agree to the accuracy of `f64`.
#[derive(Clone, Debug, PartialEq)]
pub struct RealRoot {
    /// The root as a number.
    pub value: f64,
    /// The root itself, where it is rational.
    pub exact: Option<Rational>,
    /// Ends of the isolating interval.
    pub between: [Rational; 2],
}

/// An isolating interval is halved until it is narrower than its ends by this power of 2, or until there were so many halvings.
const ACCURACY: usize = 56;
const MAX_HALVINGS: usize = 1200;

impl UnivariatePolynomial {
    /// From coefficients, that of degree k at index k.
    pub fn new(mut coefficients: Vec<Rational>) -> Self {
        while coefficients.last().is_some_and(|c| *c == Rational::ZERO) {
            coefficients.pop();
        }
        UnivariatePolynomial(coefficients)
    }

    /// The coefficients, that of degree k at index k.
    pub fn coefficients(&self) -> &[Rational] {
        &self.0
    }

    /// Whether all coefficients vanish.
    pub fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    /// 0 for a constant, also for the zero polynomial.
    pub fn degree(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    /// The coefficient of the highest power; 0 for the zero polynomial.
    pub fn leading(&self) -> Rational {
        self.0.last().cloned().unwrap_or(Rational::ZERO)
    }

    /// The coefficient of the lowest power that occurs.
    pub fn lowest(&self) -> Rational {
        self.0.iter().find(|c| **c != Rational::ZERO).cloned().unwrap_or(Rational::ZERO)
    }

    /// The value at x.
    pub fn at(&self, x: &Rational) -> Rational {
        self.0.iter().rev().fold(Rational::ZERO, |sum, c| sum * x.clone() + c.clone())
    }

    /// dp/dx.
    #[must_use]
    pub fn derivative(&self) -> Self {
        Self::new(self.0.iter().enumerate().skip(1).map(|(k, c)| c.clone() * Rational::from(k)).collect())
    }

    /// p − q.
    #[must_use]
    pub fn sub(&self, other: &Self) -> Self {
        let n = self.0.len().max(other.0.len());
        let c = |p: &Self, k: usize| p.0.get(k).cloned().unwrap_or(Rational::ZERO);
        Self::new((0..n).map(|k| c(self, k) - c(other, k)).collect())
    }

    /// p + q.
    #[must_use]
    pub fn add(&self, other: &Self) -> Self {
        self.sub(&other.scaled(&Rational::from(-1)))
    }

    /// c p.
    #[must_use]
    pub fn scaled(&self, factor: &Rational) -> Self {
        Self::new(self.0.iter().map(|c| c.clone() * factor.clone()).collect())
    }

    /// p q.
    #[must_use]
    pub fn mul(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::new(Vec::new());
        }
        let mut out = vec![Rational::ZERO; self.0.len() + other.0.len() - 1];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                out[i + j] += a.clone() * b.clone();
            }
        }
        Self::new(out)
    }

    /// Quotient and remainder; `divisor` must not be zero.
    fn divided(&self, divisor: &Self) -> (Self, Self) {
        let mut rest = self.0.clone();
        let d = divisor.degree();
        let leading = divisor.leading();
        let mut quotient = vec![Rational::ZERO; (rest.len()).saturating_sub(d)];
        while rest.len() > d {
            let k = rest.len() - 1 - d;
            let factor = rest[rest.len() - 1].clone() / leading.clone();
            for (i, c) in divisor.0.iter().enumerate() {
                rest[k + i] -= factor.clone() * c.clone();
            }
            quotient[k] = factor;
            rest.pop();
        }
        (Self::new(quotient), Self::new(rest))
    }

    /// The remainder of the division by a polynomial that is not zero.
    #[must_use]
    pub fn remainder(&self, divisor: &Self) -> Self {
        self.divided(divisor).1
    }

    /// The quotient of a division without remainder; itself where `divisor` is a constant.
    #[must_use]
    pub fn quotient(&self, divisor: &Self) -> Self {
        if divisor.degree() == 0 { self.clone() } else { self.divided(divisor).0 }
    }

    /// The greatest common divisor, with leading coefficient 1; 0 for two zero polynomials.
    #[must_use]
    pub fn gcd(&self, other: &Self) -> Self {
        let (mut a, mut b) = (self.clone(), other.clone());
        while !b.is_zero() {
            let rest = a.remainder(&b);
            a = b;
            b = rest;
        }
        if a.is_zero() { a } else { a.scaled(&(Rational::ONE / a.leading())) }
    }

    /// Number of distinct real roots in the half-open interval (a, b] of a square-free polynomial (Sturm).
    fn count(chain: &[Self], a: &Rational, b: &Rational) -> usize {
        let variations = |x: &Rational| {
            let signs: Vec<bool> =
                chain.iter().map(|p| p.at(x)).filter(|v| *v != Rational::ZERO).map(|v| v > Rational::ZERO).collect();
            signs.windows(2).filter(|w| w[0] != w[1]).count()
        };
        variations(a).saturating_sub(variations(b))
    }

    /// Whether there is a root in the closed interval.
    pub fn has_root_between(&self, [a, b]: &[Rational; 2]) -> bool {
        let chain = self.sturm_chain();
        self.at(a) == Rational::ZERO || Self::count(&chain, a, b) > 0
    }

    /// p, p', and the negative remainders of Euclid's algorithm, of the square-free part.
    fn sturm_chain(&self) -> Vec<Self> {
        let common = self.gcd(&self.derivative());
        let p = self.quotient(&common);
        let mut chain = vec![p.clone(), p.derivative()];
        while let [.., a, b] = &chain[..]
            && !b.is_zero()
        {
            // Only signs matter; without the division the numbers grow exponentially.
            let rest = a.remainder(b);
            let leading = rest.leading();
            let size = if leading > Rational::ZERO { -leading } else { leading };
            chain.push(if size == Rational::ZERO { rest } else { rest.scaled(&(Rational::ONE / size)) });
        }
        chain.pop();
        chain
    }

    /// The distinct real roots, ascending; none for a constant.
    pub fn roots(&self) -> Vec<RealRoot> {
        if self.degree() == 0 {
            return Vec::new();
        }
        let chain = self.sturm_chain();
        let leading = self.leading();
        // Cauchy: every root is smaller in size than 1 + max |c_k/c_n|.
        let size = |c: &Rational| {
            let q = c.clone() / leading.clone();
            if q < Rational::ZERO { -q } else { q }
        };
        let bound = self.0.iter().map(size).fold(Rational::ZERO, |m, q| if q > m { q } else { m }) + Rational::ONE;
        let mut open = vec![[-bound.clone(), bound]];
        let mut isolated = Vec::new();
        while let Some([a, b]) = open.pop() {
            match Self::count(&chain, &a, &b) {
                0 => {}
                1 => isolated.push([a, b]),
                _ => {
                    let middle = (a.clone() + b.clone()) / Rational::from(2);
                    open.push([middle.clone(), b]);
                    open.push([a, middle]);
                }
            }
        }
        let mut roots: Vec<RealRoot> = isolated.into_iter().map(|i| Self::refined(&chain, i)).collect();
        roots.sort_by(|a, b| a.value.total_cmp(&b.value));
        roots
    }

    fn refined(chain: &[Self], [mut a, mut b]: [Rational; 2]) -> RealRoot {
        let p = &chain[0];
        let exact =
            |x: Rational, between: [Rational; 2]| RealRoot { value: x.to_f64().value(), exact: Some(x), between };
        if a < Rational::ZERO && b >= Rational::ZERO && p.at(&Rational::ZERO) == Rational::ZERO {
            return exact(Rational::ZERO, [a, b]);
        }
        // The root is simple and the only one: beyond it p has the sign that it has at b.
        let mut at_b = p.at(&b);
        let resolution = Rational::ONE / Rational::from(dashu_int::IBig::ONE << ACCURACY);
        for _ in 0..MAX_HALVINGS {
            if at_b == Rational::ZERO {
                return exact(b.clone(), [a, b]);
            }
            let size = |x: &Rational| if *x < Rational::ZERO { -x.clone() } else { x.clone() };
            let (size_a, size_b) = (size(&a), size(&b));
            let nearer = if size_a < size_b { size_a } else { size_b };
            if b.clone() - a.clone() <= nearer * resolution.clone() {
                break;
            }
            let middle = (a.clone() + b.clone()) / Rational::from(2);
            let at_middle = p.at(&middle);
            if at_middle == Rational::ZERO || (at_middle > Rational::ZERO) == (at_b > Rational::ZERO) {
                (b, at_b) = (middle, at_middle);
            } else {
                a = middle;
            }
        }
        let simple = Rational::simplest_in(a.clone(), b.clone());
        if p.at(&simple) == Rational::ZERO {
            return exact(simple, [a, b]);
        }
        RealRoot { value: b.to_f64().value(), exact: None, between: [a, b] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polynomial(c: &[i64]) -> UnivariatePolynomial {
        UnivariatePolynomial::new(c.iter().map(|&k| Rational::from(k)).collect())
    }

    #[test]
    fn roots_are_all_found_and_rational_ones_exactly() {
        // (x − 2)²(3x + 1)(x² − 2)(x² + 1)
        let factors = [&[-2, 1][..], &[-2, 1], &[1, 3], &[-2, 0, 1], &[1, 0, 1]];
        let p = factors.iter().map(|c| polynomial(c)).reduce(|a, b| a.mul(&b)).unwrap_or_else(|| polynomial(&[]));
        let roots = p.roots();
        let values: Vec<f64> = roots.iter().map(|r| r.value).collect();
        let sqrt2 = std::f64::consts::SQRT_2;
        for (found, expected) in values.iter().zip([-sqrt2, -1.0 / 3.0, sqrt2, 2.0]) {
            assert!((found - expected).abs() < 1e-15, "{values:?}");
        }
        assert_eq!(values.len(), 4);
        let exact: Vec<bool> = roots.iter().map(|r| r.exact.is_some()).collect();
        assert_eq!(exact, [false, true, false, true]);
        assert_eq!(roots[1].exact, Some(Rational::from(-1) / Rational::from(3)));
    }

    #[test]
    fn the_greatest_common_divisor_divides_both() {
        let (a, b) = (polynomial(&[-6, 1, 1]), polynomial(&[3, 4, 1]));
        assert_eq!(a.gcd(&b), polynomial(&[3, 1]));
        assert_eq!(polynomial(&[1, 0, 1]).gcd(&polynomial(&[1, 1])), polynomial(&[1]));
    }

    #[test]
    fn constants_have_no_roots() {
        assert!(polynomial(&[5]).roots().is_empty());
        assert!(polynomial(&[]).roots().is_empty());
        assert!(polynomial(&[1, 0, 1]).roots().is_empty());
        assert_eq!(polynomial(&[0, 2]).roots()[0].exact, Some(Rational::ZERO));
    }
}
