//! The sign that a polynomial keeps near the origin.

use bracketry_symbolic::{FieldElement, OrderedField, Rational, Real};

use crate::linear::matrix::semidefinite;
use crate::linear::polynomial::{RealPolynomial, unit};
use crate::linear::program::{Optimum, Program};

/// Most terms of a polynomial, and most even ones among them with the sign in question.
const MAX_TERMS: usize = 60;
const MAX_EVEN: usize = 16;
/// Most completions of the square of one variable.
const MAX_COMPLETIONS: usize = 3;
/// The part of the even terms that is left for those that are small beside them.
const SPARE: (i64, i64) = (1, 64);

impl RealPolynomial {
    /// Whether the polynomial, and whatever vanishes to a higher degree than `remainder` is added to it, is seen not to be negative
    /// near the origin.
    ///
    /// The even monomials z^e with positive coefficients bear the others: z^m with m ≥ Σ λ_e e, λ_e ≥ 0, Σ λ_e = 1, is at most
    /// Σ λ_e |z^e| |z|^(m − Σ λ_e e) in size (weighted means), which is small beside the sum of the |z^e| where the last power is not
    /// zero. Where it is zero, z^m is a product of two of the roots z^(e/2), and the quadratic form in these must be semidefinite.
    ///
    /// Before, even powers of variables that are common factors are left out, and squares of variables are completed.
    pub(crate) fn is_nonnegative_near_origin(&self, remainder: Option<u32>) -> bool {
        if self.is_zero() {
            return remainder.is_none();
        }
        let reduced = if remainder.is_none() { self.without_even_factors() } else { self.clone() };
        if reduced.is_borne(remainder) {
            return true;
        }
        let completed = reduced.with_squares_completed();
        completed != reduced && completed.is_borne(remainder)
    }

    /// The quotient by the even powers of variables that divide all terms.
    fn without_even_factors(&self) -> Self {
        let Some(mut common) = self.terms().next().map(|t| t.0.clone()) else { return self.clone() };
        for (m, _) in self.terms() {
            for (least, k) in common.iter_mut().zip(m) {
                *least = (*least).min(*k);
            }
        }
        let mut quotient = Self::default();
        for (m, c) in self.terms() {
            quotient.add_term(m.iter().zip(&common).map(|(k, least)| k - least / 2 * 2).collect(), c.clone());
        }
        quotient
    }

    /// In coordinates z_i + q/(2 a) for z_i where a z_i² + q z_i are the terms of low degree in z_i, which a polynomial q in the others
    /// keeps from being borne.
    fn with_squares_completed(&self) -> Self {
        let mut p = self.clone();
        let n = p.terms().next().map_or(0, |t| t.0.len());
        for i in 0..n {
            for _ in 0..MAX_COMPLETIONS {
                let square = p.coefficient(&(0..n).map(|j| if i == j { 2 } else { 0 }).collect::<Vec<_>>());
                // A linear term would move the origin.
                let linear = !p.coefficient(&unit(n, i)).is_zero();
                if linear || !square.is_positive() || !p.terms().any(|(m, _)| m[i] == 1) {
                    break;
                }
                let twice = Real::from(2) * square;
                let mut shifted = Self::term(Real::ONE, unit(n, i));
                for (m, c) in p.terms().filter(|(m, _)| m[i] == 1) {
                    let rest = m.iter().enumerate().map(|(j, k)| if i == j { 0 } else { *k }).collect();
                    shifted.add_term(rest, -c / &twice);
                }
                match p.with(i, &shifted) {
                    Some(moved) => p = moved,
                    None => return p,
                }
            }
        }
        p
    }

