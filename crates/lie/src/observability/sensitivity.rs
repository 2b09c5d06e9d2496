//! Local observability and identifiability in polynomial time, by the sensitivity of the outputs' power series.
//!
//! A state or parameter is locally determined by the outputs, for generic inputs, just when its differential lies in
//! the span of the differentials of the outputs' time derivatives over the functions of states, parameters, inputs,
//! and derivatives of inputs. Once a further derivative of all outputs adds nothing to the span, none ever does, so
//! at most as many are needed as there are unknowns. The span is taken at a random point modulo a prime, from power
//! series of states and sensitivities (Sedoglavic 2002).
//!
//! A rank modulo a prime is never too large. Where it is not full, a second prime has to give the same answers.

use bracketry_symbolic::{Bindings, Echelon, Expr, Pool, Rational, Residue, SECOND_OFFSET, Symbol, THIRD_OFFSET};

use crate::algebra::field::{Field, VectorFields};
use crate::evidence::Evidence;
use crate::observability::expansion::Expansion;
use crate::observability::series::SeriesProgram;
use crate::residues::unit_row;
use crate::undecided::Undecided;

/// Seed of the points and inputs.
const SEED: u64 = 0x6272_6163_6b65_7408;
/// Most field operations for one point.
const MAX_PRODUCTS: f64 = 3e9;
/// More unknowns are not searched for symmetries.
const MAX_MOVING: usize = 80;
/// Points beyond the last that tells something new about symmetries, and the most points.
const IDLE_POINTS: usize = 2;
const MAX_POINTS: u64 = 12;
/// Largest numerator and denominator of an exponent of a scaling.
const BOUND: u64 = 1 << 10;
/// Number of primes that have to agree.
const ENOUGH: usize = 2;

/// What is asked about a system.
pub(crate) struct Asked<'a> {
    pub(crate) fields: &'a VectorFields,
    pub(crate) outputs: &'a [Expr],
    /// Parameters without a known value.
    pub(crate) unknown: &'a [Symbol],
    /// States that are known functions of time.
    pub(crate) known: &'a [Symbol],
    /// Functions of states and parameters.
    pub(crate) functions: &'a [Expr],
}

/// What the outputs determine locally, at a generic point and for generic inputs.
pub(crate) struct Sensitivity {
    /// States, then unknown parameters.
    pub(crate) variables: Vec<Symbol>,
    pub(crate) rank: usize,
    /// For each variable.
    pub(crate) determined: Vec<bool>,
    /// For each function that was asked for.
    pub(crate) functions: Vec<bool>,
    /// The first of the unknown parameters that, once known, make the outputs determine all of them.
    pub(crate) fix: Vec<Symbol>,
    /// Independent translations and scalings along which no output changes; there may be other symmetries. An error where a point
    /// could not be evaluated.
    pub(crate) directions: Result<Vec<Field>, Undecided>,
}

/// What one prime says.
#[derive(Clone, PartialEq)]
struct Verdict {
    rank: usize,
    determined: Vec<bool>,
    functions: Vec<bool>,
    fix: Vec<usize>,
    orders: usize,
}

/// The span of the differentials at one point.
struct At<const C: u64> {
    /// Values of the variables.
    point: Vec<Residue<C>>,
    span: Echelon<Residue<C>>,
    gradients: Vec<Vec<Residue<C>>>,
    orders: usize,
    degree: f64,
}

