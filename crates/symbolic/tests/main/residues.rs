//! The fields of exact tests, echelon forms over them, and the angles that they hold.

use crate::common::generator;
use bracketry_symbolic::{
    Bindings, Echelon, Evaluation, FieldElement, Fp, Pool, Rational, Residue, SECOND_OFFSET, THIRD_OFFSET,
};
use rand::RngExt;
use rand::rngs::StdRng;

/// A residue other than 0.
fn residue<const C: u64>(rng: &mut StdRng) -> Residue<C> {
    Residue::new(rng.random_range(1..Residue::<C>::MODULUS))
}

fn field_laws<const C: u64>() {
    let rng = &mut generator(7);
    for _ in 0..200 {
        let (a, b, c): (Residue<C>, Residue<C>, Residue<C>) = (residue(rng), residue(rng), residue(rng));
        assert_eq!(a * (b + c), a * b + a * c);
        assert_eq!(a * a.inv().unwrap(), Residue::ONE);
        assert_eq!(a.pow(Residue::<C>::MODULUS - 1), Residue::ONE);
        let product = u128::from(a.value()) * u128::from(b.value()) % u128::from(Residue::<C>::MODULUS);
        assert_eq!(u128::from((a * b).value()), product);
        let root = (a * a).sqrt().unwrap();
        assert!((root == a || root == -a) && root.is_residue());
        assert!(a.is_residue() != (-a).is_residue());
    }
}

#[test]
fn all_primes_give_fields_in_which_minus_one_is_no_square() {
    field_laws::<1>();
    field_laws::<SECOND_OFFSET>();
    field_laws::<THIRD_OFFSET>();
}

#[test]
fn the_other_primes_have_the_roots_they_were_chosen_for() {
    has_small_roots::<SECOND_OFFSET>(167);
    has_small_roots::<THIRD_OFFSET>(53);
}

fn has_small_roots<const C: u64>(last: u64) {
    let is_prime = |n: u64| (2..n).all(|d| !n.is_multiple_of(d));
    for n in (2..=last).filter(|&n| is_prime(n)) {
        assert!(Residue::<C>::new(n).is_residue(), "{n}");
    }
    for q in [3, 5, 7, 11, 13] {
        assert_ne!((Residue::<C>::MODULUS - 1) % q, 0, "{q}");
    }
}

#[test]
fn square_roots_of_the_acceleration_of_gravity_exist() {
    for g in [(981, 100), (98, 10), (10, 1)] {
        let g = Rational::from(g.0) / Rational::from(g.1);
        assert!(Residue::<SECOND_OFFSET>::from_rational(&g).unwrap().is_residue(), "{g}");
    }
    let standard = Rational::from(980_665) / Rational::from(100_000);
    assert!(Residue::<SECOND_OFFSET>::from_rational(&standard).unwrap().is_residue());
    assert!(Residue::<THIRD_OFFSET>::from_rational(&standard).unwrap().is_residue());
}

/// The value of a number in a field; none where the field has no value for it or mistakes it for another one.
fn value<const C: u64>(r: &Rational) -> Option<Residue<C>> {
    let mut pool = Pool::new();
    let e = pool.rational(r.clone());
    let found = pool.evaluate(&mut Evaluation::<C>::new(Bindings::new()), &[e]);
    found.map_err(|why| assert!(why.needs_other_prime(), "{r}: {why}")).ok().map(|samples| samples.values[0][0])
}

#[test]
fn numbers_that_a_field_mistakes_are_refused() {
    let p = Rational::from(Fp::MODULUS);
    let (one, two) = (Rational::ONE, Rational::from(2));
    let mistaken = [p.clone(), &p / &two, &one / &p, &p + &one, &p * &two / Rational::from(3) - &one, &p * &p];
    for r in &mistaken {
        assert_eq!(value::<1>(r), None, "{r}");
        assert!(value::<SECOND_OFFSET>(r).is_some(), "{r}");
    }
    for r in [Rational::ZERO, one / two, Rational::from(3).pow(37), Rational::from(981) / Rational::from(100)] {
        assert_eq!(value::<1>(&r), Fp::from_rational(&r), "{r}");
    }
}

#[test]
fn fractions_are_reconstructed() {
    for (n, d) in [(0, 1), (1, 1), (-3, 7), (981, 100), (1_000_003, 999_983), (-1, 1 << 20)] {
        let r = Fp::from_i64(n) * Fp::from_i64(d).inv().unwrap();
        assert_eq!(r.to_fraction(1 << 20), Some((n, d)));
        assert_eq!(Fp::from_rational(&r.to_rational(1 << 20).unwrap()), Some(r));
    }
    assert_eq!(Fp::new(2).sqrt().unwrap().to_fraction(1 << 20), None);
}

fn product(a: &[Vec<Fp>], b: &[Vec<Fp>]) -> Vec<Vec<Fp>> {
    let columns = b.first().map_or(0, Vec::len);
    a.iter()
        .map(|r| (0..columns).map(|j| r.iter().zip(b).fold(Fp::ZERO, |s, (&x, row)| s + x * row[j])).collect())
        .collect()
}

fn random(rng: &mut StdRng, rows: usize, columns: usize) -> Vec<Vec<Fp>> {
    (0..rows).map(|_| (0..columns).map(|_| residue(rng)).collect()).collect()
}

