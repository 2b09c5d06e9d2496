//! Exact arithmetic with irrational constants.

use std::cmp::Ordering;

use bracketry_symbolic::{Bindings, FieldElement, OrderedField, Pool, Real, UnivariatePolynomial};
use proptest::prelude::*;

const CONSTANTS: [&str; 8] = ["sqrt(2)", "sqrt(3)", "sqrt(6)", "exp(1/3)", "pi", "sin(1)", "cos(1)", "2/7"];

fn reals(pool: &mut Pool, list: &[&str]) -> Vec<Real> {
    let list: Vec<_> = list.iter().map(|e| pool.parse(e).unwrap()).collect();
    pool.reals(&list).unwrap().0
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Sums, products, and quotients have the signs of the expressions for them.
    #[test]
    fn results_have_the_signs_of_their_expressions(steps in prop::collection::vec((0usize..4, 0usize..64, 0usize..64), 1..12)) {
        let mut pool = Pool::new();
        let mut list = reals(&mut pool, &CONSTANTS);
        for (operation, i, j) in steps {
            let (a, b) = (list[i % list.len()].clone(), list[j % list.len()].clone());
            let result = match operation {
                0 => &a + &b,
                1 => &a - &b,
                2 => &a * &b,
                _ if b.is_zero() => continue,
                _ => &a / &b,
            };
            if let Some(e) = result.expression(&mut pool) {
                let expected = pool.constant_sign(e, &Bindings::new());
                prop_assert_eq!(result.sign(), expected, "{}", pool.text(e));
                prop_assert_eq!(result.is_zero(), expected == Some(Ordering::Equal));
            }
            list.push(result);
        }
    }
}

#[test]
fn what_cancels_is_zero() {
    let mut pool = Pool::new();
    let x = reals(&mut pool, &CONSTANTS);
    assert!((&x[0] * &x[1] - &x[2]).is_zero());
    assert!((&x[5] * &x[5] + &x[6] * &x[6] - Real::ONE).is_zero());
    // (√2 + √3)² = 5 + 2 √6
    let sum = &x[0] + &x[1];
    assert_eq!(&sum * &sum, Real::from(5) + Real::from(2) * &x[2]);
    assert!((&x[3] - &x[4]).is_negative());
}

/// The residues of e^(1/3) in two computations are different.
#[test]
fn numbers_of_different_computations_are_not_compared() {
    let mut pool = Pool::new();
    let a = reals(&mut pool, &["exp(1/3)", "pi"]);
    let b = reals(&mut pool, &["pi", "exp(1/3)"]);
    let difference = &a[0] - &b[1];
    assert!(!difference.is_zero() && difference.sign().is_none());
    assert!((&a[0] / (&a[1] - &b[0])).sign().is_none());
    assert!((&a[0] / Real::ZERO).sign().is_none());
}

#[test]
fn polynomials_have_common_factors() {
    let mut pool = Pool::new();
    let x = reals(&mut pool, &["sqrt(2)", "sqrt(3)", "pi"]);
    let factor = |root: &Real| UnivariatePolynomial::new(vec![-root, Real::ONE]);
    let p = factor(&x[0]).mul(&factor(&x[1]));
    let q = factor(&x[2]).mul(&factor(&x[0])).scaled(&x[1]);
    assert_eq!(p.gcd(&q), factor(&x[0]));
    assert_eq!(p.quotient(&factor(&x[1])), factor(&x[0]));
    assert_eq!(p.gcd(&factor(&x[2])).degree(), 0);
    // Sturm: sign changes at −∞ less those at ∞.
    let chain = UnivariatePolynomial::signed_remainders(&p, &p.derivative());
    let signs: Vec<_> = chain.iter().map(|f| f.leading().sign().unwrap()).collect();
    assert_eq!(signs, [Ordering::Greater; 3]);
}

/// Formulas of long computations are dropped, signs stay.
#[test]
fn long_computations_keep_their_signs() {
    let mut pool = Pool::new();
    let x = reals(&mut pool, &["sqrt(2)", "pi"]);
    let mut sum = x[0].clone();
    for k in 1..400 {
        sum += &x[1] / Real::from(k);
    }
    assert!(sum.expression(&mut pool).is_none() && sum.is_positive());
    assert!((&sum - Real::from(23)).is_negative() && (sum - Real::from(22)).is_positive());
}