impl Asked<'_> {
    /// The answers, by power series.
    ///
    /// # Errors
    /// [`Undecided`] if a function has no series, or there is too much to compute.
    pub(crate) fn sensitivity(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<Sensitivity, Undecided> {
        let states = self.fields.states.iter().filter(|s| !self.known.contains(s));
        let variables: Vec<Symbol> = states.chain(self.unknown).copied().collect();
        let program = SeriesProgram::compile(pool, self.fields, self.outputs, self.functions, &variables)?;
        let first = variables.len() - self.unknown.len();
        let moduli = [verdict::<1>, verdict::<SECOND_OFFSET>, verdict::<THIRD_OFFSET>];
        let mut found: Vec<Verdict> = Vec::new();
        let mut refused = None;
        let mut agreed = None;
        for modulo in moduli {
            match modulo(pool, &program, first, evidence) {
                Ok(v) => {
                    // A full rank is certain.
                    if v.rank == variables.len() || found.contains(&v) {
                        agreed = Some(v);
                        break;
                    }
                    found.push(v);
                }
                Err(Undecided::Exact(why)) if why.needs_other_prime() => refused = Some(why),
                Err(why) => return Err(why),
            }
        }
        let agreed = match (agreed, refused) {
            (Some(v), _) => v,
            // The other fields lack what is needed.
            (None, Some(_)) if found.len() + 1 == ENOUGH => found.remove(0),
            (None, Some(why)) => return Err(why.into()),
            (None, None) => return Err(bracketry_symbolic::Undecided::NoPoint.into()),
        };
        let directions = symmetries(pool, &program, &variables, &agreed);
        Ok(Sensitivity {
            rank: agreed.rank,
            determined: agreed.determined,
            functions: agreed.functions,
            fix: agreed.fix.iter().map(|&i| variables[i]).collect(),
            directions,
            variables,
        })
    }
}

/// The answers modulo one prime; the unknown parameters are the variables from `first` on.
fn verdict<const C: u64>(
    pool: &mut Pool,
    program: &SeriesProgram,
    first: usize,
    evidence: &mut Evidence,
) -> Result<Verdict, Undecided> {
    let At { point, mut span, gradients, orders, degree } = at::<C>(pool, program, SEED)?;
    let (n, rank) = (point.len(), span.rank());
    evidence.add_series(degree, rank, orders)?;
    let unit = |i: usize| unit_row(i, n);
    let determined = (0..n).map(|i| span.contains(&unit(i))).collect();
    let functions = gradients.iter().map(|g| span.contains(g)).collect();
    // Modulo the span the sets that determine all parameters are the bases of what the parameters' differentials
    // span: all have the same size, and the first independent ones are one.
    let fix = (first..n).filter(|&i| span.insert(unit(i))).collect();
    Ok(Verdict { rank, determined, functions, fix, orders })
}

/// The span at the point, and for the inputs, that follow from a seed.
fn at<const C: u64>(pool: &mut Pool, program: &SeriesProgram, seed: u64) -> Result<At<C>, Undecided> {
    let samples = pool.sample_in::<C>(&program.sampled, &Bindings::new(), 1, seed)?;
    if samples.ambiguous_signs > 0 {
        return Err(bracketry_symbolic::Undecided::Sign.into());
    }
    let values = samples.values.first().map(Vec::as_slice).unwrap_or_default();
    let mut series = Expansion::<C>::start(program, values, seed)?;
    let n = program.directions();
    let mut span = Echelon::empty(n);
    loop {
        if let Some(limit) = pool.reached_limit() {
            return Err(limit.into());
        }
        let mut fresh = false;
        for row in series.rows() {
            fresh |= span.insert(row);
        }
        if !fresh || span.rank() == n {
            break;
        }
        if !series.extend() || series.products > MAX_PRODUCTS {
            return Err(Undecided::TooMany { products: MAX_PRODUCTS });
        }
    }
    Ok(At {
        point: values[..n].to_vec(),
        span,
        gradients: series.gradients().map(<[_]>::to_vec).collect(),
        orders: series.orders(),
        degree: samples.degree,
    })
}