#[test]
fn rank_of_a_product_is_its_inner_dimension_and_its_nullspace_is_annihilated() {
    let rng = &mut generator(3);
    for (m, k, n) in [(1, 1, 1), (4, 2, 7), (7, 3, 4), (5, 5, 5), (9, 0, 3), (32, 17, 32)] {
        let (a, b) = (random(rng, m, k), random(rng, k, n));
        let ab = if k == 0 { vec![vec![Fp::ZERO; n]; m] } else { product(&a, &b) };
        let e = Echelon::new(&ab, n);
        assert_eq!(e.rank(), k);
        assert_eq!(e.independent, (0..k).collect::<Vec<_>>());
        assert!(ab.iter().all(|r| e.contains(r)));
        // Reducing is a projection, and a row plus what it lacks is in the span.
        let v: Vec<Fp> = (0..n).map(|_| residue(rng)).collect();
        let rest = e.reduce(v.clone());
        assert_eq!(e.reduce(rest.clone()), rest);
        assert!(e.contains(&v.iter().zip(&rest).map(|(&x, &y)| x - y).collect::<Vec<_>>()));
        assert_eq!(e.contains(&v), k == n);
        let kernel = e.null_space();
        assert_eq!(kernel.len(), n - k);
        for v in kernel {
            assert!(ab.iter().all(|r| r.iter().zip(&v).fold(Fp::ZERO, |s, (&x, &y)| s + x * y).is_zero()));
        }
    }
}

/// A class modulo 7.
#[derive(Clone, Debug, PartialEq)]
struct Seventh(u64);

impl FieldElement for Seventh {
    const ZERO: Self = Seventh(0);
    const ONE: Self = Seventh(1);

    fn inverse(&self) -> Option<Self> {
        (1..7).find(|k| self.0 * k % 7 == 1).map(Seventh)
    }

    fn scale(&mut self, factor: &Self) {
        self.0 = self.0 * factor.0 % 7;
    }

    fn subtract_product(&mut self, a: &Self, b: &Self) {
        self.0 = (self.0 + 49 - a.0 * b.0) % 7;
    }
}

/// The echelon form of the columns with the target as the last one holds the coefficients in its last column.
#[test]
fn combinations_modulo_small_primes() {
    let reduced = |columns: &[&[u64]]| {
        let row = |i: usize| columns.iter().map(|c| Seventh(c[i] % 7)).collect::<Vec<_>>();
        Echelon::new(&(0..columns[0].len()).map(row).collect::<Vec<_>>(), columns.len())
    };
    let (a, b): (&[u64], &[u64]) = (&[1, 0, 2, 5], &[0, 1, 3, 1]);
    let found = reduced(&[a, b, &[2, 6, 2 * 2 + 6 * 3, 2 * 5 + 6]]);
    assert_eq!(found.pivots, [0, 1]);
    assert_eq!(found.rows.iter().map(|r| r[2].0).collect::<Vec<_>>(), [2, 6]);
    // A target that is independent has a pivot, a column that is dependent has none.
    assert_eq!(reduced(&[a, b, &[0, 0, 0, 1]]).pivots, [0, 1, 2]);
    assert_eq!(reduced(&[&[0, 0], &[0, 1]]).pivots, [1]);
}

type Point<const C: u64> = (Residue<C>, Residue<C>);

/// The point of k times an angle.
fn turned<const C: u64>(point: Point<C>, k: u64) -> Point<C> {
    let (mut result, mut power, mut k) = ((Residue::ONE, Residue::ZERO), point, k);
    let rotated = |p: Point<C>, q: Point<C>| (p.0 * q.0 - p.1 * q.1, p.1 * q.0 + p.0 * q.1);
    while k > 0 {
        if k & 1 == 1 {
            result = rotated(result, power);
        }
        power = rotated(power, power);
        k >>= 1;
    }
    result
}

/// The point of order 2D divides the circle, which has p + 1 points, and gives the roots that the field chooses; of a half of it,
/// nothing is known.
fn divides_the_circle<const C: u64>(parts: u64) {
    assert_eq!((u128::from(Residue::<C>::MODULUS) + 1) % u128::from(2 * parts), 0);
    let mut pool = Pool::new();
    let mut point = |parts: u64| {
        let list = ["cos", "sin"].map(|f| pool.parse(&format!("{f}(pi/{parts})")).unwrap());
        let samples = pool.sample_in::<C>(&list, &Bindings::new(), 1, 7);
        samples.map(|s| (s.values[0][0], s.values[0][1]))
    };
    let unit = point(parts).unwrap();
    assert_eq!(turned(unit, parts), (-Residue::ONE, Residue::ZERO));
    assert_eq!(unit.0 * unit.0 + unit.1 * unit.1, Residue::ONE);
    let quarter = turned(unit, parts / 4);
    assert_eq!(quarter.1, quarter.0);
    assert_eq!(Some(quarter.0 + quarter.0), Residue::new(2).sqrt());
    assert_eq!(point(4).unwrap(), quarter);
    assert!(point(2 * parts).unwrap_err().needs_other_prime());
}

#[test]
fn all_fields_hold_parts_of_pi() {
    divides_the_circle::<1>(1024);
    divides_the_circle::<SECOND_OFFSET>(1800);
    divides_the_circle::<THIRD_OFFSET>(4320);
}

#[test]
fn values_stay_where_the_pool_renumbers_its_nodes() {
    let mut p = Pool::new();
    let mut first = [p.parse("x + y").unwrap()];
    let before = p.len();
    let mut point = Evaluation::<1>::new(Bindings::new());
    let texts = ["exp(1/3)*cos(1/2)", "sin(1/2) + x", "exp(1/3)*y", "log(2)*exp(2/3)"];
    let mut values = || -> Vec<Residue<1>> {
        let mut list = Vec::new();
        for text in texts {
            let e = p.parse(text).unwrap();
            list.push(p.evaluate(&mut point, &[e]).unwrap().values[0][0]);
            p.collect(before, &mut first);
        }
        list
    };
    assert_eq!(values(), values());
}
