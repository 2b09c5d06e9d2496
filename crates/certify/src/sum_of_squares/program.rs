//! Polynomials with unknown coefficients that are to be sums of squares.

use std::collections::BTreeSet;

use bracketry_lie::linear::{MultivariatePolynomial, RationalMatrix};
use bracketry_symbolic::Rational;

use crate::gram::power;
use crate::monomials::{Monomial, product};

/// p(x; y) = p_0(x) + Σ y_j p_j(x).
#[derive(Clone, Debug, Default)]
pub(crate) struct AffinePolynomial {
    pub(crate) constant: MultivariatePolynomial,
    pub(crate) linear: Vec<MultivariatePolynomial>,
}

impl AffinePolynomial {
    /// At given y.
    pub(crate) fn at(&self, y: &[Rational]) -> MultivariatePolynomial {
        self.linear.iter().zip(y).fold(self.constant.clone(), |sum, (p, c)| sum.plus(p, c))
    }

    /// This with `f` applied to each part; f is linear.
    pub(crate) fn mapped(&self, f: impl Fn(&MultivariatePolynomial) -> MultivariatePolynomial) -> Self {
        AffinePolynomial { constant: f(&self.constant), linear: self.linear.iter().map(f).collect() }
    }

    fn support(&self) -> BTreeSet<Monomial> {
        self.linear.iter().chain([&self.constant]).flat_map(|p| p.terms().map(|(m, _)| m.clone())).collect()
    }

    /// Whether no unknown occurs.
    pub(crate) fn is_fixed(&self) -> bool {
        self.linear.iter().all(MultivariatePolynomial::is_zero)
    }
}

/// A polynomial that is to be zᵀ Q z.
#[derive(Clone, Debug)]
pub(crate) struct Constraint {
    pub(crate) polynomial: AffinePolynomial,
    /// z.
    pub(crate) basis: Vec<Monomial>,
    /// How far Q is to be from singular.
    pub(crate) margin: Margin,
}

/// How far a Gram matrix is to be from singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Margin {
    /// Q ⪰ 1, which fixes the size of what may be multiplied by any number.
    One,
    /// Q ⪰ t 1 with the largest t ≤ 1.
    Largest,
}

impl Constraint {
    /// Drops monomials whose square occurs neither in the polynomial nor as the product of two others: the diagonal entry of Q, and
    /// with it the row, is zero.
    fn prune(&mut self) {
        let support = self.polynomial.support();
        loop {
            let basis = &self.basis;
            let others: BTreeSet<Monomial> =
                (0..basis.len()).flat_map(|i| (0..i).map(move |j| product(&basis[i], &basis[j]))).collect();
            let needed = |m: &&Monomial| {
                let square = product(m, m);
                support.contains(&square) || others.contains(&square)
            };
            let kept: Vec<Monomial> = basis.iter().filter(needed).cloned().collect();
            if kept.len() == basis.len() {
                return;
            }
            self.basis = kept;
        }
    }

    /// The monomials of zᵀ Q z.
    pub(crate) fn products(&self) -> BTreeSet<Monomial> {
        let basis = &self.basis;
        (0..basis.len()).flat_map(|i| (0..=i).map(move |j| product(&basis[i], &basis[j]))).collect()
    }
}

/// Unknown y so that all constraints are sums of squares, and other polynomials of them that are zero.
#[derive(Clone, Debug, Default)]
pub(crate) struct Program {
    pub(crate) unknowns: usize,
    pub(crate) constraints: Vec<Constraint>,
    pub(crate) zero: Vec<AffinePolynomial>,
}

/// Most monomials of one Gram matrix, and rows of all together: a program of this size takes seconds.
const MAX_BASIS: usize = 90;
const MAX_ROWS: usize = 1600;
/// The same before the reduction, and most unknowns.
const MAX_BEFORE: usize = 250;
pub(crate) const MAX_UNKNOWNS: usize = 600;

/// Why a program has no solution, or is not solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unsolved {
    /// The linear equations alone have no solution: exact.
    Contradiction,
    /// Too many monomials.
    TooLarge,
    /// The semidefinite program has no solution that satisfies the constraints with a margin, up to rounding.
    NotFeasible,
    /// The numerical solution did not pass the exact check.
    NotRounded,
    /// Out of time, or stopped.
    OutOfTime,
}

