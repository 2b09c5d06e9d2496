//! Factors of polynomials in parameters, as far as they are found, and their real zeros.

use bracketry_symbolic::{Rational, UnivariatePolynomial};

use crate::algebra::rational::polynomial::{Budget, Polynomial};

/// A primitive polynomial without repeated factors.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Factor {
    pub(crate) polynomial: Polynomial,
    /// Whether it is known to have no further factors over the rational numbers.
    pub(crate) irreducible: bool,
}

/// The distinct factors of a polynomial that is not zero; `None` if the budget is spent.
///
/// Split off are powers of variables, contents, repeated factors, factors of polynomials that have degree 2 in a variable,
/// and factors that are linear in a variable.
pub(crate) fn factors(p: &Polynomial, budget: &mut Budget) -> Option<Vec<Factor>> {
    let mut done: Vec<Factor> = Vec::new();
    let content = p.monomial_content();
    for (i, _) in content.iter().enumerate().filter(|x| *x.1 > 0) {
        done.push(Factor { polynomial: Polynomial::atom(i), irreducible: true });
    }
    let mut open = vec![p.divided_by_monomial(&content)?.primitive().1];
    while let Some(p) = open.pop() {
        if p.is_constant() {
            continue;
        }
        let parts = split(&p, budget)?;
        if !parts.is_empty() {
            open.extend(parts);
            continue;
        }
        let irreducible = p.support().iter().any(|&v| p.degree(v) <= 2);
        let factor = Factor { polynomial: p, irreducible };
        if !done.contains(&factor) {
            done.push(factor);
        }
    }
    done.sort();
    Some(done)
}

/// Two or more factors whose product has the same zeros; none if none are found.
fn split(p: &Polynomial, budget: &mut Budget) -> Option<Vec<Polynomial>> {
    for v in p.support() {
        let content = p.content_in(v, budget)?.primitive().1;
        if !content.is_constant() {
            return Some(vec![p.exact_quotient(&content, budget)?.primitive().1, content]);
        }
    }
    for v in p.support() {
        let repeated = p.gcd(&p.derivative(v), budget)?;
        if !repeated.is_constant() {
            return Some(vec![p.exact_quotient(&repeated, budget)?.primitive().1, repeated]);
        }
    }
    if p.support().iter().any(|&v| p.degree(v) == 1) {
        return Some(Vec::new());
    }
    for v in p.support() {
        if p.degree(v) == 2 {
            return quadratic(p, v, budget);
        }
    }
    match p.support().into_iter().find_map(|v| linear_factor(p, v, budget)) {
        Some(common) => Some(vec![p.exact_quotient(&common, budget)?.primitive().1, common]),
        None => Some(Vec::new()),
    }
}

/// a v² + b v + c factors where b² − 4ac is a square.
fn quadratic(p: &Polynomial, v: usize, budget: &mut Budget) -> Option<Vec<Polynomial>> {
    let [c, b, a] = &p.coefficients(v)[..] else { return Some(Vec::new()) };
    let mut discriminant = b.mul(b, budget)?;
    discriminant.add(&a.mul(c, budget)?, &Rational::from(-4));
    let root = square_root(&discriminant, budget)?;
    if root.is_zero() {
        return Some(Vec::new());
    }
    // 2 a v + b − √D
    let mut linear = a.mul(&Polynomial::atom(v), budget)?.scaled(&Rational::from(2));
    linear.add(b, &Rational::ONE);
    linear.add(&root, &-Rational::ONE);
    let common = p.gcd(&linear, budget)?;
    if common.is_constant() || common == *p {
        return Some(Vec::new());
    }
    Some(vec![p.exact_quotient(&common, budget)?.primitive().1, common])
}

