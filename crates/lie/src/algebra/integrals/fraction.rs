//! Coefficients that are rational functions of the parameters, found from their values.

use std::collections::BTreeMap;

use bracketry_symbolic::{Expr, Pool, Rational, SplitMix64, Symbol};

use crate::residues::{Echelon, Fp};

/// Largest numerator and denominator of a rational number read from its class modulo the prime.
const BOUND: u64 = 1 << 29;
/// Largest power of one parameter in a coefficient with one term.
const MAX_POWER: i32 = 6;
/// Most unknowns of the system that a fraction of polynomials is found from.
const MAX_UNKNOWNS: usize = 160;
/// Largest total degree of numerator and denominator.
const MAX_DEGREE: u32 = 3;

/// A polynomial in the parameters: exponents, which may be negative, to coefficient.
pub(crate) type Polynomial = BTreeMap<Vec<i32>, Rational>;

/// A quotient of two polynomials.
#[derive(Clone, Debug)]
pub(crate) struct Fraction {
    pub(super) numerator: Polynomial,
    /// Without a factor that is a power of a parameter.
    pub(super) denominator: Polynomial,
}

/// The values of a vector of functions of the parameters at values of these; `None` where it has none.
pub(crate) trait Values {
    /// The base values.
    fn base(&self) -> &[u64];
    /// The vector at other values.
    fn at(&mut self, values: &[u64]) -> Option<Vec<Fp>>;
}

/// The functions of the parameters that take the values `c` at the base values and those of `vector` elsewhere.
pub(crate) fn fractions(c: &[Fp], vector: &mut dyn Values) -> Option<Vec<Fraction>> {
    let base = vector.base().to_vec();
    let k = base.len();
    let mut doubled = Vec::with_capacity(k);
    for i in 0..k {
        let mut values = base.clone();
        values[i] *= 2;
        doubled.push(vector.at(&values)?);
    }
    let mut samples: Vec<(Vec<u64>, Vec<Fp>)> = Vec::new();
    let mut result = Vec::with_capacity(c.len());
    for (i, &value) in c.iter().enumerate() {
        if value.is_zero() {
            return None;
        }
        let found = match monomial(value, i, &doubled, &base) {
            Some(f) => f,
            None => quotient(i, &doubled, c, &mut samples, vector)?,
        };
        result.push(found);
    }
    Some(result)
}

/// c·Πp^e if the value is multiplied by a power of two when any parameter is doubled.
fn monomial(value: Fp, i: usize, doubled: &[Vec<Fp>], base: &[u64]) -> Option<Fraction> {
    let inverse = value.inv()?;
    let two = Fp::new(2);
    let half = two.inv()?;
    let mut exponents = Vec::with_capacity(base.len());
    let mut rest = value;
    for (column, &b) in doubled.iter().zip(base) {
        let ratio = column[i] * inverse;
        let power = |e: i32| if e < 0 { half } else { two }.pow(u64::from(e.unsigned_abs()));
        let e = (-MAX_POWER..=MAX_POWER).find(|&e| power(e) == ratio)?;
        let b = if e > 0 { Fp::new(b).inv()? } else { Fp::new(b) };
        rest *= b.pow(u64::from(e.unsigned_abs()));
        exponents.push(e);
    }
    let one = vec![0; base.len()];
    Some(Fraction {
        numerator: [(exponents, rest.to_rational(BOUND)?)].into(),
        denominator: [(one, Rational::ONE)].into(),
    })
}

/// The quotient of polynomials of least degree through many values.
fn quotient(
    i: usize,
    doubled: &[Vec<Fp>],
    c: &[Fp],
    samples: &mut Vec<(Vec<u64>, Vec<Fp>)>,
    vector: &mut dyn Values,
) -> Option<Fraction> {
    let involved: Vec<usize> = (0..doubled.len()).filter(|&k| doubled[k][i] != c[i]).collect();
    for degree in 1..=MAX_DEGREE {
        let monomials = monomials(involved.len(), degree);
        let unknowns = 2 * monomials.len();
        if unknowns > MAX_UNKNOWNS {
            return None;
        }
        while samples.len() < unknowns + 2 {
            let seed = samples.len() as u64 + 1;
            let values: Vec<u64> =
                vector.base().iter().enumerate().map(|(k, &b)| scramble(b, seed * 64 + k as u64)).collect();
            let at = vector.at(&values)?;
            samples.push((values, at));
        }
        let mut echelon = Echelon::empty(unknowns);
        for (values, at) in samples.iter().take(unknowns + 2) {
            let mut row = Vec::with_capacity(unknowns);
            for m in &monomials {
                let power: Fp =
                    involved.iter().zip(m).fold(Fp::ONE, |p, (&k, &e)| p * Fp::new(values[k]).pow(u64::from(e)));
                // Denominator first, so that a polynomial is preferred to a fraction.
                row.push(-(at[i] * power));
                row.push(power);
            }
            echelon.insert(row);
        }
        let Some(solution) = echelon.null_space().into_iter().next() else { continue };
        let numbers: Vec<Rational> = solution.iter().map(|x| x.to_rational(BOUND)).collect::<Option<_>>()?;
        let part = |offset: usize| -> Polynomial {
            let terms = monomials.iter().zip(numbers.iter().skip(offset).step_by(2));
            terms
                .filter(|(_, n)| **n != Rational::ZERO)
                .map(|(m, n)| {
                    let mut full = vec![0; doubled.len()];
                    for (&k, &e) in involved.iter().zip(m) {
                        full[k] = e as i32;
                    }
                    (full, n.clone())
                })
                .collect()
        };
        let (mut numerator, denominator) = (part(1), part(0));
        if numerator.is_empty() || denominator.is_empty() {
            return None;
        }
        // Powers of parameters, and the size of the first coefficient, go to the numerator.
        let (powers, size) = content(&denominator);
        numerator = scaled(&numerator, &powers.iter().map(|e| -e).collect::<Vec<_>>(), &(Rational::ONE / &size));
        let denominator =
            scaled(&denominator, &powers.iter().map(|e| -e).collect::<Vec<_>>(), &(Rational::ONE / &size));
        return Some(Fraction { numerator, denominator });
    }
    None
}