/// A program without superfluous monomials, in unknowns that satisfy the linear equations: y = origin + Σ y'_j directions_j.
#[derive(Clone, Debug)]
pub(crate) struct Reduced {
    pub(crate) program: Program,
    origin: Vec<Rational>,
    directions: Vec<Vec<Rational>>,
}

impl Reduced {
    /// The unknowns of the original program.
    pub(crate) fn original(&self, y: &[Rational]) -> Vec<Rational> {
        combined(&self.origin, &self.directions, y)
    }
}

fn combined(origin: &[Rational], directions: &[Vec<Rational>], y: &[Rational]) -> Vec<Rational> {
    let mut out = origin.to_vec();
    for (d, c) in directions.iter().zip(y) {
        for (sum, x) in out.iter_mut().zip(d) {
            *sum += x * c;
        }
    }
    out
}

impl Program {
    /// The program in ξ with x_i = 2^k_i ξ_i; the unknowns stay the same.
    pub(crate) fn scaled(mut self, powers: &[i32]) -> Self {
        let replace = |p: &MultivariatePolynomial| {
            p.terms().fold(MultivariatePolynomial::default(), |mut sum, (m, c)| {
                sum.add_term(m.clone(), c * power(m, powers));
                sum
            })
        };
        for c in &mut self.constraints {
            c.polynomial = c.polynomial.mapped(replace);
        }
        for p in &mut self.zero {
            *p = p.mapped(replace);
        }
        self
    }

    /// Exact elimination: superfluous monomials are dropped, and the coefficients of monomials that then no product of two
    /// matches are zero, which are linear equations of the unknowns; both until nothing changes.
    pub(crate) fn reduced(mut self) -> Result<Reduced, Unsolved> {
        if self.unknowns > MAX_UNKNOWNS || self.constraints.iter().any(|c| c.basis.len() > MAX_BEFORE) {
            return Err(Unsolved::TooLarge);
        }
        let mut origin = vec![Rational::ZERO; self.unknowns];
        let mut directions: Vec<Vec<Rational>> = (0..self.unknowns)
            .map(|k| (0..self.unknowns).map(|i| if i == k { Rational::ONE } else { Rational::ZERO }).collect())
            .collect();
        loop {
            let mut rows: Vec<Vec<Rational>> = Vec::new();
            let mut require = |p: &AffinePolynomial, m: &Monomial| {
                rows.push(p.linear.iter().chain([&p.constant]).map(|q| q.coefficient(m)).collect());
            };
            for c in &mut self.constraints {
                c.prune();
                let products = c.products();
                for m in c.polynomial.support().difference(&products) {
                    require(&c.polynomial, m);
                }
            }
            for p in &self.zero {
                for m in p.support() {
                    require(p, &m);
                }
            }
            if rows.is_empty() {
                break;
            }
            // [L, r] (y, 1) = 0.
            let solutions = RationalMatrix::new(rows, self.unknowns + 1).null_space();
            let (last, homogeneous): (Vec<_>, Vec<_>) =
                solutions.into_iter().partition(|v| v[self.unknowns] != Rational::ZERO);
            // Only the last column, where it is free, has an entry there.
            let Some(mut start) = last.into_iter().next() else { return Err(Unsolved::Contradiction) };
            start.truncate(self.unknowns);
            let homogeneous: Vec<Vec<Rational>> = homogeneous
                .into_iter()
                .map(|mut v| {
                    v.truncate(self.unknowns);
                    v
                })
                .collect();
            origin = combined(&origin, &directions, &start);
            directions =
                homogeneous.iter().map(|v| combined(&vec![Rational::ZERO; origin.len()], &directions, v)).collect();
            let replace = |p: &AffinePolynomial| AffinePolynomial {
                constant: p.at(&start),
                linear: homogeneous
                    .iter()
                    .map(|v| p.linear.iter().zip(v).fold(MultivariatePolynomial::default(), |s, (q, c)| s.plus(q, c)))
                    .collect(),
            };
            for c in &mut self.constraints {
                c.polynomial = replace(&c.polynomial);
            }
            for p in &mut self.zero {
                *p = replace(p);
            }
            self.zero.retain(|p| !p.is_fixed() || !p.constant.is_zero());
            self.unknowns = homogeneous.len();
        }
        let rows: usize = self.constraints.iter().map(|c| c.products().len()).sum();
        if rows > MAX_ROWS || self.constraints.iter().any(|c| c.basis.len() > MAX_BASIS) {
            return Err(Unsolved::TooLarge);
        }
        Ok(Reduced { program: self, origin, directions })
    }
}
