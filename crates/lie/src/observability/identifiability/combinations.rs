//! Functions of the parameters that the outputs determine, though not the parameters themselves.
//!
//! A function φ of the parameters is determined locally just when dφ vanishes along all directions, projected to the
//! parameters, along which no output changes, whatever the states. The coefficients of products, sums, and polynomials
//! of degree two solve linear equations at points modulo a prime; what is found is decided again as a function that is
//! asked for, modulo two primes.

use bracketry_symbolic::{Echelon, Expr, Pool, Rational, Residue, SplitMix64, Symbol};

use crate::observability::identifiability::local_identifiability::{Question, SEED, point};
use crate::undecided::Undecided;

/// Points at which states vary while the parameters stay.
const STATES: u64 = 2;
/// Values of the parameters, beyond the last that tells something new, and at most.
const IDLE: usize = 2;
const MAX_VALUES: u64 = 60;
/// Columns of the polynomials of degree two.
const MAX_COLUMNS: usize = 50;
/// Largest numerator and denominator of a coefficient.
const BOUND: u64 = 1 << 12;

/// Combinations that were found, and how many more there may be.
pub(crate) struct Combinations {
    pub(crate) found: Vec<Expr>,
    pub(crate) missing: usize,
}

/// The directions at given values of the parameters.
struct Sample {
    /// Values of all parameters.
    values: Vec<Residue<1>>,
    /// Components along the parameters that are not determined.
    directions: Vec<Vec<Residue<1>>>,
}

/// A product of powers of parameters, by their numbers.
type Product = Vec<(usize, i32)>;

struct Search<'a> {
    question: &'a Question,
    parameters: &'a [Symbol],
    /// Numbers of the parameters that are not determined.
    moving: Vec<usize>,
    samples: Vec<Sample>,
}

impl Search<'_> {
    /// The directions at the next values of the parameters.
    fn sample(&self, pool: &mut Pool, number: u64) -> Result<Sample, Undecided> {
        let q = self.question;
        let mut bindings = q.special.clone();
        let mut values = Vec::new();
        let mut random = SplitMix64::new(number);
        for &s in self.parameters {
            let value = random.integer(2, 99_992) as u64;
            bindings.bind(s, Rational::from(value));
            values.push(Residue::new(value));
        }
        let mut span: Echelon<Residue<1>> = Echelon::empty(self.moving.len());
        for seed in 0..STATES {
            let here = point::<1>(pool, q, &bindings, SEED ^ (number << 8) ^ (seed << 4))?;
            for v in q.with_known(&here.span).null_space() {
                span.insert(self.moving.iter().map(|&i| v[q.states + i]).collect());
            }
        }
        Ok(Sample { values, directions: span.rows })
    }

    /// Sample number k, taken if it is not there yet.
    fn at(&mut self, pool: &mut Pool, k: usize) -> Result<&Sample, Undecided> {
        while self.samples.len() <= k {
            let next = self.sample(pool, self.samples.len() as u64 + 1)?;
            self.samples.push(next);
        }
        Ok(&self.samples[k])
    }

    /// Gradient by the moving parameters of a sum of products (or of logarithms).
    fn gradient(&self, products: &[Product], logarithms: bool, sample: &Sample) -> Vec<Vec<Residue<1>>> {
        products
            .iter()
            .map(|p| {
                let mut value: Residue<1> = Residue::ONE;
                for &(i, k) in p {
                    let power = sample.values[i].pow(u64::from(k.unsigned_abs()));
                    value *= if k < 0 { power.inv().unwrap_or(Residue::ONE) } else { power };
                }
                let slope = |m: usize| {
                    let k = p.iter().find(|x| x.0 == m).map_or(0, |x| x.1);
                    let over = sample.values[m].inv().unwrap_or(Residue::ONE);
                    let scale = if logarithms { Residue::ONE } else { value };
                    Residue::from_i64(i64::from(k)) * over * scale
                };
                self.moving.iter().map(|&m| slope(m)).collect()
            })
            .collect()
    }

    /// Constant coefficients for which the sum does not change along the directions.
    fn coefficients(
        &mut self,
        pool: &mut Pool,
        products: &[Product],
        logarithms: bool,
    ) -> Result<Vec<Vec<Rational>>, Undecided> {
        let n = products.len();
        let mut equations: Echelon<Residue<1>> = Echelon::empty(n);
        let mut idle = 0;
        for k in 0..MAX_VALUES as usize {
            self.at(pool, k)?;
            let sample = &self.samples[k];
            let gradients = self.gradient(products, logarithms, sample);
            let mut fresh = false;
            for v in &sample.directions {
                let row = gradients.iter().map(|g| g.iter().zip(v).fold(Residue::ZERO, |s, (&a, &b)| s + a * b));
                fresh |= equations.insert(row.collect());
            }
            idle = if fresh { 0 } else { idle + 1 };
            if idle == IDLE || equations.rank() == n {
                break;
            }
        }
        if idle < IDLE {
            return Ok(Vec::new());
        }
        let rational = |v: Vec<Residue<1>>| v.iter().map(|c| c.to_rational(BOUND)).collect::<Option<Vec<Rational>>>();
        let mut list: Vec<Vec<Rational>> = equations.null_space().into_iter().filter_map(rational).collect();
        list.sort_by_key(|v| v.iter().filter(|c| **c != Rational::ZERO).count());
        Ok(list)
    }
}

