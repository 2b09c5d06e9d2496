//! Coefficients that are multiples of the primes of the exact tests, or differ from a small number by one.

use crate::common::{cases, generator, test};
use bracketry_symbolic::{Bindings, Expr, Pool, Residue, SECOND_OFFSET, THIRD_OFFSET, Undecided, ZeroTest};
use proptest::prelude::*;
use rand::RngExt;

const PRIMES: [u64; 3] = [Residue::<1>::MODULUS, Residue::<SECOND_OFFSET>::MODULUS, Residue::<THIRD_OFFSET>::MODULUS];

/// Numbers that the field of this prime mistakes for a simpler one, or has no value for.
fn mistaken_by(p: u64) -> Vec<String> {
    let forms = ["@", "@/2", "2*@/3", "1/@", "@ + 1", "5 - @", "@^2", "-7*@/11 + 3/4"];
    forms.iter().map(|f| format!("({})", f.replace('@', &p.to_string()))).collect()
}

/// All of these, and numbers that two fields mistake.
fn mistaken() -> Vec<String> {
    let mut list: Vec<String> = PRIMES.iter().flat_map(|&p| mistaken_by(p)).collect();
    list.push(format!("({}*{})", PRIMES[0], PRIMES[1]));
    list.push(format!("({}/{})", PRIMES[1], PRIMES[0]));
    list
}

#[test]
fn no_coefficient_is_taken_for_another_number() {
    for c in mistaken() {
        for nonzero in [
            format!("{c}*x"),
            format!("{c}*x*y - x*y"),
            format!("({c} - 1)*(x^2 - y^2) + (x - y)*(x + y)"),
            format!("1/({c}*x) - 1/(3*{c}*x)"),
            format!("sqrt(3)*{c}*x"),
            format!("{c}*sin(x)^2 + {c}*cos(x)^2 - 1"),
        ] {
            assert_eq!(test(&nonzero), ZeroTest::NonZero, "{nonzero}");
        }
        for zero in [
            format!("{c}*(x^2 - y^2) - {c}*(x - y)*(x + y)"),
            format!("x/({c}*x) - 1/{c}"),
            format!("{c}*sin(x)^2 + {c}*cos(x)^2 - {c}"),
        ] {
            assert!(test(&zero).is_zero(), "{zero}: {:?}", test(&zero));
        }
        // An angle may be too large a multiple of another one, but it is never mistaken.
        let angle = format!("sin({c}*x) - sin(3*{c}*x)");
        assert!(!test(&angle).is_zero(), "{angle}");
    }
}

#[test]
fn a_denominator_that_vanishes_modulo_one_prime_is_none_that_vanishes() {
    for p in PRIMES {
        let e = format!("1/(({p} - 1)*(x + y)*(x - y) + x^2 - y^2)");
        assert_eq!(test(&e), ZeroTest::NonZero, "{e}");
    }
    assert_eq!(test("1/((x + y)^2 - x^2 - 2*x*y - y^2)"), ZeroTest::Unknown(Undecided::DivisionByZero));
}

proptest! {
    #![proptest_config(cases(60))]

    /// A·D·B for unimodular A and B and a diagonal D has as many independent rows as D has entries, wherever they
    /// lie; functions as factors of rows and sums that were not collected do not change that.
    #[test]
    fn ranks_of_products_are_known(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let (m, n) = (rng.random_range(1..5_usize), rng.random_range(1..5_usize));
        let r = rng.random_range(0..=m.min(n));
        let numbers = mistaken_by(PRIMES[rng.random_range(0..3)]);
        let mut p = Pool::new();
        let zero = p.int(0);
        let mut rows: Vec<Vec<Expr>> = vec![vec![zero; n]; m];
        for (i, row) in rows.iter_mut().enumerate().take(r) {
            row[i] = p.parse(&numbers[rng.random_range(0..numbers.len())]).unwrap();
        }
        for _ in 0..6 {
            let (i, j, c) = (rng.random_range(0..m), rng.random_range(0..m), rng.random_range(-2..3));
            let c = p.int(c);
            for k in 0..n {
                let term = p.mul(c, rows[j][k]);
                rows[i][k] = if i == j { rows[i][k] } else { p.add(rows[i][k], term) };
            }
            let (i, j) = (rng.random_range(0..n), rng.random_range(0..n));
            for row in &mut rows {
                let term = p.mul(c, row[j]);
                row[i] = if i == j { row[i] } else { p.add(row[i], term) };
            }
        }
        let factors = ["x + y", "1", "1/(x*y)", "cos(x)"].map(|t| p.parse(t).unwrap());
        let (minus, whole) = (p.int(-1), p.parse("(x - y)*(x + y)").unwrap());
        let parts = p.parse("x^2 - y^2").unwrap();
        for (i, row) in rows.iter_mut().enumerate() {
            for e in row.iter_mut() {
                // (c − 1)(x² − y²) + (x − y)(x + y)
                let less = p.add(*e, minus);
                let first = p.mul(less, parts);
                let sum = p.add(first, whole);
                *e = p.mul(sum, factors[i % factors.len()]);
            }
        }
        let found = p.rank(&rows, &Bindings::new()).unwrap();
        prop_assert_eq!(found.rank, r);
        for k in 0..=m {
            let first = p.rank(&rows[..k], &Bindings::new()).unwrap();
            let expected: Vec<usize> = found.independent.iter().copied().filter(|&i| i < k).collect();
            prop_assert_eq!(first.independent, expected);
        }
    }
}

#[test]
fn values_at_a_point_hold_known_angles() {
    let mut p = Pool::new();
    let (e, x) = (p.parse("sin(atan(1) + x)*asin(1/2)").unwrap(), p.symbol("x"));
    let mut at = Bindings::new();
    at.bind(x, 0.into());
    let known = p.parse("sqrt(2)/2*pi/6").unwrap();
    let samples = p.sample_in::<SECOND_OFFSET>(&[e, known], &at, 1, 7).unwrap();
    assert_eq!(samples.values[0][0], samples.values[0][1]);
}
