//! Polynomials in one variable, and the real roots of those with rational coefficients.

mod integer;

use std::cmp::Ordering;

use dashu_int::IBig;

use crate::Rational;
use crate::exact::{OrderedField, Real};
use integer::{IntegerPolynomial, Isolated};

/// A polynomial Σ c_k x^k: c_k at index k, the last not zero; no coefficients for zero.
///
/// ```
/// use bracketry_symbolic::{Rational, UnivariatePolynomial};
/// let p = UnivariatePolynomial::new([-2, 0, 1].map(Rational::from).to_vec());
/// assert_eq!(p.roots().iter().map(|r| r.value).collect::<Vec<_>>(), [-2f64.sqrt(), 2f64.sqrt()]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct UnivariatePolynomial<C = Rational>(Vec<C>);

/// Numbers that are coefficients of polynomials.
pub trait Coefficient: OrderedField {
    /// See [`UnivariatePolynomial::gcd`].
    fn gcd(p: &UnivariatePolynomial<Self>, q: &UnivariatePolynomial<Self>) -> UnivariatePolynomial<Self>;
    /// See [`UnivariatePolynomial::signed_remainders`].
    fn signed_remainders(
        f: &UnivariatePolynomial<Self>,
        g: &UnivariatePolynomial<Self>,
    ) -> Vec<UnivariatePolynomial<Self>>;
}

impl Coefficient for Rational {
    fn gcd(p: &UnivariatePolynomial, q: &UnivariatePolynomial) -> UnivariatePolynomial {
        UnivariatePolynomial(IntegerPolynomial::of(&p.0).gcd(&IntegerPolynomial::of(&q.0)).rational()).monic()
    }

    fn signed_remainders(f: &UnivariatePolynomial, g: &UnivariatePolynomial) -> Vec<UnivariatePolynomial> {
        let chain = IntegerPolynomial::signed_remainders(IntegerPolynomial::of(&f.0), IntegerPolynomial::of(&g.0));
        chain.iter().map(|p| UnivariatePolynomial(p.rational())).collect()
    }
}

impl Coefficient for Real {
    fn gcd(p: &UnivariatePolynomial<Real>, q: &UnivariatePolynomial<Real>) -> UnivariatePolynomial<Real> {
        let (mut a, mut b) = (p.monic(), q.monic());
        while !b.is_zero() {
            // Leading coefficients 1 keep the numbers from growing.
            let rest = a.remainder(&b).monic();
            a = std::mem::replace(&mut b, rest);
        }
        a
    }

    fn signed_remainders(
        f: &UnivariatePolynomial<Real>,
        g: &UnivariatePolynomial<Real>,
    ) -> Vec<UnivariatePolynomial<Real>> {
        let mut chain = vec![f.clone(), g.clone()];
        while let [.., a, b] = &chain[..]
            && !b.is_zero()
        {
            let rest = a.remainder(b).scaled(&Real::from(-1));
            chain.push(rest);
        }
        chain.pop();
        chain
    }
}

/// A real root: an interval with rational ends that holds no other; so narrow, where the root is irrational, that its ends agree to the
/// accuracy of `f64`.
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

impl<C: Coefficient> UnivariatePolynomial<C> {
    /// From coefficients, that of degree k at index k.
    pub fn new(mut coefficients: Vec<C>) -> Self {
        while coefficients.last().is_some_and(C::is_zero) {
            coefficients.pop();
        }
        UnivariatePolynomial(coefficients)
    }

    /// The coefficients, that of degree k at index k.
    pub fn coefficients(&self) -> &[C] {
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
    pub fn leading(&self) -> C {
        self.0.last().cloned().unwrap_or(C::ZERO)
    }

    /// The coefficient of the lowest power that occurs.
    pub fn lowest(&self) -> C {
        self.0.iter().find(|c| !c.is_zero()).cloned().unwrap_or(C::ZERO)
    }

    /// The value at x.
    pub fn at(&self, x: &C) -> C {
        self.0.iter().rev().fold(C::ZERO, |sum, c| sum.times(x).plus(c))
    }

    /// dp/dx.
    #[must_use]
    pub fn derivative(&self) -> Self {
        Self::new(self.0.iter().enumerate().skip(1).map(|(k, c)| c.times(&C::of(Rational::from(k)))).collect())
    }

    /// p − q.
    #[must_use]
    pub fn sub(&self, other: &Self) -> Self {
        let n = self.0.len().max(other.0.len());
        let c = |p: &Self, k: usize| p.0.get(k).cloned().unwrap_or(C::ZERO);
        let difference = |k: usize| {
            let mut x = c(self, k);
            x.subtract_product(&c(other, k), &C::ONE);
            x
        };
        Self::new((0..n).map(difference).collect())
    }

    /// p + q.
    #[must_use]
    pub fn add(&self, other: &Self) -> Self {
        self.sub(&other.scaled(&C::ONE.negative()))
    }

    /// c p.
    #[must_use]
    pub fn scaled(&self, factor: &C) -> Self {
        Self::new(self.0.iter().map(|c| c.times(factor)).collect())
    }

    /// The multiple with leading coefficient 1; 0 for 0.
    fn monic(&self) -> Self {
        self.leading().inverse().map_or_else(|| self.clone(), |inverse| self.scaled(&inverse))
    }

    /// p q.
    #[must_use]
    pub fn mul(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::new(Vec::new());
        }
        let mut out = vec![C::ZERO; self.0.len() + other.0.len() - 1];
        for (i, a) in self.0.iter().enumerate() {
            let opposite = a.negative();
            for (j, b) in other.0.iter().enumerate() {
                out[i + j].subtract_product(&opposite, b);
            }
        }
        Self::new(out)
    }

