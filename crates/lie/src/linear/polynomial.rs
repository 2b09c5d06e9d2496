//! Polynomials of several variables.

use std::collections::BTreeMap;

use bracketry_symbolic::{Expr, OrderedField, Pool, Rational, Real, Symbol};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A polynomial; its variables are numbered.
#[derive(Clone, Debug, PartialEq)]
pub struct MultivariatePolynomial<C = Rational> {
    /// Coefficients, none zero, by the exponents of the variables.
    terms: BTreeMap<Vec<u32>, C>,
}

/// A polynomial whose coefficients need not be rational.
pub(crate) type RealPolynomial = MultivariatePolynomial<Real>;

impl<C> Default for MultivariatePolynomial<C> {
    fn default() -> Self {
        MultivariatePolynomial { terms: BTreeMap::new() }
    }
}

/// As a list of exponents with coefficients, such as `[[[2, 0], "3/4"]]`.
impl Serialize for MultivariatePolynomial {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.terms.iter().map(|(m, c)| (m, c.to_string())))
    }
}

impl<'de> Deserialize<'de> for MultivariatePolynomial {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut p = Self::default();
        for (m, c) in Vec::<(Vec<u32>, String)>::deserialize(deserializer)? {
            let c = c.parse::<Rational>().map_err(|_| D::Error::custom(format!("`{c}` is not a rational number")))?;
            p.add_term(m, c);
        }
        Ok(p)
    }
}

/// The exponents of the variable of number k among n.
pub(crate) fn unit(n: usize, k: usize) -> Vec<u32> {
    (0..n).map(|i| u32::from(i == k)).collect()
}

/// A polynomial with more terms is given up.
pub(crate) const MAX_TERMS: usize = 300;

impl MultivariatePolynomial {
    /// `e` as a polynomial in `symbols`; `None` if it is none with rational coefficients, or has too many terms.
    pub fn of(pool: &mut Pool, e: Expr, symbols: &[Symbol]) -> Option<Self> {
        let mut p = Self::default();
        for (exponents, c) in pool.coefficients(e, symbols) {
            p.add_term(exponents, pool.constant_rational(c)?);
        }
        (p.terms.len() <= MAX_TERMS).then_some(p)
    }
}

impl<C: OrderedField> MultivariatePolynomial<C> {
    /// c · Π x_i^k_i.
    pub fn term(c: C, exponents: Vec<u32>) -> Self {
        let mut p = Self::default();
        p.add_term(exponents, c);
        p
    }

    /// The polynomial with the other sign.
    #[must_use]
    pub fn negative(&self) -> Self {
        MultivariatePolynomial { terms: self.terms.iter().map(|(m, c)| (m.clone(), c.negative())).collect() }
    }

    /// Exponents and coefficients of all terms.
    pub fn terms(&self) -> impl Iterator<Item = (&Vec<u32>, &C)> {
        self.terms.iter()
    }

    /// Whether no term is left.
    pub fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    /// Adds c · Π x_i^k_i.
    pub fn add_term(&mut self, exponents: Vec<u32>, c: C) {
        let sum = match self.terms.remove(&exponents) {
            Some(old) => old.plus(&c),
            None => c,
        };
        if !sum.is_zero() {
            self.terms.insert(exponents, sum);
        }
    }

    /// The coefficient of Π x_i^k_i.
    pub fn coefficient(&self, exponents: &[u32]) -> C {
        self.terms.get(exponents).cloned().unwrap_or(C::ZERO)
    }

    /// Σ terms of this with the factor `c`.
    #[must_use]
    pub fn plus(&self, other: &Self, c: &C) -> Self {
        let mut sum = self.clone();
        for (m, x) in &other.terms {
            sum.add_term(m.clone(), x.times(c));
        }
        sum
    }

    /// The product.
    #[must_use]
    pub fn product(&self, other: &Self) -> Self {
        let mut product = Self::default();
        for (a, x) in &self.terms {
            for (b, y) in &other.terms {
                product.add_term(a.iter().zip(b).map(|(i, j)| i + j).collect(), x.times(y));
            }
        }
        product
    }

