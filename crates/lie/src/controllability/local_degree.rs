//! The local degree of polynomial maps.

use bracketry_symbolic::{FieldElement, Real, UnivariatePolynomial};

use crate::linear::polynomial::RealPolynomial;
use crate::linear::spectrum::variations;

/// Whether the map (as many polynomials as `variables`, all zero at the origin; the other variables are at rest there) is
/// seen to have an isolated zero at the origin with local degree different from zero. Its image then covers a
/// neighborhood of 0 (Brouwer's degree; Deimling 1985, ch. 1).
///
/// By homotopy a component `c v^k + …` of which all terms hold v^k counts as c v^k, and one `c v + p` without v in p
/// is solved for v: up to its sign, the degree is k modulo 2 times that of the others where the component vanishes. What
/// remains has degree 1 without variables, and of two variables the winding number of the forms of least degree.
pub(crate) fn has_local_degree(mut map: Vec<RealPolynomial>, mut variables: Vec<usize>) -> bool {
    loop {
        if map.is_empty() {
            return true;
        }
        if map.iter().any(RealPolynomial::is_zero) {
            return false;
        }
        let pivot = (0..map.len()).find_map(|i| Some((i, pivot(&map[i], &variables)?)));
        let Some((i, (v, value))) = pivot else {
            return match (map.as_slice(), variables.as_slice()) {
                ([p, q], &[x, y]) => winds([&p.leading_form(), &q.leading_form()], [x, y]),
                _ => false,
            };
        };
        let Some(value) = value else { return false };
        map.remove(i);
        variables.retain(|&k| k != v);
        let Some(rest) = map.iter().map(|p| p.with(v, &value)).collect::<Option<Vec<_>>>() else { return false };
        map = rest;
    }
}

/// A variable and its value where the component vanishes; no value if the component is an even power, so that the
/// degree is zero.
fn pivot(p: &RealPolynomial, variables: &[usize]) -> Option<(usize, Option<RealPolynomial>)> {
    for &v in variables {
        let least = p.terms().map(|(m, _)| m[v]).min().unwrap_or(0);
        let alone = |m: &[u32], k: u32| m.iter().enumerate().all(|(i, &e)| e == if i == v { k } else { 0 });
        if least > 0 && p.terms().any(|(m, _)| alone(m, least)) {
            return Some((v, (least % 2 == 1).then(RealPolynomial::default)));
        }
    }
    for &v in variables {
        let mut with = p.terms().filter(|(m, _)| m[v] > 0);
        if let (Some((m, c)), None) = (with.next(), with.next())
            && m.iter().sum::<u32>() == 1
        {
            let linear = RealPolynomial::term(c.clone(), m.clone());
            let rest = p.plus(&linear, &Real::from(-1));
            let value = RealPolynomial::default().plus(&rest, &(Real::from(-1) / c));
            return Some((v, Some(value)));
        }
    }
    None
}

/// Whether two forms in two variables have no common real zero but the origin and their vector turns around on a circle:
/// it does by the Cauchy index of Q/P on the projective line, from Sturm's sequence.
fn winds([p, q]: [&RealPolynomial; 2], [x, y]: [usize; 2]) -> bool {
    // On opposite points the turns cancel.
    if (p.order() + q.order()) % 2 == 1 {
        return false;
    }
    // Along (t, 1 + s t), with s so that P does not vanish at infinity.
    let degree = p.order() as usize;
    let Some((p, q)) = (0..=degree as i64)
        .map(|s| (along(p, [x, y], s), along(q, [x, y], s)))
        .find(|(p, _)| !p.is_zero() && p.degree() == degree)
    else {
        return false;
    };
    let chain = UnivariatePolynomial::signed_remainders(&p, &q);
    let turns = |chain: &[UnivariatePolynomial<Real>]| Some(variations(chain, true)? != variations(chain, false)?);
    // Common zeros are the real roots of the last one (Sturm).
    let common = chain.last().map(|common| UnivariatePolynomial::signed_remainders(common, &common.derivative()));
    common.and_then(|common| turns(&common)) == Some(false) && turns(&chain) == Some(true)
}

/// A form at x = t, y = 1 + s t.
fn along(form: &RealPolynomial, [x, y]: [usize; 2], s: i64) -> UnivariatePolynomial<Real> {
    let line = UnivariatePolynomial::new(vec![Real::ONE, Real::from(s)]);
    let t = UnivariatePolynomial::new(vec![Real::ZERO, Real::ONE]);
    let mut sum = UnivariatePolynomial::new(Vec::new());
    for (m, c) in form.terms() {
        let mut part = UnivariatePolynomial::new(vec![c.clone()]);
        for _ in 0..m[x] {
            part = part.mul(&t);
        }
        for _ in 0..m[y] {
            part = part.mul(&line);
        }
        sum = sum.add(&part);
    }
    sum
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn polynomial(terms: &[(i64, &[u32])]) -> RealPolynomial {
        terms.iter().fold(RealPolynomial::default(), |p, (c, m)| {
            p.plus(&RealPolynomial::term(Real::ONE, m.to_vec()), &Real::from(*c))
        })
    }

    /// Real and imaginary part of z^k wind k times, of z^k times its conjugate as often, of |z|² and a form not at all.
    #[test]
    fn powers_of_a_complex_number_wind() {
        let mut re = polynomial(&[(1, &[0, 0])]);
        let mut im = RealPolynomial::default();
        let (x, y) = (polynomial(&[(1, &[1, 0])]), polynomial(&[(1, &[0, 1])]));
        for k in 1..=6 {
            let next = re.times(&x).unwrap().plus(&im.times(&y).unwrap(), &Real::from(-1));
            im = re.times(&y).unwrap().plus(&im.times(&x).unwrap(), &Real::ONE);
            re = next;
            assert!(has_local_degree(vec![re.clone(), im.clone()], vec![0, 1]), "{k}");
            assert!(has_local_degree(vec![im.clone(), re.clone()], vec![0, 1]), "{k}");
            // z^k + |z|^(2k+2) has the same degree.
            let disturbed = re.plus(&polynomial(&[(5, &[2 * k + 2, 0]), (1, &[0, 2 * k + 2])]), &Real::ONE);
            assert!(has_local_degree(vec![disturbed, im.clone()], vec![0, 1]), "{k}");
        }
        let square = polynomial(&[(1, &[2, 0]), (1, &[0, 2])]);
        let product = polynomial(&[(1, &[1, 1])]);
        assert!(!has_local_degree(vec![square, product.clone()], vec![0, 1]));
        assert!(!has_local_degree(vec![product.clone(), product], vec![0, 1]));
    }

    #[test]
    fn triangular_maps_of_odd_powers_cover_and_of_even_powers_do_not() {
        for (k, covers) in [(1, true), (2, false), (3, true), (4, false), (5, true)] {
            // (x^k (1 + y), z − x², y^3 + z² x)
            let map = vec![
                polynomial(&[(2, &[k, 0, 0]), (2, &[k, 1, 0])]),
                polynomial(&[(1, &[0, 0, 1]), (-1, &[2, 0, 0])]),
                polynomial(&[(1, &[0, 3, 0]), (1, &[1, 0, 2])]),
            ];
            assert_eq!(has_local_degree(map, vec![0, 1, 2]), covers, "{k}");
        }
    }
}