/// Independent fields Σ (c_j z_j + d_j) ∂_j with constants c_j and d_j along which no output changes.
///
/// The constants solve linear equations at every point; they are read off enough points modulo one prime, and checked
/// modulo another.
fn symmetries(
    pool: &mut Pool,
    program: &SeriesProgram,
    variables: &[Symbol],
    verdict: &Verdict,
) -> Result<Vec<Field>, Undecided> {
    let moving: Vec<usize> = (0..variables.len()).filter(|&i| !verdict.determined[i]).collect();
    let m = moving.len();
    if m == 0 || m > MAX_MOVING {
        return Ok(Vec::new());
    }
    let mut equations: Echelon<Residue<SECOND_OFFSET>> = Echelon::empty(2 * m);
    let (mut idle, mut last) = (0, None);
    for seed in 1..=MAX_POINTS {
        let here = at::<SECOND_OFFSET>(pool, program, SEED ^ seed)?;
        if here.span.rank() != verdict.rank {
            continue;
        }
        let mut fresh = false;
        for row in affine_rows(&here, &moving) {
            fresh |= equations.insert(row);
        }
        idle = if fresh { 0 } else { idle + 1 };
        last = Some(here);
        if idle == IDLE_POINTS || equations.rank() == 2 * m {
            break;
        }
    }
    let Some(last) = last.filter(|_| idle == IDLE_POINTS) else { return Ok(Vec::new()) };
    let rational = |v: Vec<Residue<SECOND_OFFSET>>| {
        let constants = v.iter().map(|c| c.to_rational(BOUND)).collect::<Option<Vec<Rational>>>()?;
        Some((v, constants))
    };
    let candidates: Vec<_> = equations.null_space().into_iter().filter_map(rational).collect();
    let holds = match hold::<1>(pool, program, &moving, &candidates) {
        // This field lacks a root that is needed.
        Err(Undecided::Exact(why)) if why.needs_other_prime() => {
            hold::<THIRD_OFFSET>(pool, program, &moving, &candidates)?
        }
        other => other?,
    };
    let mut independent = Echelon::empty(m);
    let mut fields = Vec::new();
    for ((v, constants), holds) in candidates.into_iter().zip(holds) {
        let here = (0..m).map(|j| v[j] * last.point[moving[j]] + v[m + j]).collect();
        if !holds || !independent.insert(here) {
            continue;
        }
        let mut field: Field = vec![pool.int(0); variables.len()];
        let scale = constants.iter().find(|c| **c != Rational::ZERO).cloned().unwrap_or(Rational::ONE);
        for (j, &i) in moving.iter().enumerate() {
            let (x, c, d) = (
                pool.sym(variables[i]),
                pool.rational(&constants[j] / &scale),
                pool.rational(&constants[m + j] / &scale),
            );
            let linear = pool.mul(c, x);
            field[i] = pool.add(linear, d);
        }
        fields.push(field);
    }
    Ok(fields)
}

/// The equations for (c, d) at a point: each row ω of the span gives Σ ω_j (c_j z_j + d_j) = 0.
fn affine_rows<const C: u64>(here: &At<C>, moving: &[usize]) -> Vec<Vec<Residue<C>>> {
    let scaled = |row: &Vec<Residue<C>>| moving.iter().map(|&i| row[i] * here.point[i]).collect::<Vec<_>>();
    here.span.rows.iter().map(|row| [scaled(row), moving.iter().map(|&i| row[i]).collect()].concat()).collect()
}

/// Whether the equations at another point, modulo another prime, hold for the constants of each candidate.
fn hold<const C: u64>(
    pool: &mut Pool,
    program: &SeriesProgram,
    moving: &[usize],
    candidates: &[(Vec<Residue<SECOND_OFFSET>>, Vec<Rational>)],
) -> Result<Vec<bool>, Undecided> {
    let here = at::<C>(pool, program, SEED ^ (MAX_POINTS + 1))?;
    Ok(candidates.iter().map(|(_, constants)| vanishes(&here, moving, constants)).collect())
}

