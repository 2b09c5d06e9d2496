//! Curves along which a function of the plane is negative.

use bracketry_symbolic::{FieldElement, OrderedField, Rational, Real, UnivariatePolynomial};

use crate::linear::polynomial::{RealPolynomial, unit};

/// v_k = κ t^α, or that added to whole powers of t below, and the other parameters 0: a function of (t, v) is negative there for
/// small t > 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    /// α.
    pub(crate) power: Rational,
    /// The function is a negative multiple of this power of t, and higher ones.
    pub(crate) order: Rational,
}

/// Most terms whose exponents give the powers that are tried; most terms c t^k that are split off from a curve before, and of ways to
/// choose each.
const MAX_TERMS: usize = 60;
const MAX_SHIFTS: usize = 3;
const MAX_ROOTS: usize = 4;
/// A multiple of t that is added to a parameter before another one is chosen.
const TOGETHER: i64 = 3;

impl Curve {
    /// A curve on which `sign` b(sign·t, v) is negative, with a power of at least `least`, where the terms of b above `degree` are not
    /// known. On v_k = κ t^α the terms of b with the least i + α j decide; those α are tried at which several terms are equal (the
    /// slopes of Newton's polygon), and some between and beyond them.
    pub(crate) fn of(b: &RealPolynomial, sign: i64, degree: u32, least: &Rational) -> Option<Curve> {
        let mut signed = RealPolynomial::default();
        for (m, c) in b.terms() {
            let flips = sign < 0 && m[0] % 2 == 0;
            signed.add_term(m.clone(), if flips { -c } else { c.clone() });
        }
        Self::below(&signed, degree, least, MAX_SHIFTS)
    }

    /// The same for `sign` = 1.
    fn below(b: &RealPolynomial, degree: u32, least: &Rational, shifts: usize) -> Option<Curve> {
        let variables = b.terms().next()?.0.len();
        let mut cancel = Vec::new();
        for k in 1..variables {
            let on_axis = |m: &[u32]| m.iter().enumerate().all(|(i, e)| i == 0 || i == k || *e == 0);
            let terms: Vec<Term> =
                b.terms().filter(|(m, _)| on_axis(m)).map(|(m, c)| (m[0], m[k], c.clone())).collect();
            match along(&terms, degree, least) {
                Along::Falls(curve) => return Some(curve),
                Along::Cancel(roots) => cancel.extend(roots.into_iter().map(|(power, x)| (k, power, x))),
            }
        }
        cancel.truncate(MAX_ROOTS);
        if variables > 2 && shifts == MAX_SHIFTS {
            // Several parameters may have to change together.
            let sizes = [1, -1].map(|sign| Real::from(sign * TOGETHER));
            cancel.extend((1..variables).flat_map(|k| sizes.clone().map(|x| (k, 1, x))));
        }
        // Where leading terms cancel, later ones decide.
        cancel.into_iter().filter(|_| shifts > 0).find_map(|(k, power, x)| {
            let mut values: Vec<_> =
                (0..variables).map(|i| RealPolynomial::term(Real::ONE, unit(variables, i))).collect();
            values[k].add_term((0..variables).map(|j| if j == 0 { power } else { 0 }).collect(), x);
            Self::below(&b.composed(&values, variables, degree), degree, least, shifts - 1)
        })
    }
}

/// c t^i v^j by i, j, and c.
type Term = (u32, u32, Real);

/// What curves v = κ t^α show of a function of (t, v).
enum Along {
    Falls(Curve),
    /// The leading terms cancel for these whole α and κ.
    Cancel(Vec<(u32, Real)>),
}

fn along(terms: &[Term], degree: u32, least: &Rational) -> Along {
    let mut cancel = Vec::new();
    if terms.len() > MAX_TERMS {
        return Along::Cancel(cancel);
    }
    let highest = terms.iter().map(|t| t.1).max().unwrap_or(0) as usize;
    for power in powers(terms, least) {
        let weight = |(i, j, _): &Term| Rational::from(*i) + &power * Rational::from(*j);
        let unknown = Rational::from(degree + 1) * (&power).min(&Rational::ONE);
        let Some(order) = terms.iter().map(weight).min().filter(|order| *order < unknown) else { continue };
        let mut leading = vec![Real::ZERO; highest + 1];
        for t in terms.iter().filter(|t| weight(t) == order) {
            leading[t.1 as usize] += &t.2;
        }
        let leading = UnivariatePolynomial::new(leading);
        let nearby: Option<Vec<Rational>> = leading.coefficients().iter().map(Real::approximation).collect();
        let Some(nearby) = nearby.map(UnivariatePolynomial::new) else { continue };
        if between_roots(&nearby).into_iter().any(|x| leading.at(&Real::from(x)).is_negative()) {
            return Along::Falls(Curve { power, order });
        }
        if let Some(k) = (1..=degree).find(|k| Rational::from(*k) == power) {
            cancel.extend(exact_roots(&leading, &nearby).into_iter().filter(|x| !x.is_zero()).map(|x| (k, x)));
        }
    }
    Along::Cancel(cancel)
}

/// The rational roots of a polynomial, or the root of one with a single root other than 0; `nearby` has rational coefficients.
fn exact_roots(p: &UnivariatePolynomial<Real>, nearby: &UnivariatePolynomial) -> Vec<Real> {
    if p.coefficients().iter().all(|c| c.rational().is_some()) {
        return nearby.roots().into_iter().filter_map(|r| r.exact).map(Real::from).collect();
    }
    let without_zero = p.coefficients().iter().skip_while(|c| c.is_zero()).cloned().collect();
    let p = UnivariatePolynomial::new(without_zero);
    let simple = p.quotient(&p.gcd(&p.derivative()));
    match simple.coefficients() {
        [a, b] => vec![-a / b],
        _ => Vec::new(),
    }
}

/// The powers at which two terms are equal, those between, one beyond, and the least that is allowed.
fn powers(terms: &[Term], least: &Rational) -> Vec<Rational> {
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