    /// The same for the polynomial as it stands.
    fn is_borne(&self, remainder: Option<u32>) -> bool {
        let bears = |(m, c): &(&Vec<u32>, &Real)| m.iter().all(|k| k % 2 == 0) && c.is_positive();
        let (even, others): (Vec<_>, Vec<_>) = self.terms().partition(bears);
        // Multiples of others bear nothing that those do not.
        let divides = |a: &[u32], b: &[u32]| a != b && a.iter().zip(b).all(|(a, b)| a <= b);
        let even: Vec<_> = even.iter().filter(|(m, _)| !even.iter().any(|(a, _)| divides(a, m))).copied().collect();
        if even.len() > MAX_EVEN || others.len() > MAX_TERMS || even.is_empty() {
            return false;
        }
        let bearing: Vec<&Vec<u32>> = even.iter().map(|t| t.0).collect();
        let variables = bearing[0].len();
        // What is left out is at most a multiple of the sum of these powers.
        let powers = |degree: u32| {
            (0..variables).map(move |i| (0..variables).map(|j| if i == j { degree + 1 } else { 0 }).collect())
        };
        if let Some(degree) = remainder
            && !powers(degree).all(|m: Vec<u32>| borne(&m, &bearing) == Some(true))
        {
            return false;
        }
        let (mut tight, mut small) = (Vec::new(), remainder.is_some());
        for (m, c) in others {
            match borne(m, &bearing) {
                Some(true) => small = true,
                Some(false) => tight.push((m, c)),
                None => return false,
            }
        }
        if tight.is_empty() {
            return true;
        }
        let spare = if small { Rational::from(SPARE.0) / Rational::from(SPARE.1) } else { Rational::ZERO };
        let kept = Real::from(Rational::ONE - spare);
        let mut form = vec![vec![Real::ZERO; even.len()]; even.len()];
        for (i, (_, c)) in even.iter().enumerate() {
            form[i][i] = *c * &kept;
        }
        for (m, c) in tight {
            let twice = |i: usize, j: usize| m.iter().zip(bearing[i]).zip(bearing[j]).all(|((m, a), b)| 2 * m == a + b);
            let Some((i, j)) = (0..even.len()).flat_map(|i| (0..=i).map(move |j| (i, j))).find(|&(i, j)| twice(i, j))
            else {
                return false;
            };
            let half = c / Real::from(2);
            form[i][j] += &half;
            form[j][i] += &half;
        }
        semidefinite(form) == Some(true)
    }
}

