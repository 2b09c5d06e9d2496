//! Combinations of functions whose rates are semidefinite to second order.

use bracketry_symbolic::{Expr, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::combination::rational_combination;
use crate::algebra::rational::readable::tidy;
use crate::controllability::local_accessibility::Frame;
use crate::linear::matrix::RationalMatrix;
use crate::linear::pencil::semidefinite_combinations;
use crate::linear::polynomial::MultivariatePolynomial;

/// Most functions.
const MAX_FUNCTIONS: usize = 6;

/// Σ λ_i φ_i whose rate along the drift has no terms of degree 1 at the point and a semidefinite form of degree 2; those of one
/// function are left out. Whether terms of higher degree leave the sign is for the caller to see.
pub(crate) fn combinations(pool: &mut Pool, frame: &Frame, functions: &[Expr]) -> Vec<Expr> {
    let (variables, offsets) = frame.deviations(pool);
    let n = variables.len();
    let mut used: Vec<Expr> = Vec::new();
    let mut rates: Vec<MultivariatePolynomial> = Vec::new();
    for &function in functions {
        if used.len() == MAX_FUNCTIONS || pool.reached_limit().is_some() {
            break;
        }
        if let Some(rate) = second_order(pool, frame, function, &variables, &offsets) {
            used.push(function);
            rates.push(rate);
        }
    }
    if used.len() < 2 {
        return Vec::new();
    }
    let exponents = |list: &[usize]| {
        let mut m = vec![0u32; n];
        for &i in list {
            m[i] += 1;
        }
        m
    };
    let linear = (0..n).map(|i| rates.iter().map(|r| r.coefficient(&exponents(&[i]))).collect()).collect();
    let free = RationalMatrix::new(linear, rates.len()).null_space();
    let two = Rational::from(2);
    let form = |c: &Vec<Rational>| {
        let total = rates.iter().zip(c).fold(MultivariatePolynomial::default(), |sum, (r, c)| sum.plus(r, c));
        let entry = |i: usize, j: usize| {
            let c = total.coefficient(&exponents(&[i, j]));
            if i == j { c } else { c / &two }
        };
        RationalMatrix::new((0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect(), n)
    };
    let forms: Vec<RationalMatrix> = free.iter().map(form).collect();
    let mut found = Vec::new();
    for c in semidefinite_combinations(&forms) {
        let of = |i: usize| free.iter().zip(&c).fold(Rational::ZERO, |s, (l, c)| s + c * &l[i]);
        let lambda: Vec<Rational> = (0..used.len()).map(of).collect();
        if lambda.iter().filter(|x| **x != Rational::ZERO).count() < 2 {
            continue;
        }
        let sum = rational_combination(pool, &used, &lambda);
        found.push(tidy(pool, sum));
    }
    found
}

/// The rate of a function along the drift up to degree 2 in the deviations from the point.
fn second_order(
    pool: &mut Pool,
    frame: &Frame,
    function: Expr,
    variables: &[Symbol],
    offsets: &FxHashMap<Expr, Expr>,
) -> Option<MultivariatePolynomial> {
    let rate = pool.lie_derivative(function, &frame.fields.states, &frame.fields.drift);
    let rate = tidy(pool, rate);
    let rate = pool.substitute(rate, offsets);
    let rate = frame.constants_in(pool, rate);
    MultivariatePolynomial::of_or_taylor(pool, rate, variables, 2)
}