/// Multiplies by numbers that bring all to polynomials without a common power of a parameter and without a
/// common number; the first keeps a positive leading coefficient.
pub(crate) fn common(fractions: &[Fraction]) -> Vec<Polynomial> {
    let mut denominators: Vec<&Polynomial> = Vec::new();
    for f in fractions {
        if f.denominator.len() > 1 && !denominators.contains(&&f.denominator) {
            denominators.push(&f.denominator);
        }
    }
    let mut list: Vec<Polynomial> = fractions
        .iter()
        .map(|f| {
            let others = denominators.iter().filter(|d| **d != &f.denominator);
            others.fold(f.numerator.clone(), |p, d| product(&p, d))
        })
        .collect();
    let all: Polynomial = list.iter().flatten().map(|(m, c)| (m.clone(), c.clone())).collect();
    let (powers, _) = content(&all);
    let numbers: Vec<Rational> = list.iter().flat_map(BTreeMap::values).cloned().collect();
    let lead = list.first().and_then(|p| p.values().next_back()).cloned().unwrap_or(Rational::ONE);
    let factor = readable_factor(&numbers, &lead);
    let minus: Vec<i32> = powers.iter().map(|e| -e).collect();
    for p in &mut list {
        *p = scaled(p, &minus, &factor);
    }
    list
}

/// The number that makes `lead` positive and all of `numbers` small integers, else `lead` one.
fn readable_factor(numbers: &[Rational], lead: &Rational) -> Rational {
    let unit = Rational::ONE / lead;
    let small = (1..=12i64).map(|k| &unit * Rational::from(k)).find(|f| numbers.iter().all(|x| (x * f).is_int()));
    small.unwrap_or(unit)
}

/// The polynomial as an expression.
pub(crate) fn expression(pool: &mut Pool, p: &Polynomial, parameters: &[Symbol]) -> Expr {
    let mut sum = pool.int(0);
    for (exponents, c) in p.iter().rev() {
        let mut term = pool.rational(c.clone());
        for (&s, &e) in parameters.iter().zip(exponents) {
            let s = pool.sym(s);
            let power = pool.powi(s, i64::from(e));
            term = pool.mul(term, power);
        }
        sum = pool.add(sum, term);
    }
    sum
}

/// Least exponent of every parameter, and the last coefficient.
fn content(p: &Polynomial) -> (Vec<i32>, Rational) {
    let mut powers: Option<Vec<i32>> = None;
    for m in p.keys() {
        powers = Some(match powers {
            None => m.clone(),
            Some(least) => least.iter().zip(m).map(|(&a, &b)| a.min(b)).collect(),
        });
    }
    (powers.unwrap_or_default(), p.values().next_back().cloned().unwrap_or(Rational::ONE))
}

fn scaled(p: &Polynomial, powers: &[i32], factor: &Rational) -> Polynomial {
    p.iter().map(|(m, c)| (m.iter().zip(powers).map(|(a, b)| a + b).collect(), c * factor)).collect()
}

fn product(p: &Polynomial, q: &Polynomial) -> Polynomial {
    let mut result = Polynomial::new();
    for (m, a) in p {
        for (n, b) in q {
            let exponents: Vec<i32> = m.iter().zip(n).map(|(x, y)| x + y).collect();
            *result.entry(exponents).or_insert(Rational::ZERO) += a * b;
        }
    }
    result.retain(|_, c| *c != Rational::ZERO);
    result
}

/// Exponents of the monomials in `variables` indeterminates up to a total degree, simple ones first.
fn monomials(variables: usize, degree: u32) -> Vec<Vec<u32>> {
    let mut all: Vec<Vec<u32>> = vec![vec![0; variables]];
    let mut last = all.clone();
    for _ in 0..degree {
        let mut next: Vec<Vec<u32>> = Vec::new();
        for m in &last {
            // Each monomial once: only indeterminates from the last one that occurs on.
            let from = m.iter().rposition(|&e| e > 0).unwrap_or(0);
            for k in from..variables {
                let mut m = m.clone();
                m[k] += 1;
                next.push(m);
            }
        }
        all.extend(next.iter().cloned());
        last = next;
        if all.len() > MAX_UNKNOWNS {
            break;
        }
    }
    all
}

/// Another value of a parameter, by a fixed rule.
pub(super) fn scramble(a: u64, b: u64) -> u64 {
    // Large enough to be generic; a few doublings stay below the prime.
    (SplitMix64::at(a, b) >> 24) | 1
}