/// Whether z^m is small beside Σ |z^e| near the origin (true), at most that sum (false), or not seen to be either.
fn borne(m: &[u32], bearing: &[&Vec<u32>]) -> Option<bool> {
    let (k, n) = (bearing.len(), m.len());
    let unit = |x: bool| if x { Rational::ONE } else { Rational::ZERO };
    let mut equations = vec![((0..k + n).map(|j| unit(j < k)).collect::<Vec<_>>(), Rational::ONE)];
    for (i, &power) in m.iter().enumerate() {
        let row = bearing.iter().map(|e| Rational::from(e[i])).chain((0..n).map(|j| unit(i == j)));
        equations.push((row.collect(), Rational::from(power)));
    }
    let program = Program { equations, bounds: vec![(Some(Rational::ZERO), None); k + n] };
    let rest: Vec<Rational> = (0..k + n).map(|j| unit(j >= k)).collect();
    match program.maximize(&rest)? {
        Optimum::Found(x) => Some(x[k..].iter().any(|r| *r > Rational::ZERO)),
        Optimum::Infeasible(_) | Optimum::Unbounded => None,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn polynomial(terms: &[(i64, [u32; 2])]) -> RealPolynomial {
        let mut p = RealPolynomial::default();
        for (c, m) in terms {
            p.add_term(m.to_vec(), Real::from(*c));
        }
        p
    }

    #[test]
    fn higher_powers_are_borne_only_where_they_are_small() {
        let holds = |terms: &[(i64, [u32; 2])]| polynomial(terms).is_nonnegative_near_origin(None);
        assert!(holds(&[(1, [2, 0]), (1, [0, 6]), (-5, [1, 4]), (7, [3, 0])]));
        assert!(holds(&[(1, [2, 2]), (-3, [3, 2])]));
        // (x + y²)² + y⁶, with a factor y², and (x + y²)² − y⁶.
        assert!(holds(&[(1, [2, 0]), (2, [1, 2]), (1, [0, 4]), (1, [0, 6]), (-3, [0, 7])]));
        assert!(holds(&[(1, [2, 2]), (2, [1, 4]), (1, [0, 6]), (1, [0, 8]), (-3, [0, 9])]));
        assert!(!holds(&[(1, [2, 0]), (2, [1, 2]), (1, [0, 4]), (-1, [0, 6])]));
        assert!(!holds(&[(1, [2, 2]), (-3, [5, 0])]));
        assert!(holds(&[(1, [4, 0]), (1, [0, 4]), (-1, [2, 2])]));
        assert!(!holds(&[(1, [4, 0]), (1, [0, 4]), (-3, [2, 2])]));
        assert!(!holds(&[(1, [2, 0]), (1, [1, 2])]));
        let square = polynomial(&[(1, [2, 0]), (1, [0, 2])]);
        assert!(square.is_nonnegative_near_origin(Some(2)));
        assert!(!polynomial(&[(1, [2, 2])]).is_nonnegative_near_origin(Some(4)));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// Where a polynomial is said not to be negative, no point near the origin contradicts.
        #[test]
        fn no_point_contradicts(terms in prop::collection::vec((-4i64..5, 0u32..5, 0u32..5), 1..6)) {
            let terms: Vec<(i64, [u32; 2])> = terms.into_iter().map(|(c, i, j)| (c, [i, j])).collect();
            let p = polynomial(&terms);
            if p.is_nonnegative_near_origin(None) {
                let small = |k: i64, power: u32| {
                    (0..power).fold(Rational::from(k) / Rational::from(2), |p, _| p / Rational::from(10_000))
                };
                // Along x = ± k t^i, y = ± l t^j.
                for code in 0..4i64 * 4 * 5 * 5 {
                    let (i, j, k, l) = (code % 4, code / 4 % 4, code / 16 % 5 - 2, code / 80 % 5 - 2);
                    let (x, y) = (small(k, i as u32 + 1), small(l, j as u32 + 1));
                    let value = p.terms().fold(Rational::ZERO, |s, (m, c)| {
                        let power = |x: &Rational, k: u32| (0..k).fold(Rational::ONE, |p, _| p * x);
                        s + c.rational().unwrap() * power(&x, m[0]) * power(&y, m[1])
                    });
                    prop_assert!(value >= Rational::ZERO, "{terms:?} at {x}, {y}");
                }
            }
        }

        /// A sum of squares, less its value at the origin, is negative on one side of the origin if it has linear terms.
        #[test]
        fn linear_terms_have_both_signs(entries in prop::collection::vec(-2i64..3, 30)) {
            let variables: Vec<Vec<u32>> = (0..3).map(|i| unit(3, i)).collect();
            let squares: Vec<Vec<u32>> = variables.iter().map(|m| m.iter().map(|k| 2 * k).collect()).collect();
            let monomials: Vec<Vec<u32>> = [vec![vec![0; 3]], variables.clone(), squares].concat();
            let mut sum = RealPolynomial::default();
            for c in entries.chunks_exact(monomials.len()) {
                let mut p = RealPolynomial::default();
                c.iter().zip(&monomials).for_each(|(&c, m)| p.add_term(m.clone(), Real::from(c)));
                sum = sum.plus(&p.times_up_to(&p, 4), &Real::ONE);
            }
            let at_origin = sum.coefficient(&[0, 0, 0]);
            sum.add_term(vec![0; 3], -at_origin);
            let linear = variables.iter().any(|m| !sum.coefficient(m).is_zero());
            prop_assert!(!(linear && sum.is_nonnegative_near_origin(None)));
        }
    }
}