    /// The product; `None` where it has too many terms.
    pub fn times(&self, other: &Self) -> Option<Self> {
        let mut product = Self::default();
        for (a, x) in &self.terms {
            for (b, y) in &other.terms {
                product.add_term(a.iter().zip(b).map(|(i, j)| i + j).collect(), x.times(y));
            }
            if product.terms.len() > MAX_TERMS {
                return None;
            }
        }
        Some(product)
    }

    /// The product without the terms above a degree.
    #[must_use]
    pub(crate) fn times_up_to(&self, other: &Self, degree: u32) -> Self {
        let total = |m: &[u32]| m.iter().sum::<u32>();
        let mut product = Self::default();
        for (a, x) in self.terms.iter().filter(|(a, _)| total(a) <= degree) {
            for (b, y) in other.terms.iter().filter(|(b, _)| total(a) + total(b) <= degree) {
                product.add_term(a.iter().zip(b).map(|(i, j)| i + j).collect(), x.times(y));
            }
        }
        product
    }

    /// This with polynomials in place of all variables, without the terms above a degree; `variables` is their number.
    #[must_use]
    pub(crate) fn composed(&self, values: &[Self], variables: usize, degree: u32) -> Self {
        let mut sum = Self::default();
        for (m, c) in &self.terms {
            let mut product = Self::term(c.clone(), vec![0; variables]);
            for (&k, value) in m.iter().zip(values) {
                for _ in 0..k {
                    product = product.times_up_to(value, degree);
                }
            }
            sum = sum.plus(&product, &C::ONE);
        }
        sum
    }

    /// The terms of one degree.
    #[must_use]
    pub(crate) fn of_degree(&self, degree: u32) -> Self {
        let kept = self.terms.iter().filter(|(m, _)| m.iter().sum::<u32>() == degree);
        MultivariatePolynomial { terms: kept.map(|(m, c)| (m.clone(), c.clone())).collect() }
    }

    /// The derivative by one variable.
    #[must_use]
    pub fn derivative(&self, variable: usize) -> Self {
        let mut d = Self::default();
        for (m, c) in &self.terms {
            let k = m[variable];
            if k > 0 {
                let mut lower = m.clone();
                lower[variable] = k - 1;
                d.add_term(lower, c.times(&C::of(Rational::from(k))));
            }
        }
        d
    }

    /// This with `value` in place of a variable; `None` where that has too many terms.
    pub fn with(&self, variable: usize, value: &Self) -> Option<Self> {
        let mut sum = Self::default();
        for (m, c) in &self.terms {
            let mut rest = m.clone();
            let k = std::mem::take(&mut rest[variable]);
            let mut part = Self::term(c.clone(), rest);
            for _ in 0..k {
                part = part.times(value)?;
            }
            sum = sum.plus(&part, &C::ONE);
            if sum.terms.len() > MAX_TERMS {
                return None;
            }
        }
        Some(sum)
    }

    /// This where some variables are zero.
    #[must_use]
    pub fn without(&self, variables: &[usize]) -> Self {
        let kept = self.terms.iter().filter(|(m, _)| variables.iter().all(|&i| m[i] == 0));
        MultivariatePolynomial { terms: kept.map(|(m, c)| (m.clone(), c.clone())).collect() }
    }

    /// The terms of least degree.
    #[must_use]
    pub fn leading_form(&self) -> Self {
        self.of_degree(self.order())
    }

    /// Largest degree of a term; 0 for zero.
    pub fn degree(&self) -> u32 {
        self.terms.keys().map(|m| m.iter().sum::<u32>()).max().unwrap_or(0)
    }

    /// Degree of the terms of least degree; 0 for zero.
    pub fn order(&self) -> u32 {
        self.terms.keys().map(|m| m.iter().sum::<u32>()).min().unwrap_or(0)
    }
}
