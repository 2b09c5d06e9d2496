//! Polynomials written as zᵀ Q z with a vector of monomials z and a positive semidefinite Q.

use bracketry_lie::linear::{MultivariatePolynomial, RationalMatrix};
use bracketry_symbolic::Rational;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::monomials::{Monomial, degree, product};

/// Larger exponents in a certificate are none of ours.
pub(crate) const MAX_EXPONENT: u32 = 1000;

/// zᵀ Q z: a sum of squares of polynomials where Q is positive semidefinite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gram {
    /// z, as exponents.
    pub monomials: Vec<Monomial>,
    /// Q, symmetric, of the size of z.
    #[serde(serialize_with = "write", deserialize_with = "read")]
    pub matrix: Vec<Vec<Rational>>,
}

fn write<S: Serializer>(matrix: &[Vec<Rational>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(matrix.iter().map(|row| row.iter().map(ToString::to_string).collect::<Vec<_>>()))
}

fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<Rational>>, D::Error> {
    let rows = Vec::<Vec<String>>::deserialize(deserializer)?;
    let entry = |c: String| {
        c.parse::<Rational>().map_err(|_| serde::de::Error::custom(format!("`{c}` is not a rational number")))
    };
    rows.into_iter().map(|row| row.into_iter().map(entry).collect()).collect()
}

impl Gram {
    /// Whether Q is symmetric, of the size of z, and z of `variables` variables.
    pub(crate) fn is_well_formed(&self, variables: usize) -> bool {
        let n = self.monomials.len();
        self.monomials.iter().all(|m| m.len() == variables && m.iter().all(|k| *k <= MAX_EXPONENT))
            && self.matrix.len() == n
            && self.matrix.iter().all(|row| row.len() == n)
            && (0..n).all(|i| (0..i).all(|j| self.matrix[i][j] == self.matrix[j][i]))
    }

    /// zᵀ Q z, multiplied out.
    pub fn polynomial(&self) -> MultivariatePolynomial {
        let mut p = MultivariatePolynomial::default();
        for (a, row) in self.monomials.iter().zip(&self.matrix) {
            for (b, q) in self.monomials.iter().zip(row) {
                p.add_term(product(a, b), q.clone());
            }
        }
        p
    }

    /// The Gram matrix of p(x) from that of p(s ξ) in ξ with s_i = 2^k_i.
    pub(crate) fn unscaled(mut self, powers: &[i32]) -> Self {
        let factors: Vec<Rational> = self.monomials.iter().map(|m| inverse_power(m, powers)).collect();
        for (row, a) in self.matrix.iter_mut().zip(&factors) {
            for (q, b) in row.iter_mut().zip(&factors) {
                *q *= a * b;
            }
        }
        self
    }

    fn rational_matrix(&self) -> RationalMatrix {
        RationalMatrix::new(self.matrix.clone(), self.monomials.len())
    }

    /// Whether Q is positive semidefinite, so that the polynomial is nowhere negative; exact.
    pub fn is_semidefinite(&self) -> bool {
        self.rational_matrix().is_positive_semidefinite()
    }

    /// Whether the polynomial is at least ε Σ x_i^(2 k_i) with ε > 0, so that it vanishes at the origin only and grows without
    /// bound: z has no constant but a power of each variable, and Q is positive definite; exact.
    pub fn is_definite(&self) -> bool {
        let Some(n) = self.monomials.first().map(Vec::len) else { return false };
        let power_of = |i: usize| self.monomials.iter().any(|m| m[i] > 0 && degree(m) == m[i]);
        self.monomials.iter().all(|m| degree(m) > 0)
            && (0..n).all(power_of)
            && self.is_semidefinite()
            && self.rational_matrix().null_space().is_empty()
    }
}

/// Π s_i^m_i with s_i = 2^k_i.
pub(crate) fn power(m: &[u32], powers: &[i32]) -> Rational {
    let k: i64 = m.iter().zip(powers).map(|(&m, &k)| i64::from(m) * i64::from(k)).sum();
    Rational::from(2).pow(k as isize)
}

fn inverse_power(m: &[u32], powers: &[i32]) -> Rational {
    Rational::ONE / power(m, powers)
}
