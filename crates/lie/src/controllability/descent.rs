//! Curves along which a function of the plane is negative.

use bracketry_symbolic::{Rational, UnivariatePolynomial};

use crate::linear::polynomial::MultivariatePolynomial;

/// v = κ d t^α, or that added to whole powers of t below: a function of (t, v) is negative there for
/// small t > 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    /// α.
    pub(crate) power: Rational,
    /// The function is a negative multiple of this power of t, and higher ones.
    pub(crate) order: Rational,
}

/// Most terms whose exponents give the powers that are tried, and most terms c t^k that are split off from a curve before.
const MAX_TERMS: usize = 60;
const MAX_SHIFTS: usize = 3;

impl Curve {
    /// A curve on which `sign` b(sign·t, v) is negative, with a power of at least `least`, where the terms of b above `degree` are not
    /// known. On v = κ d t^α, for a direction d, the terms of b with the least i + α j decide; those α are tried at which several terms
    /// are equal (the slopes of Newton's polygon), and some between and beyond them.
    pub(crate) fn of(b: &MultivariatePolynomial, sign: i64, degree: u32, least: &Rational) -> Option<Curve> {
        let parameters = b.terms().next()?.0.len() - 1;
        directions(parameters).into_iter().find_map(|d| {
            let mut along = MultivariatePolynomial::default();
            for (m, c) in b.terms() {
                let factor = d.iter().zip(&m[1..]).map(|(&d, &k)| d.pow(k)).product::<i64>();
                let flips = if sign < 0 && m[0] % 2 == 0 { -1 } else { 1 };
                along.add_term(vec![m[0], m[1..].iter().sum()], c * Rational::from(factor * flips));
            }
            Self::below(&along, degree, least, MAX_SHIFTS)
        })
    }

    /// The same for a function of (t, v), where t > 0.
    fn below(b: &MultivariatePolynomial, degree: u32, least: &Rational, shifts: usize) -> Option<Curve> {
        let terms: Vec<(u32, u32, Rational)> = b.terms().map(|(m, c)| (m[0], m[1], c.clone())).collect();
        if terms.is_empty() || terms.len() > MAX_TERMS {
            return None;
        }
        let mut shifted = Vec::new();
        for power in powers(&terms, least) {
            let weight = |(i, j, _): &(u32, u32, Rational)| Rational::from(*i) + &power * Rational::from(*j);
            let order = terms.iter().map(weight).min()?;
            let unknown = Rational::from(degree + 1) * (&power).min(&Rational::ONE);
            if order >= unknown {
                continue;
            }
            let highest = terms.iter().map(|t| t.1).max()? as usize;
            let mut leading = vec![Rational::ZERO; highest + 1];
            for t in terms.iter().filter(|t| weight(t) == order) {
                leading[t.1 as usize] += &t.2;
            }
            let leading = UnivariatePolynomial::new(leading);
            if between_roots(&leading).iter().any(|x| leading.at(x) < Rational::ZERO) {
                return Some(Curve { power, order });
            }
            // Where the leading terms cancel, later ones decide.
            if let Some(k) = whole(&power) {
                let roots = leading.roots().into_iter().filter_map(|r| r.exact).filter(|x| *x != Rational::ZERO);
                shifted.extend(roots.map(|x| (k, x)));
            }
        }
        shifted.into_iter().filter(|_| shifts > 0).find_map(|(k, x)| {
            let t = MultivariatePolynomial::term(Rational::ONE, vec![1, 0]);
            let v = MultivariatePolynomial::term(Rational::ONE, vec![0, 1]);
            let v = v.plus(&MultivariatePolynomial::term(x, vec![k, 0]), &Rational::ONE);
            let least = Rational::from(k) + Rational::ONE;
            Self::below(&b.composed(&[t, v], 2, degree), degree, &least, shifts - 1)
        })
    }
}

/// One parameter alone, and two with the ratios ±1, ±2, ±1/2.
fn directions(n: usize) -> Vec<Vec<i64>> {
    let with = |entries: &[(usize, i64)]| {
        let mut d = vec![0; n];
        entries.iter().for_each(|&(k, c)| d[k] = c);
        d
    };
    let mut list: Vec<Vec<i64>> = (0..n).map(|k| with(&[(k, 1)])).collect();
    for k in 1..n {
        for j in 0..k {
            list.extend([(1, 1), (1, -1), (1, 2), (1, -2), (2, 1), (2, -1)].map(|(a, b)| with(&[(j, a), (k, b)])));
        }
    }
    list
}

fn whole(x: &Rational) -> Option<u32> {
    (1..=MAX_TERMS as u32).find(|k| Rational::from(*k) == *x)
}

/// The powers at which two terms are equal, those between, one beyond, and the least that is allowed.
fn powers(terms: &[(u32, u32, Rational)], least: &Rational) -> Vec<Rational> {
    let mut all: Vec<Rational> = Vec::new();
    for a in terms {
        for b in terms.iter().filter(|b| b.1 > a.1 && b.0 < a.0) {
            all.push(Rational::from(a.0 - b.0) / Rational::from(b.1 - a.1));
        }
    }
    all.retain(|p| p > least);
    all.push(if *least > Rational::ZERO { least.clone() } else { Rational::ONE });
    all.sort();
    all.dedup();
    let two = Rational::from(2);
    let mut list = Vec::new();
    if let Some(first) = all.first().filter(|_| *least == Rational::ZERO) {
        list.push(first / &two);
    }
    for pair in all.windows(2) {
        list.extend([pair[0].clone(), (&pair[0] + &pair[1]) / &two]);
    }
    if let Some(last) = all.last() {
        list.extend([last.clone(), last + Rational::ONE]);
    }
    list
}

/// Numbers on all sides of the real roots.
fn between_roots(p: &UnivariatePolynomial) -> Vec<Rational> {
    let ends: Vec<Rational> = p.roots().into_iter().flat_map(|r| r.between).collect();
    let mut list: Vec<Rational> = ends.windows(2).map(|w| (&w[0] + &w[1]) / Rational::from(2)).collect();
    let one = Rational::ONE;
    list.extend([Rational::ZERO, one.clone(), -one.clone()]);
    list.extend(ends.first().map(|a| a - &one));
    list.extend(ends.last().map(|b| b + &one));
    list.extend(ends);
    list
}
