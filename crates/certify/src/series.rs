//! Lyapunov functions as truncated power series.

use bracketry_lie::linear::MultivariatePolynomial;
use bracketry_numerics::linear_equations::solve_vector;
use bracketry_symbolic::Rational;
use nalgebra::{DMatrix, DVector};

use crate::model::PolynomialModel;
use crate::monomials::{Monomial, monomials};
use crate::sum_of_squares::decimals::rounded;

/// Most coefficients of one degree.
const MAX_COEFFICIENTS: usize = 130;
/// Digits of the coefficients behind the first one of the largest.
const DIGITS: i32 = 5;

/// V of degree `largest`, starting with xᵀ P x, whose rate is −xᵀ x (1 − γ V) up to that degree: the series of Zubov's equation, which
/// for γ = 0 is Lyapunov's (Hahn 1967, section 34). Degree by degree, the coefficients solve linear equations. `None` where these are
/// singular or many.
pub(crate) fn truncated(
    model: &PolynomialModel,
    p: &DMatrix<f64>,
    gamma: f64,
    largest: u32,
) -> Option<MultivariatePolynomial> {
    let n = model.dimension();
    let linear: Vec<MultivariatePolynomial> = model.drift.iter().map(|f| part(f, 1)).collect();
    let square = (0..n).fold(MultivariatePolynomial::default(), |mut sum, i| {
        sum.add_term((0..n).map(|k| if k == i { 2 } else { 0 }).collect(), Rational::ONE);
        sum
    });
    let gamma = Rational::try_from(gamma).ok()?;
    let mut v = crate::linearization::quadratic(p)?;
    for degree in 3..=largest {
        let list = monomials(n, degree..=degree).filter(|list| list.len() <= MAX_COEFFICIENTS)?;
        // L V_k = −(∇V·f)_k + γ (xᵀx V)_k.
        let known = square.product(&v);
        let right = MultivariatePolynomial::default()
            .plus(&part(&model.rate(&v), degree), &Rational::from(-1))
            .plus(&part(&known, degree), &gamma);
        let solution = homogeneous(&linear, &list, &right)?;
        for (m, c) in list.into_iter().zip(rounded(&solution, DIGITS)) {
            v.add_term(m, c);
        }
    }
    Some(v)
}

/// Coefficients of V with ∇V · A x = right, all of the monomials' degree.
fn homogeneous(
    linear: &[MultivariatePolynomial],
    list: &[Monomial],
    right: &MultivariatePolynomial,
) -> Option<Vec<f64>> {
    let size = list.len();
    let mut matrix = DMatrix::zeros(size, size);
    for (j, m) in list.iter().enumerate() {
        let rate = crate::model::rate(&MultivariatePolynomial::term(Rational::ONE, m.clone()), linear);
        for (i, row) in list.iter().enumerate() {
            matrix[(i, j)] = rate.coefficient(row).to_f64().value();
        }
    }
    let b = DVector::from_iterator(size, list.iter().map(|m| right.coefficient(m).to_f64().value()));
    let solution = solve_vector(matrix, &b)?;
    solution.iter().all(|x| x.is_finite()).then(|| solution.iter().copied().collect())
}

/// The terms of one degree.
fn part(p: &MultivariatePolynomial, degree: u32) -> MultivariatePolynomial {
    let mut out = MultivariatePolynomial::default();
    for (m, c) in p.terms().filter(|(m, _)| m.iter().sum::<u32>() == degree) {
        out.add_term(m.clone(), c.clone());
    }
    out
}