/// The polynomial whose square this is; zero if there is none.
fn square_root(p: &Polynomial, budget: &mut Budget) -> Option<Polynomial> {
    if p.is_zero() {
        return Some(p.clone());
    }
    let Some((m, c)) = p.leading() else { return Some(Polynomial::default()) };
    let root = |c: &Rational| {
        let guess = Rational::simplest_from_f64(c.to_f64().value().sqrt())?;
        (&guess * &guess == *c).then_some(guess)
    };
    let (Some(c), true) = (root(c), m.iter().all(|k| k % 2 == 0)) else { return Some(Polynomial::default()) };
    let lead = Polynomial::term(&c, m.iter().map(|k| k / 2).collect());
    let double = lead.scaled(&Rational::from(2));
    let mut sum = lead;
    // Each step takes off the leading term of the rest.
    for _ in 0..=p.len() {
        let mut rest = p.clone();
        rest.add(&sum.mul(&sum, budget)?, &-Rational::ONE);
        if rest.is_zero() {
            return Some(sum);
        }
        let Some((m, c)) = rest.leading() else { return Some(Polynomial::default()) };
        let Some(next) = Polynomial::term(c, m.clone()).exact_quotient(&double, budget) else {
            return Some(Polynomial::default());
        };
        sum.add(&next, &Rational::ONE);
    }
    Some(Polynomial::default())
}

/// Values of the other variables at which roots are sought.
const PLACES: [[i64; 4]; 3] = [[1, 2, 3, 5], [2, -1, 5, 3], [-3, 4, 1, 7]];

/// A factor that is linear in variable `v`: a rational root at a place is followed as a power series in the other
/// variables; times the leading coefficient it is a polynomial if it belongs to such a factor.
fn linear_factor(p: &Polynomial, v: usize, budget: &mut Budget) -> Option<Polynomial> {
    let others: Vec<usize> = p.support().into_iter().filter(|&w| w != v).collect();
    let one = Polynomial::constant(&Rational::ONE);
    let shifted = |p: &Polynomial, place: &[i64; 4], sign: i64, budget: &mut Budget| {
        let mut q = p.clone();
        for (k, &w) in others.iter().enumerate() {
            let mut to = Polynomial::atom(w);
            to.add(&one, &Rational::from(sign * (place[k % 4] + (k / 4) as i64)));
            q = substituted(&q, w, &to, &one, budget)?;
        }
        Some(q)
    };
    let total = |m: &[u32]| m.iter().enumerate().filter(|x| x.0 != v).map(|x| *x.1).sum::<u32>();
    let degree = p.terms().map(|(m, _)| total(m)).max()?;
    for place in &PLACES {
        let q = shifted(p, place, 1, budget)?;
        let coefficients = q.coefficients(v);
        let at_place: Vec<Rational> = coefficients.iter().map(Polynomial::constant_term).collect();
        let univariate = UnivariatePolynomial::new(at_place);
        if univariate.degree() + 1 < coefficients.len() {
            continue;
        }
        let slope = univariate.derivative();
        for root in univariate.roots().into_iter().filter_map(|r| r.exact) {
            let steep = slope.at(&root);
            if steep == Rational::ZERO {
                continue;
            }
            let step = -(Rational::ONE / steep);
            let mut series = Polynomial::constant(&root);
            // Each step gives one more degree.
            for _ in 0..degree {
                let mut value = Polynomial::default();
                for c in coefficients.iter().rev() {
                    value = value.mul(&series, budget)?.truncated(degree);
                    value.add(c, &Rational::ONE);
                }
                series.add(&value.truncated(degree), &step);
            }
            let lead = &coefficients[coefficients.len() - 1];
            let mut candidate = lead.mul(&Polynomial::atom(v), budget)?;
            candidate.add(&lead.mul(&series, budget)?.truncated(degree), &-Rational::ONE);
            let candidate = shifted(&candidate, place, -1, budget)?;
            let common = p.gcd(&candidate, budget)?;
            if !common.is_constant() && common != *p {
                return Some(common);
            }
        }
    }
    None
}

