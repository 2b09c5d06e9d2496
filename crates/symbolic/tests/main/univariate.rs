//! Polynomials in one variable: greatest common divisors and real roots.

use bracketry_symbolic::{Rational, UnivariatePolynomial};

fn polynomial(c: &[i64]) -> UnivariatePolynomial {
    UnivariatePolynomial::new(c.iter().map(|&k| Rational::from(k)).collect())
}

#[test]
fn roots_are_all_found_and_rational_ones_exactly() {
    // (x − 2)²(3x + 1)(x² − 2)(x² + 1)
    let factors = [&[-2, 1][..], &[-2, 1], &[1, 3], &[-2, 0, 1], &[1, 0, 1]];
    let p = factors.iter().map(|c| polynomial(c)).reduce(|a, b| a.mul(&b)).unwrap_or_else(|| polynomial(&[]));
    let roots = p.roots();
    let values: Vec<f64> = roots.iter().map(|r| r.value).collect();
    let sqrt2 = std::f64::consts::SQRT_2;
    for (found, expected) in values.iter().zip([-sqrt2, -1.0 / 3.0, sqrt2, 2.0]) {
        assert!((found - expected).abs() < 1e-15, "{values:?}");
    }
    assert_eq!(values.len(), 4);
    let exact: Vec<bool> = roots.iter().map(|r| r.exact.is_some()).collect();
    assert_eq!(exact, [false, true, false, true]);
    assert_eq!(roots[1].exact, Some(Rational::from(-1) / Rational::from(3)));
}

#[test]
fn the_greatest_common_divisor_divides_both() {
    let (a, b) = (polynomial(&[-6, 1, 1]), polynomial(&[3, 4, 1]));
    assert_eq!(a.gcd(&b), polynomial(&[3, 1]));
    assert_eq!(polynomial(&[1, 0, 1]).gcd(&polynomial(&[1, 1])), polynomial(&[1]));
}

/// Products of factors with known roots, some of them at dyadic numbers, some close together: values, order, and intervals apart.
#[test]
fn roots_of_products_are_isolated() {
    let mut state = 1u64;
    let mut random = |n: i64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as i64 % n
    };
    for case in 0..60 {
        let mut p = polynomial(&[1 + random(3)]);
        let mut expected: Vec<f64> = Vec::new();
        for _ in 0..=random(6) {
            let (a, b) = (random(41) - 20, 1 + random(16));
            let (factor, roots) = match random(4) {
                0 => (polynomial(&[-a, b]), vec![a as f64 / b as f64]),
                // b² x² = 2 a²: irrational unless a = 0.
                1 => (
                    polynomial(&[-2 * a * a, 0, b * b]),
                    [-1.0, 1.0].map(|s| s * 2f64.sqrt() * a as f64 / b as f64).to_vec(),
                ),
                2 => (polynomial(&[-a * 1_000_001, b * 1_000_000]), vec![a as f64 / b as f64 * 1.000_001]),
                _ => (polynomial(&[a * a + 1, 2 * a, 1]), Vec::new()),
            };
            p = p.mul(&factor);
            expected.extend(roots);
        }
        expected.sort_by(f64::total_cmp);
        expected.dedup_by(|a, b| (*a - *b).abs() <= 1e-13 * b.abs());
        let roots = p.roots();
        let values: Vec<f64> = roots.iter().map(|r| r.value).collect();
        assert_eq!(values.len(), expected.len(), "{case}: {values:?} {expected:?}");
        for (r, e) in roots.iter().zip(&expected) {
            assert!((r.value - e).abs() <= 1e-13 * e.abs(), "{case}: {values:?} {expected:?}");
            assert!(r.exact.is_none() || p.at(r.exact.as_ref().unwrap_or(&Rational::ZERO)) == Rational::ZERO);
            assert!(p.has_root_between(&r.between) && r.between[0] <= r.between[1], "{case}");
        }
        for pair in roots.windows(2) {
            let apart = [pair[0].between[1].clone(), pair[1].between[0].clone()];
            assert!(apart[0] < apart[1] && !p.has_root_between(&apart), "{case}: {apart:?}");
        }
    }
}

#[test]
fn constants_have_no_roots() {
    assert!(polynomial(&[5]).roots().is_empty());
    assert!(polynomial(&[]).roots().is_empty());
    assert!(polynomial(&[1, 0, 1]).roots().is_empty());
    assert_eq!(polynomial(&[0, 2]).roots()[0].exact, Some(Rational::ZERO));
}
