//! Relations that exact tests find among arguments: combinations of exponents and angles, powers in products.

use crate::common::{generator, test};
use rand::RngExt;
use rand::seq::SliceRandom;

/// Functions of which no one is a combination of the others with constant coefficients, nor with π.
const INDEPENDENT: [&str; 9] = ["x*y", "y^2", "x/(1 + y)", "x^3", "1/(x + z)", "z", "x*z^2", "y/(x + 2)", "x^2*y*z"];

#[test]
fn combinations_have_the_coefficients_they_were_made_with() {
    let rng = &mut generator(5);
    for case in 0..40 {
        let n = 1 + case % 7;
        let mut list = INDEPENDENT;
        list.shuffle(rng);
        let (vectors, other) = (&list[..n], list[n]);
        let sum = |c: &dyn Fn(usize) -> i64| {
            (0..n).map(|k| format!("({})*({})", c(k), vectors[k])).collect::<Vec<_>>().join(" + ")
        };
        let product = |c: &dyn Fn(usize) -> i64| {
            (0..n).map(|k| format!("exp({})^({})", vectors[k], c(k))).collect::<Vec<_>>().join("*")
        };
        let made = |k: usize| k as i64 * 3 - 4;
        // One coefficient is another one.
        let (place, by) = (rng.random_range(0..n), if rng.random_range(0..2) == 0 { 1 } else { -2 });
        let wrong = |k: usize| made(k) + if k == place { by } else { 0 };
        let zero = format!("exp({}) - {}", sum(&made), product(&made));
        assert!(test(&zero).is_zero(), "{zero}: {:?}", test(&zero));
        for nonzero in [
            format!("exp({}) - {}", sum(&made), product(&wrong)),
            format!("exp({} + {other}) - {}", sum(&made), product(&made)),
            format!("exp({other}) - {}", product(&made)),
        ] {
            assert!(test(&nonzero).is_nonzero(), "{nonzero}: {:?}", test(&nonzero));
        }
        // The same of angles, of which a sine is that of the combination.
        let zero = format!("sin({0} + pi/4) - (sin({0}) + cos({0}))/sqrt(2)", sum(&made));
        assert!(test(&zero).is_zero(), "{zero}: {:?}", test(&zero));
    }
}

/// The exponents of a product are found, and what is no product of powers is independent.
#[test]
fn powers_of_a_product_are_found() {
    let log = |n: u32, m: u32| format!("log((x^2 - y^2)^{n}*(x - y)^{})", m - n);
    assert!(test(&format!("{} - 2*log(x + y) - 6*log(x - y)", log(2, 6))).is_zero());
    assert!(test(&format!("{} - 2*log(x + y) - 5*log(x - y)", log(2, 6))).is_nonzero());
    assert!(test("log(x + y) - log(x - y) - log(x + 2*y)").is_nonzero());
}

/// The prime factors of n with their multiplicities.
fn factors(mut n: i64) -> Vec<(i64, i64)> {
    let mut list: Vec<(i64, i64)> = Vec::new();
    let mut p = 2;
    while n > 1 {
        if n % p != 0 {
            p += 1;
            continue;
        }
        n /= p;
        match list.last_mut() {
            Some(last) if last.0 == p => last.1 += 1,
            _ => list.push((p, 1)),
        }
    }
    list
}

/// x + i y is a product of Gaussian primes c + i d, their conjugates, a power of 1 + i, and a number: its angle is the sum of theirs.
#[test]
fn angles_are_the_sums_of_those_of_their_primes() {
    for (x, y) in [(1_i64, 1_i64), (3, 4), (-7, 24), (5, -3), (-11, -60), (13, 3), (0, 2), (-3, 0), (1, 239), (99, 70)]
    {
        let common = (1..=x.abs().max(y.abs())).rev().find(|g| x % g == 0 && y % g == 0).unwrap();
        let (a, b) = (x / common, y / common);
        let (mut sum, mut terms) = (0.0, vec![format!("atan2({y}, {x})")]);
        for (p, k) in factors(a * a + b * b).into_iter().filter(|f| f.0 != 2) {
            let (c, d) = (1..p).flat_map(|c| (1..c).map(move |d| (c, d))).find(|(c, d)| c * c + d * d == p).unwrap();
            // Of a prime and its conjugate, one divides.
            let divides = (a * c + b * d) % p == 0 && (b * c - a * d) % p == 0;
            let k = if divides { k } else { -k };
            sum += k as f64 * (d as f64).atan2(c as f64);
            terms.push(format!("({k})*atan2({d}, {c})"));
        }
        let angle = (y as f64).atan2(x as f64);
        let eighths = ((angle - sum) / std::f64::consts::FRAC_PI_4).round();
        assert!((sum + eighths * std::f64::consts::FRAC_PI_4 - angle).abs() < 1e-12, "{x} {y}");
        let difference = |eighths: f64| format!("{} - ({eighths})*pi/4", terms.join(" - "));
        assert!(test(&difference(eighths)).is_zero(), "{}", difference(eighths));
        assert!(test(&difference(eighths + 1.0)).is_nonzero(), "{}", difference(eighths + 1.0));
        assert!(test(&format!("{} - atan2(1, 4)", difference(eighths))).is_nonzero(), "{x} {y}");
    }
}