    /// Quotient and remainder; `divisor` must not be zero.
    fn divided(&self, divisor: &Self) -> (Self, Self) {
        let mut rest = self.0.clone();
        let d = divisor.degree();
        let inverse = divisor.leading().inverse().unwrap_or(C::ZERO);
        let mut quotient = vec![C::ZERO; (rest.len()).saturating_sub(d)];
        while let Some(k) = rest.len().checked_sub(1 + d) {
            let Some(mut factor) = rest.pop() else { break };
            factor.scale(&inverse);
            for (i, c) in divisor.0.iter().take(d).enumerate() {
                rest[k + i].subtract_product(&factor, c);
            }
            quotient[k] = factor;
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
        C::gcd(self, other)
    }

    /// f, g, and the negative remainders of Euclid's algorithm up to positive factors; the last is a greatest common divisor (Sturm).
    pub fn signed_remainders(f: &Self, g: &Self) -> Vec<Self> {
        C::signed_remainders(f, g)
    }
}

impl UnivariatePolynomial {
    /// The coefficients of the multiple by a positive number that has integer coefficients without a common divisor.
    pub fn integer_coefficients(&self) -> Vec<IBig> {
        IntegerPolynomial::of(&self.0).coefficients().to_vec()
    }

    /// p without multiple roots, with integer coefficients.
    fn square_free(&self) -> IntegerPolynomial {
        IntegerPolynomial::of(&self.quotient(&self.gcd(&self.derivative())).0)
    }

    /// Whether there is a root in the closed interval.
    pub fn has_root_between(&self, [a, b]: &[Rational; 2]) -> bool {
        let p = self.square_free();
        if p.sign_at(a) == Ordering::Equal {
            return true;
        }
        // Sign changes of Sturm's sequence tell the number of roots in (a, b].
        let chain = IntegerPolynomial::signed_remainders(p.clone(), p.derivative());
        let variations = |x: &Rational| {
            let signs: Vec<Ordering> = chain.iter().map(|p| p.sign_at(x)).filter(|s| *s != Ordering::Equal).collect();
            signs.windows(2).filter(|w| w[0] != w[1]).count()
        };
        variations(a) > variations(b)
    }

    /// The distinct real roots, ascending; none for a constant.
    pub fn roots(&self) -> Vec<RealRoot> {
        if self.degree() == 0 {
            return Vec::new();
        }
        let mut p = self.square_free();
        let mut roots = Vec::new();
        if p.coefficients()[0] == IBig::ZERO {
            roots.push(RealRoot::exactly(Rational::ZERO));
            p = IntegerPolynomial::of(&p.rational()[1..]);
        }
        let mirrored: Vec<Rational> =
            p.rational().into_iter().enumerate().map(|(k, c)| if k % 2 == 1 { -c } else { c }).collect();
        let mirrored = IntegerPolynomial::of(&mirrored);
        roots.extend(p.positive_roots().into_iter().map(|root| RealRoot::refined(&p, root)));
        roots.extend(mirrored.positive_roots().into_iter().map(|root| RealRoot::refined(&mirrored, root).negative()));
        roots.sort_by(|a, b| a.between[0].cmp(&b.between[0]));
        // Around a root that is known lies an interval that holds no other.
        let known: Vec<bool> = roots.iter().map(|r| r.between[0] == r.between[1]).collect();
        let four = Rational::from(4);
        let gap = |i: usize| (&roots[i + 1].between[0] - &roots[i].between[1]) / &four;
        let gaps: Vec<Rational> = (0..roots.len().saturating_sub(1)).map(gap).collect();
        let quarter = Rational::ONE / &four;
        for i in (0..roots.len()).filter(|&i| known[i]) {
            let below = i.checked_sub(1).map_or(&quarter, |k| &gaps[k]);
            let above = gaps.get(i).unwrap_or(&quarter);
            roots[i].between[0] -= below;
            roots[i].between[1] += above;
        }
        roots
    }
}

impl RealRoot {
    fn exactly(x: Rational) -> Self {
        RealRoot { value: x.to_f64().value(), exact: Some(x.clone()), between: [x.clone(), x] }
    }

    fn negative(self) -> Self {
        let [a, b] = self.between;
        RealRoot { value: -self.value, exact: self.exact.map(|x| -x), between: [-b, -a] }
    }

    /// A simple root of p, to the accuracy of `f64`.
    fn refined(p: &IntegerPolynomial, root: Isolated) -> Self {
        let [mut a, mut b] = match root {
            Isolated::At(x) => return Self::exactly(x),
            Isolated::Between(ends) => ends,
        };
        // The sign right of the root; at b itself may be another one, of which the derivative tells.
        let right = match p.sign_at(&b) {
            Ordering::Equal => p.derivative().sign_at(&b).reverse(),
            sign => sign,
        };
        let resolution = Rational::ONE / Rational::from(IBig::ONE << ACCURACY);
        for _ in 0..MAX_HALVINGS {
            // Both ends are positive, or a is 0.
            if &b - &a <= &a * &resolution {
                break;
            }
            let middle = (&a + &b) / Rational::from(2);
            match p.sign_at(&middle) {
                Ordering::Equal => return Self::exactly(middle),
                sign if sign == right => b = middle,
                _ => a = middle,
            }
        }
        let simple = Rational::simplest_in(a.clone(), b.clone());
        if p.sign_at(&simple) == Ordering::Equal {
            return Self::exactly(simple);
        }
        RealRoot { value: b.to_f64().value(), exact: None, between: [a, b] }
    }
}