/// Combinations of the parameters that are not determined themselves; `determined` tells by parameter.
///
/// # Errors
/// [`Undecided`] if there is too much to compute.
pub(crate) fn combinations(
    pool: &mut Pool,
    question: &Question,
    determined: &[bool],
) -> Result<Combinations, Undecided> {
    let parameters = question.variables[question.states..].to_vec();
    let moving: Vec<usize> = (0..parameters.len()).filter(|&i| !determined[i]).collect();
    let m = moving.len();
    if m == 0 {
        return Ok(Combinations { found: Vec::new(), missing: 0 });
    }
    let mut search = Search { question, parameters: &parameters, moving: moving.clone(), samples: Vec::new() };
    let rank = search.at(pool, 0)?.directions.len().max(search.at(pool, 1)?.directions.len());
    let wanted = m - rank.min(m);
    let mut found: Vec<Expr> = Vec::new();
    let mut independent: Echelon<Residue<1>> = Echelon::empty(m);
    let single: Vec<Product> = moving.iter().map(|&i| vec![(i, 1)]).collect();
    let all = quadratic(&moving, parameters.len());
    for (products, logarithms) in [(&single, true), (&single, false), (&all, false)] {
        if found.len() == wanted || products.len() > MAX_COLUMNS {
            continue;
        }
        for c in search.coefficients(pool, products, logarithms)? {
            if found.len() == wanted {
                break;
            }
            let gradients = search.gradient(products, logarithms, &search.samples[0]);
            let mut total = vec![Residue::ZERO; m];
            for (x, g) in c.iter().zip(&gradients) {
                let Some(x) = Residue::<1>::from_rational(x) else { continue };
                for (t, &v) in total.iter_mut().zip(g) {
                    *t += x * v;
                }
            }
            if independent.insert(total) {
                found.push(expression(pool, &parameters, products, &c, logarithms));
            }
        }
    }
    let missing = wanted - found.len();
    Ok(Combinations { found, missing })
}

/// Products and quotients of two parameters, one of them not determined.
fn quadratic(moving: &[usize], n: usize) -> Vec<Product> {
    let mut list: Vec<Product> = moving.iter().map(|&i| vec![(i, 1)]).collect();
    for &i in moving {
        for j in 0..n {
            if i == j {
                list.push(vec![(i, 2)]);
                continue;
            }
            if !moving.contains(&j) || j > i {
                list.push(vec![(i, 1), (j, 1)]);
            }
            list.push(vec![(i, 1), (j, -1)]);
            if !moving.contains(&j) {
                list.push(vec![(i, -1), (j, 1)]);
            }
        }
    }
    list
}

fn product(pool: &mut Pool, parameters: &[Symbol], powers: &[(usize, i64)]) -> Expr {
    let mut e = pool.int(1);
    for &(i, k) in powers {
        let x = pool.sym(parameters[i]);
        let power = pool.powi(x, k);
        e = pool.mul(e, power);
    }
    e
}

/// The product with these exponents, or the sum with these coefficients.
fn expression(pool: &mut Pool, parameters: &[Symbol], products: &[Product], c: &[Rational], logarithms: bool) -> Expr {
    // Whole numbers, the first of them positive.
    let mut scale = Rational::ONE;
    for x in c {
        scale *= Rational::from((x * &scale).denominator().clone());
    }
    if c.iter().find(|x| **x != Rational::ZERO).is_some_and(|x| *x < Rational::ZERO) {
        scale = -scale;
    }
    let whole: Vec<Rational> = c.iter().map(|x| x * &scale).collect();
    if logarithms {
        let powers: Vec<(usize, i64)> = products
            .iter()
            .zip(&whole)
            .filter_map(|(p, k)| Some((p[0].0, i64::try_from(k.numerator().clone()).ok()?)))
            .filter(|x| x.1 != 0)
            .collect();
        let e = product(pool, parameters, &powers);
        return pool.simplify(e);
    }
    let mut terms = Vec::new();
    for (p, x) in products.iter().zip(whole).filter(|t| t.1 != Rational::ZERO) {
        let powers: Vec<(usize, i64)> = p.iter().map(|&(i, k)| (i, i64::from(k))).collect();
        let e = product(pool, parameters, &powers);
        let x = pool.rational(x);
        terms.push(pool.mul(x, e));
    }
    let sum = pool.sum(terms);
    pool.simplify(sum)
}
