//! Which motions stay where a rate vanishes.

use bracketry_lie::linear::MultivariatePolynomial;
use bracketry_symbolic::{Rational, UnivariatePolynomial};

use crate::gram::Gram;
use crate::model::rate;

/// Polynomials with more terms are left aside.
const MAX_TERMS: usize = 200;

/// Whether the origin is the only motion of x' = f(x) along which the polynomial of a semidefinite Gram matrix stays zero: there
/// Q z(x) = 0, with all time derivatives. Exact; false where elimination does not decide.
pub(crate) fn only_the_origin(field: &[MultivariatePolynomial], gram: &Gram) -> bool {
    let n = field.len();
    let term = |m: &Vec<u32>, c: &Rational| MultivariatePolynomial::term(c.clone(), m.clone());
    let mut level: Vec<MultivariatePolynomial> = gram
        .matrix
        .iter()
        .map(|row| {
            let zero = MultivariatePolynomial::default();
            row.iter().zip(&gram.monomials).fold(zero, |sum, (q, m)| sum.plus(&term(m, q), &Rational::ONE))
        })
        .collect();
    let mut vanishing: Vec<MultivariatePolynomial> = Vec::new();
    for _ in 0..=n {
        level.retain(|p| !p.is_zero() && p.terms().count() <= MAX_TERMS);
        vanishing.extend(level.iter().cloned());
        if forces_zero(n, vanishing.clone(), field) {
            return true;
        }
        level = level.iter().map(|p| rate(p, field)).collect();
    }
    false
}

/// Whether the polynomials have no common real zero but 0 along a motion, by elimination: a variable that is zero makes its derivative
/// vanish, too.
fn forces_zero(n: usize, mut list: Vec<MultivariatePolynomial>, field: &[MultivariatePolynomial]) -> bool {
    let mut zero: Vec<usize> = Vec::new();
    // Variables that equal a polynomial of others.
    let mut replaced: Vec<(usize, MultivariatePolynomial)> = Vec::new();
    loop {
        let found = list.iter().find_map(|p| vanishing_variables(p, n));
        if let Some(variables) = found {
            let new: Vec<usize> = variables.into_iter().filter(|i| !zero.contains(i)).collect();
            zero.extend(&new);
            list.extend(new.iter().map(|&i| field[i].clone()));
        } else if let Some((k, i, value)) =
            list.iter().enumerate().find_map(|(k, p)| solved(p, n).map(|(i, v)| (k, i, v)))
        {
            list.remove(k);
            replaced.push((i, value));
        } else {
            break;
        }
        list = list.into_iter().filter_map(|p| reduced(&p, &zero, &replaced)).collect();
        list.retain(|p| !p.is_zero());
        for (_, value) in &mut replaced {
            *value = value.without(&zero);
        }
    }
    (0..n).all(|i| zero.contains(&i) || replaced.iter().any(|(j, value)| *j == i && value.is_zero()))
}

fn reduced(
    p: &MultivariatePolynomial,
    zero: &[usize],
    replaced: &[(usize, MultivariatePolynomial)],
) -> Option<MultivariatePolynomial> {
    replaced.iter().try_fold(p.without(zero), |p, (i, value)| Some(p.with(*i, value)?.without(zero)))
}

/// Variables that are zero where the polynomial is: that of a polynomial of one variable with no other real root, and all of a sum of
/// even powers with factors of one sign.
fn vanishing_variables(p: &MultivariatePolynomial, n: usize) -> Option<Vec<usize>> {
    let used: Vec<usize> = (0..n).filter(|&i| p.terms().any(|(m, _)| m[i] > 0)).collect();
    if let [i] = used[..] {
        let degree = p.degree() as usize;
        let coefficient = |k: usize| {
            let mut m = vec![0; n];
            m[i] = k as u32;
            p.coefficient(&m)
        };
        let q = UnivariatePolynomial::new((0..=degree).map(coefficient).collect());
        let lowest = (0..=degree).find(|&k| coefficient(k) != Rational::ZERO)?;
        // Without the root at zero.
        let rest = UnivariatePolynomial::new(q.coefficients()[lowest..].to_vec());
        return (lowest > 0 && rest.roots().is_empty()).then_some(vec![i]);
    }
    let pure = |m: &[u32]| used.iter().filter(|&&i| m[i] > 0).count() == 1 && m.iter().all(|k| k % 2 == 0);
    let positive = p.terms().filter(|(_, c)| **c > Rational::ZERO).count();
    let one_sign = positive == 0 || positive == p.terms().count();
    (used.len() > 1 && one_sign && p.terms().all(|(m, _)| pure(m))).then_some(used)
}

/// A variable that occurs once, linearly with a constant factor, with what it equals.
fn solved(p: &MultivariatePolynomial, n: usize) -> Option<(usize, MultivariatePolynomial)> {
    (0..n).find_map(|i| {
        let mut with = p.terms().filter(|(m, _)| m[i] > 0);
        let (m, c) = with.next()?;
        if with.next().is_some() || m.iter().sum::<u32>() != 1 {
            return None;
        }
        let linear = MultivariatePolynomial::term(c.clone(), m.clone());
        let rest = p.plus(&linear, &Rational::from(-1));
        Some((i, MultivariatePolynomial::default().plus(&rest, &(Rational::from(-1) / c))))
    })
}