/// Whether the equations at a point hold for these constants.
fn vanishes<const C: u64>(here: &At<C>, moving: &[usize], constants: &[Rational]) -> bool {
    let Some(v) = constants.iter().map(Residue::from_rational).collect::<Option<Vec<Residue<C>>>>() else {
        return false;
    };
    let product = |row: &Vec<Residue<C>>| row.iter().zip(&v).fold(Residue::ZERO, |s, (&x, &y)| s + x * y);
    affine_rows(here, moving).iter().all(|row| product(row).is_zero())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Reproducible numbers below `n`.
    fn random(state: &mut u64, n: u64) -> u64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 33) % n
    }

    /// A random function of the names, rational or with a function from `kernels`.
    fn function(state: &mut u64, names: &[&str], kernels: &[&str]) -> String {
        let mut pick = |list: &[&str]| list[random(state, list.len() as u64) as usize].to_owned();
        let term = format!("{}*{}", pick(names), pick(names));
        let kernel = pick(kernels).replace('@', &pick(names)).replace('#', &pick(names));
        format!("{} - {}*{kernel} + {term}", pick(names), pick(names))
    }

    const KERNELS: [&str; 9] =
        ["1", "@/(1 + #)", "@^3", "exp(@)", "sin(@ + #)", "sqrt(1 + @)", "log(2 + @)", "@^(1/3)", "1/(@^2 + #)"];

    /// The power series and the Lie derivatives of the outputs give the same answers for random systems.
    #[test]
    fn series_and_lie_derivatives_agree() {
        for case in 0..60 {
            let state = &mut (case * 7919 + 5);
            let mut pool = Pool::new();
            let all = ["x", "y", "z", "a", "b", "c"];
            let (n, m) = (1 + random(state, 3) as usize, random(state, 4) as usize);
            let names: Vec<&str> = all[..n].iter().chain(&all[3..3 + m]).copied().collect();
            let states: Vec<Symbol> = all[..n].iter().map(|s| pool.symbol(s)).collect();
            let unknown: Vec<Symbol> = all[3..3 + m].iter().map(|s| pool.symbol(s)).collect();
            let mut field = |state: &mut u64| -> Field {
                (0..n).map(|_| pool.parse(&function(state, &names, &KERNELS)).unwrap()).collect()
            };
            let drift = field(state);
            let controls: Vec<Field> = (0..random(state, 2)).map(|_| field(state)).collect();
            let asked = pool.parse(&function(state, &names, &KERNELS[..1])).unwrap();
            // Of a function of the states, and one that sees only their sum.
            let texts = [function(state, &names, &KERNELS[..3]), all[..n].join(" + "), all[0].to_owned()];
            let outputs = [pool.parse(&texts[case as usize % 3]).unwrap()];
            let fields = VectorFields::new(states, drift, controls, Bindings::new()).unwrap();
            let mut evidence = Evidence::default();
            let Ok(o) = fields.observability(&mut pool, &outputs, &unknown, &mut evidence) else { continue };
            let Ok(determined) = o.determined_variables(&mut pool, &mut evidence) else { continue };
            let fix = o.fix_to_determine(&mut pool, &unknown, &mut evidence).unwrap();
            let question =
                Asked { fields: &fields, outputs: &outputs, unknown: &unknown, known: &[], functions: &[asked] };
            let found = question.sensitivity(&mut pool, &mut evidence).unwrap();
            assert_eq!(found.rank, o.rank(), "case {case}");
            assert_eq!(found.determined, determined, "case {case}");
            assert_eq!(found.functions[0], o.determines(&mut pool, asked, &mut evidence).unwrap(), "case {case}");
            assert!(fix.is_none_or(|fix| fix == found.fix), "case {case}");
            for direction in found.directions.as_ref().unwrap() {
                for form in &o.codistribution {
                    let terms: Vec<Expr> = form.iter().zip(direction).map(|(&w, &x)| pool.mul(w, x)).collect();
                    let value = pool.sum(terms);
                    assert!(pool.zero_test(value, &Bindings::new()).is_zero(), "case {case}");
                }
            }
        }
    }
}