/// What holds where a polynomial vanishes at real values.
pub(crate) enum RealZeros {
    /// It never does.
    None,
    /// Only where all of these do: the terms of a sum of squares, or what a discriminant that is never positive leaves.
    Together(Vec<Polynomial>),
    /// Nothing simpler.
    Open,
}

/// Where a polynomial may vanish at real values, if it or the negative of a discriminant is a sum of even powers with
/// positive coefficients.
pub(crate) fn real_zeros(p: &Polynomial, budget: &mut Budget) -> RealZeros {
    match sum_of_even_powers(p) {
        RealZeros::Open => {}
        found => return found,
    }
    for v in p.support().into_iter().filter(|&v| p.degree(v) == 2) {
        let [c, b, a] = &p.coefficients(v)[..] else { continue };
        let (Some(mut d), Some(ac)) = (b.mul(b, budget), a.mul(c, budget)) else { return RealZeros::Open };
        d.add(&ac, &Rational::from(-4));
        if d.terms().any(|(_, c)| *c > Rational::ZERO) {
            continue;
        }
        let monomials = if d.len() == 1 && d.terms().all(|(m, _)| m.iter().all(|k| k % 2 == 0)) {
            if d.is_constant() { RealZeros::None } else { RealZeros::Together(vec![d]) }
        } else {
            sum_of_even_powers(&d)
        };
        match monomials {
            RealZeros::Open => {}
            RealZeros::None => return RealZeros::None,
            RealZeros::Together(mut list) => {
                // The double root: 2 a v + b = 0.
                let Some(mut slope) = a.mul(&Polynomial::atom(v), budget) else { return RealZeros::Open };
                slope = slope.scaled(&Rational::from(2));
                slope.add(b, &Rational::ONE);
                list.push(slope);
                return RealZeros::Together(list);
            }
        }
    }
    RealZeros::Open
}

fn sum_of_even_powers(p: &Polynomial) -> RealZeros {
    let positive = p.terms().all(|(_, c)| *c > Rational::ZERO) || p.terms().all(|(_, c)| *c < Rational::ZERO);
    if !positive || p.terms().any(|(m, _)| m.iter().any(|k| k % 2 == 1)) || p.len() < 2 {
        return RealZeros::Open;
    }
    if p.terms().any(|(m, _)| m.is_empty()) {
        return RealZeros::None;
    }
    RealZeros::Together(p.terms().map(|(m, _)| Polynomial::term(&Rational::ONE, m.clone())).collect())
}

/// `p` with `top / bottom` in place of variable `v`, times a power of `bottom`.
pub(crate) fn substituted(
    p: &Polynomial,
    v: usize,
    top: &Polynomial,
    bottom: &Polynomial,
    budget: &mut Budget,
) -> Option<Polynomial> {
    let coefficients = p.coefficients(v);
    let degree = coefficients.len() as u32 - 1;
    let mut total = Polynomial::default();
    for (k, c) in (0u32..).zip(&coefficients) {
        let power = top.pow(k, budget)?.mul(&bottom.pow(degree - k, budget)?, budget)?;
        total.add(&c.mul(&power, budget)?, &Rational::ONE);
    }
    Some(total)
}

