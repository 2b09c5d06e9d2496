//! First integrals with logarithms of states.

use bracketry_symbolic::{Expr, Func, Pool, Rational, Symbol};

use crate::linear::matrix::RationalMatrix;
use crate::linear::polynomial::MultivariatePolynomial;

/// Most states, and the degree of the monomials.
const MAX_STATES: usize = 6;
const DEGREE: u32 = 2;

/// Functions Σ λ_i log(±x_i) + Σ δ_m x^m that are constant along x' = F(x), polynomial: x_i' = x_i K_i for the states with logarithms,
/// and Σ λ_i K_i + Σ δ_m (x^m)' = 0 (Darboux 1878). `signs` are those of the states near the point; states without one may vanish.
pub(crate) fn logarithmic_integrals(
    pool: &mut Pool,
    states: &[Symbol],
    signs: &[Option<bool>],
    field: &[MultivariatePolynomial],
) -> Vec<Expr> {
    let n = states.len();
    if n > MAX_STATES {
        return Vec::new();
    }
    let mut functions: Vec<Expr> = Vec::new();
    let mut rates: Vec<MultivariatePolynomial> = Vec::new();
    for i in 0..n {
        let Some(positive) = signs[i].filter(|_| field[i].terms().all(|(m, _)| m[i] > 0)) else { continue };
        let mut cofactor = MultivariatePolynomial::default();
        for (m, c) in field[i].terms() {
            let mut m = m.clone();
            m[i] -= 1;
            cofactor.add_term(m, c.clone());
        }
        let x = pool.sym(states[i]);
        let x = if positive { x } else { pool.neg(x) };
        functions.push(pool.call(Func::Log, x));
        rates.push(cofactor);
    }
    if functions.is_empty() {
        return Vec::new();
    }
    for m in monomials(n) {
        let p = MultivariatePolynomial::term(Rational::ONE, m.clone());
        rates.push((0..n).fold(MultivariatePolynomial::default(), |sum, i| {
            sum.plus(&p.derivative(i).product(&field[i]), &Rational::ONE)
        }));
        let mut product = pool.int(1);
        for (&s, &k) in states.iter().zip(&m) {
            let x = pool.sym(s);
            let power = pool.powi(x, i64::from(k));
            product = pool.mul(product, power);
        }
        functions.push(product);
    }
    let mut seen: Vec<&Vec<u32>> = rates.iter().flat_map(MultivariatePolynomial::terms).map(|t| t.0).collect();
    seen.sort();
    seen.dedup();
    let rows = seen.into_iter().map(|m| rates.iter().map(|r| r.coefficient(m)).collect()).collect();
    let combined = |c: Vec<Rational>| {
        let mut sum = pool.int(0);
        for (&f, c) in functions.iter().zip(c) {
            let c = pool.rational(c);
            let term = pool.mul(c, f);
            sum = pool.add(sum, term);
        }
        sum
    };
    RationalMatrix::new(rows, functions.len()).null_space().into_iter().map(combined).collect()
}

/// Exponents of degree 1 to [`DEGREE`].
fn monomials(n: usize) -> Vec<Vec<u32>> {
    let mut all = vec![vec![0; n]];
    for _ in 0..DEGREE {
        let more = all.iter().flat_map(|m| {
            (0..n).map(|i| {
                let mut m = m.clone();
                m[i] += 1;
                m
            })
        });
        all = all.iter().cloned().chain(more).collect();
        all.sort();
        all.dedup();
    }
    all.retain(|m| m.iter().any(|k| *k > 0));
    all
}
