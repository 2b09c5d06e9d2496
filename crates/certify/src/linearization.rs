//! The linear part of a polynomial model.

use bracketry_lie::linear::{MultivariatePolynomial, RationalMatrix, half_planes};
use bracketry_numerics::matrix_equations::lyapunov;
use bracketry_symbolic::Rational;
use nalgebra::DMatrix;

use crate::model::PolynomialModel;
use crate::monomials::Monomial;
use crate::sum_of_squares::decimals::rounded;

pub(crate) fn unit(n: usize, i: usize) -> Monomial {
    (0..n).map(|k| u32::from(k == i)).collect()
}

/// A = ∂f/∂x at the equilibrium.
pub(crate) fn jacobian(model: &PolynomialModel) -> RationalMatrix {
    let n = model.dimension();
    let rows = model.drift.iter().map(|f| (0..n).map(|j| f.coefficient(&unit(n, j))).collect()).collect();
    RationalMatrix::new(rows, n)
}

/// Eigenvalues of A with negative, zero, and positive real part.
pub(crate) fn eigenvalues(model: &PolynomialModel) -> [usize; 3] {
    half_planes(&jacobian(model))
}

/// P with Aᵀ P + P A = −Q; `None` where the equations are singular, or P is not positive definite.
pub(crate) fn lyapunov_matrix(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let p = lyapunov(&a.transpose(), q)?;
    let transposed = p.transpose();
    let p = (p + transposed) * 0.5;
    (p.iter().all(|x| x.is_finite()) && p.clone().cholesky().is_some()).then_some(p)
}

/// xᵀ P x with P rounded to three digits, or to more where it is not positive definite then.
pub(crate) fn quadratic(p: &DMatrix<f64>) -> Option<MultivariatePolynomial> {
    let n = p.nrows();
    [3, 6, 9, 12].into_iter().find_map(|digits| {
        let entries = rounded(p.as_slice(), digits);
        let at = |i: usize, j: usize| entries[i.max(j) * n + i.min(j)].clone();
        let matrix = RationalMatrix::new((0..n).map(|i| (0..n).map(|j| at(i, j)).collect()).collect(), n);
        let definite = matrix.is_positive_semidefinite() && matrix.null_space().is_empty();
        let mut v = MultivariatePolynomial::default();
        for i in 0..n {
            for j in 0..n {
                let m = unit(n, i).iter().zip(unit(n, j)).map(|(a, b)| a + b).collect();
                v.add_term(m, at(i, j));
            }
        }
        definite.then_some(v)
    })
}

pub(crate) fn numbers(a: &RationalMatrix) -> DMatrix<f64> {
    let n = a.rows().len();
    DMatrix::from_fn(n, n, |i, j| a.rows()[i][j].to_f64().value())
}

/// Most states: the equation of P has the square of their number.
const MAX_STATES: usize = 24;

/// P for Q = 1 of the model's linearization, where that is stable.
pub(crate) fn lyapunov_of(model: &PolynomialModel) -> Option<DMatrix<f64>> {
    if model.dimension() > MAX_STATES {
        return None;
    }
    let a = numbers(&jacobian(model));
    lyapunov_matrix(&a, &DMatrix::identity(a.nrows(), a.nrows()))
}

/// Exponents k of the lengths 2^k by which states are divided, so that {xᵀ P x ≤ c} is about as wide as 1 along each.
pub(crate) fn lengths(p: &DMatrix<f64>, c: f64) -> Vec<i32> {
    let inverse = p.clone().try_inverse();
    (0..p.nrows())
        .map(|i| {
            let square = inverse.as_ref().map_or(1.0, |q| q[(i, i)] * c);
            let k = (square.log2() / 2.0).round();
            if k.is_finite() { k.clamp(-60.0, 60.0) as i32 } else { 0 }
        })
        .collect()
}

/// Coefficients as floating-point numbers, to be evaluated.
pub(crate) struct Evaluated(Vec<(Vec<u32>, f64)>);

impl Evaluated {
    pub(crate) fn new(p: &MultivariatePolynomial) -> Self {
        Evaluated(p.terms().map(|(m, c)| (m.clone(), c.to_f64().value())).collect())
    }

    pub(crate) fn at(&self, x: &[f64]) -> f64 {
        self.0.iter().map(|(m, c)| m.iter().zip(x).fold(*c, |y, (&k, x)| y * x.powi(k as i32))).sum()
    }
}

/// 1 or −1 times a rational number.
pub(crate) fn negative(p: &MultivariatePolynomial) -> MultivariatePolynomial {
    MultivariatePolynomial::default().plus(p, &Rational::from(-1))
}