/// The determinant of a square matrix (Bareiss 1968: divisions leave no remainder).
pub(crate) fn determinant(mut m: Vec<Vec<Polynomial>>, budget: &mut Budget) -> Option<Polynomial> {
    let n = m.len();
    let mut before = Polynomial::constant(&Rational::ONE);
    let mut sign = Rational::ONE;
    for k in 0..n {
        let Some(pivot) = (k..n).filter(|&i| !m[i][k].is_zero()).min_by_key(|&i| m[i][k].len()) else {
            return Some(Polynomial::default());
        };
        if pivot != k {
            m.swap(k, pivot);
            sign = -sign;
        }
        let (upper, lower) = m.split_at_mut(k + 1);
        let row = &upper[k];
        for other in lower {
            for j in k + 1..n {
                let mut e = other[j].mul(&row[k], budget)?;
                e.add(&other[k].mul(&row[j], budget)?, &-Rational::ONE);
                other[j] = e.exact_quotient(&before, budget)?;
            }
            other[k] = Polynomial::default();
        }
        before = m[k][k].clone();
    }
    Some(before.scaled(&sign))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use bracketry_symbolic::{Pool, Symbol};

    use super::*;
    use crate::algebra::rational::parametric::{expression, quotient};

    fn polynomial(pool: &mut Pool, text: &str) -> (Polynomial, [Symbol; 3]) {
        let names = ["a", "b", "c"].map(|s| pool.symbol(s));
        let e = pool.parse(text).unwrap();
        (quotient(pool, e, &names, &mut Budget::new(100_000)).unwrap().0, names)
    }

    fn factors_of(text: &str) -> Vec<String> {
        let mut pool = Pool::new();
        let (p, names) = polynomial(&mut pool, text);
        let list = factors(&p, &mut Budget::new(100_000)).unwrap();
        let mut texts: Vec<String> = list
            .iter()
            .map(|f| {
                let e = expression(&mut pool, &f.polynomial, &names);
                pool.text(e)
            })
            .collect();
        texts.sort();
        texts
    }

    #[test]
    fn differences_and_squares_are_split_off() {
        assert_eq!(factors_of("a^3*b*(a - b)^2*(b - c)*(a + 2*c)"), ["a", "a + 2*c", "a - b", "b", "b - c"]);
        assert_eq!(factors_of("a^2 - b^2"), ["a + b", "a - b"]);
        assert_eq!(factors_of("a^2 + b^2"), ["a^2 + b^2"]);
        assert_eq!(factors_of("a^4 - b^4"), ["a + b", "a - b", "a^2 + b^2"]);
        assert_eq!(factors_of("(a*b - c)*(a*b + c)*(a - 1)"), ["a - 1", "a*b + c", "a*b - c"]);
        // Of degree 3 in both variables.
        assert_eq!(factors_of("(a - b)*(a^2*b^2 + a*b - b^2 + a)").len(), 2);
        assert_eq!(factors_of("(a*b - 2)*(a^3 + b^3 + 5)*(a + 3*b + 1)").len(), 3);
        assert_eq!(factors_of("a^3 + b^3 + 5").len(), 1);
    }

    #[test]
    fn determinants_of_vandermonde_matrices_are_products_of_differences() {
        let mut pool = Pool::new();
        let row = |pool: &mut Pool, s: &str| -> Vec<Polynomial> {
            ["1".to_owned(), s.to_owned(), format!("{s}^2")].iter().map(|t| polynomial(pool, t).0).collect()
        };
        let m = ["a", "b", "c"].map(|s| row(&mut pool, s)).to_vec();
        let d = determinant(m, &mut Budget::new(100_000)).unwrap();
        let (expected, _) = polynomial(&mut pool, "(b - a)*(c - a)*(c - b)");
        assert_eq!(d, expected);
    }

    #[test]
    fn sums_of_even_powers_vanish_only_where_every_term_does() {
        let mut pool = Pool::new();
        let mut zeros = |text: &str| real_zeros(&polynomial(&mut pool, text).0, &mut Budget::new(10_000));
        assert!(matches!(zeros("1 + a^2"), RealZeros::None));
        assert!(matches!(zeros("a^2 + 3*b^4"), RealZeros::Together(list) if list.len() == 2));
        assert!(matches!(zeros("a^2 + a*b + b^2"), RealZeros::Together(list) if list.len() == 2));
        assert!(matches!(zeros("a^2 + a + 1"), RealZeros::None));
        assert!(matches!(zeros("a^2 + a*b - b^2"), RealZeros::Open));
        assert!(matches!(zeros("a^2 - b^2"), RealZeros::Open));
    }
}
