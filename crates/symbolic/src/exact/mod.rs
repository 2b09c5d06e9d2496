//! Exact decisions: zero and rank modulo a prime at random points.

mod cases;
mod character;
mod circle;
mod combinations;
mod compose;
mod constant_sign;
mod constants;
mod derivative;
mod echelon;
mod evaluation;
mod explog;
mod field;
mod field_element;
mod gaussian;
mod interval;
mod inverse_angle;
mod kernels;
mod linear_relation;
mod lower;
mod lowering;
mod primes;
mod program;
mod real;
mod regular;
mod relation;
mod roots;
mod surd;

use std::fmt;

use dashu_ratio::RBig;
use rustc_hash::FxHashMap;
use serde::Serialize;

pub use self::echelon::Echelon;
pub use self::evaluation::Evaluation;
pub use self::field::{Fp, Residue, SECOND_OFFSET, THIRD_OFFSET};
pub use self::field_element::{FieldElement, OrderedField};
pub use self::real::Real;
pub use self::regular::Irregular;

use self::lower::{Lowered, lower};
use self::lowering::Stop;
use self::program::Fault;
use crate::node::{Expr, Symbol};
use crate::pool::Pool;
use crate::random::SplitMix64;
use crate::stop_flag::Reached;

/// Exact values for some symbols; all others are generic.
#[derive(Clone, Debug, Default)]
pub struct Bindings(FxHashMap<Symbol, RBig>);

impl Bindings {
    /// No symbol has a value.
    pub fn new() -> Self {
        Self::default()
    }

    /// Gives `s` a value, in place of any other.
    pub fn bind(&mut self, s: Symbol, value: RBig) {
        self.0.insert(s, value);
    }

    /// The value of `s`, if it has one.
    pub fn get(&self, s: Symbol) -> Option<&RBig> {
        self.0.get(&s)
    }
}

/// How sure a probabilistic statement is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certificate {
    /// Number of independent random points.
    pub points: u32,
    /// Decimal logarithm of a bound of the probability that the statement is false,
    /// (d/p)^points for a polynomial of degree d modulo p (Schwartz 1980, Zippel 1979).
    pub log10_error: f64,
}

impl Certificate {
    fn new(points: usize, degree: f64, signs: bool) -> Result<Self, Undecided> {
        let log10_degree = degree.max(1.0).log10();
        let each = log10_degree - (Fp::MODULUS as f64).log10();
        if each.is_nan() || each > -3.0 {
            return Err(Undecided::Degree { log10_degree });
        }
        // Which radicands are squares is read off 64 signs.
        let floor = if signs { -64.0 * 2.0_f64.log10() } else { f64::NEG_INFINITY };
        Ok(Self { points: points as u32, log10_error: (points as f64 * each).max(floor) })
    }

    /// Certificate of two statements together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let (hi, lo) = (self.log10_error.max(other.log10_error), self.log10_error.min(other.log10_error));
        let log10_error = if lo == f64::NEG_INFINITY { hi } else { hi + (1.0 + 10_f64.powf(lo - hi)).log10() };
        Self { points: self.points.min(other.points), log10_error }
    }
}

impl fmt::Display for Certificate {
    /// A power of ten above the error probability: `< 1e-15`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "< 1e{}", self.log10_error.ceil())
    }
}

/// Answer to "is this expression zero wherever it is defined?".
#[derive(Clone, Debug, PartialEq)]
pub enum ZeroTest {
    /// It is, up to the error probability.
    Zero(Certificate),
    /// It is not.
    NonZero,
    /// The test cannot tell.
    Unknown(Undecided),
}

impl ZeroTest {
    /// True for [`ZeroTest::Zero`].
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Zero(_))
    }

    /// True for [`ZeroTest::NonZero`].
    pub fn is_nonzero(&self) -> bool {
        matches!(self, Self::NonZero)
    }
}

/// Why a question stays open.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Undecided {
    /// A function that cannot be represented in the field together with the others.
    #[error("not decided because of `{text}`: {reason}")]
    Kernel {
        /// The sub-expression.
        text: String,
        /// The reason.
        reason: &'static str,
    },
    /// A denominator vanishes at every point tried.
    #[error("not decided because a denominator is zero")]
    DivisionByZero,
    /// A number that is missing in one field; the other one may have it.
    #[error("not decided because of `{text}`: {reason}")]
    OtherPrime {
        /// The sub-expression.
        text: String,
        /// What the field lacks.
        reason: &'static str,
    },
    /// The roots of the expression exist together at none of the points tried.
    #[error("not decided because no point was found at which all roots exist")]
    NoPoint,
    /// √(s²) is s or −s, and the answer depends on which.
    #[error("not decided because the answer depends on the sign of the root of a square")]
    Sign,
    /// The degree leaves too little certainty.
    #[error("not decided because the degree of the expression is too high (1e{log10_degree:.0})")]
    Degree {
        /// Decimal logarithm of the degree.
        log10_degree: f64,
    },
    /// The [flag](Pool::stop_flag) of the pool was raised.
    #[error("not decided because the work was stopped")]
    Stopped,
    /// The [deadline](Pool::set_deadline) of the pool has passed.
    #[error("not decided within the time limit")]
    TimeLimit,
    /// The flag of the pool tells that [memory runs out](crate::StopFlag::memory_runs_out).
    #[error("not decided within the memory limit")]
    MemoryLimit,
    /// Too many related functions.
    #[error("not decided because too many functions are related to each other")]
    TooComplex,
}

impl Pool {
    /// Why work in this pool is to end, if it is: its [flag](Self::stop_flag) was raised or tells that
    /// [memory runs out](crate::StopFlag::memory_runs_out), or its [deadline](Self::set_deadline) has passed.
    pub fn reached_limit(&self) -> Option<Undecided> {
        self.limit().reached().map(|reached| match reached {
            Reached::Flag => Undecided::Stopped,
            Reached::Memory => Undecided::MemoryLimit,
            Reached::Time => Undecided::TimeLimit,
        })
    }
}

impl Undecided {
    /// True if the same question may have an answer modulo [another prime](SECOND_OFFSET).
    pub fn needs_other_prime(&self) -> bool {
        matches!(self, Self::OtherPrime { .. } | Self::NoPoint)
    }
}

/// Generic rank of a matrix of expressions.
#[derive(Clone, Debug, PartialEq)]
pub struct Rank {
    /// The rank at almost every point.
    pub rank: usize,
    /// The rows that are independent of those before them, ascending: a maximal independent set.
    pub independent: Vec<usize>,
    /// The rank is at least this for certain, and at most this up to the error probability.
    pub certificate: Certificate,
}

/// Values of expressions at random points.
#[derive(Clone, Debug)]
pub struct Samples<const C: u64 = 1> {
    /// `values[point][expression]`
    pub values: Vec<Vec<Residue<C>>>,
    /// Bound of the degree of the numerators over a common denominator.
    pub degree: f64,
    /// Signs of roots of squares that were drawn at random.
    pub ambiguous_signs: u32,
    /// True if roots occur.
    roots: bool,
    /// Points that differ from each other: one if there is nothing random.
    distinct: usize,
    /// Exact values of constant expressions.
    exact: Vec<Option<RBig>>,
}

/// Seed of all tests; the same question always has the same answer.
const SEED: u64 = 0x6272_6163_6b65_7479;
/// Points of a test in which the sign of no root is open.
const POINTS: usize = 3;
/// Open signs beyond this number leave too many cases.
const MAX_AMBIGUOUS: u32 = 4;
/// Points per combination of open signs: each is met with probability 1 − e^−48.
const POINTS_PER_SIGN: usize = 48;
const TRIES: usize = 64;

impl Pool {
    /// Decides whether `e` is zero as a function of the symbols that `bindings` leave free.
    ///
    /// Works modulo the prime 2^61 − 1 at random points. What is not zero modulo one prime is not zero. What seems to
    /// be is looked at modulo 2^61 − 70094276963553 too, since coefficients may be multiples of a prime, and modulo
    /// 2^61 − 615950913 where one of these fields lacks a number or mistakes one for another. Sines, exponentials,
    /// logarithms and roots become algebraically independent generators after their
    /// rational-linear relations are found; independence of constants such as
    /// e, π and log 2 is taken for granted (Schanuel's conjecture).
    ///
    /// `abs`, `sign`, `min`, `max` and roots of squares are looked at case by case: the answer is that of all cases,
    /// or [`Undecided::Sign`] if they differ.
    pub fn zero_test(&mut self, e: Expr, bindings: &Bindings) -> ZeroTest {
        let direct = self.zero_directly(e, bindings);
        let ZeroTest::Unknown(why) = direct else { return direct };
        let Some(cases) = self.cases(&[e], bindings) else { return ZeroTest::Unknown(why) };
        let mut answers = cases.into_iter().map(|case| self.zero_directly(case[0], &Bindings::new()));
        let Some(mut total) = answers.next() else { return ZeroTest::Unknown(why) };
        for answer in answers {
            total = match (total, answer) {
                (ZeroTest::Zero(a), ZeroTest::Zero(b)) => ZeroTest::Zero(a.and(b)),
                (ZeroTest::NonZero, ZeroTest::NonZero) => ZeroTest::NonZero,
                (ZeroTest::Unknown(u), _) | (_, ZeroTest::Unknown(u)) => return ZeroTest::Unknown(u),
                _ => return ZeroTest::Unknown(Undecided::Sign),
            };
        }
        total
    }

    /// Rank of the matrix with the given rows, generic in the symbols that `bindings` leave free.
    ///
    /// Rows may differ in length; missing entries are zero.
    ///
    /// # Errors
    /// [`Undecided`] if an entry cannot be evaluated in the field or the answer depends on an open sign.
    pub fn rank(&mut self, rows: &[Vec<Expr>], bindings: &Bindings) -> Result<Rank, Undecided> {
        let why = match self.rank_directly(rows, bindings) {
            Err(why) => why,
            rank => return rank,
        };
        let Some(cases) = self.cases(&rows.concat(), bindings) else { return Err(why) };
        let mut total: Option<Rank> = None;
        for case in cases {
            let mut entries = case.into_iter();
            let rows: Vec<Vec<Expr>> = rows.iter().map(|r| entries.by_ref().take(r.len()).collect()).collect();
            let rank = self.rank_directly(&rows, &Bindings::new())?;
            total = Some(match total {
                None => rank,
                Some(t) if t.independent == rank.independent => {
                    Rank { certificate: t.certificate.and(rank.certificate), ..t }
                }
                Some(_) => return Err(Undecided::Sign),
            });
        }
        total.ok_or(why)
    }

    /// Values of `roots` modulo 2^61 − 1 at random points that depend on `seed` only.
    ///
    /// All expressions share each point, so relations between them hold between the values.
    ///
    /// # Errors
    /// [`Undecided`] if an expression cannot be evaluated in this field.
    pub fn sample(
        &mut self,
        roots: &[Expr],
        bindings: &Bindings,
        points: usize,
        seed: u64,
    ) -> Result<Samples, Undecided> {
        self.sample_in(roots, bindings, points, seed)
    }

    /// [`Pool::sample`] modulo the prime 2^61 − `C`: `sample_in::<1>` or, for expressions such as √3 that
    /// [need the other prime](Undecided::needs_other_prime), `sample_in::<SECOND_OFFSET>`.
    ///
    /// # Errors
    /// [`Undecided`] if an expression cannot be evaluated in this field.
    ///
    /// ```
    /// use bracketry_symbolic::{Bindings, Pool, SECOND_OFFSET};
    /// let mut p = Pool::new();
    /// let e = p.parse("sqrt(3)*x").unwrap();
    /// let missing = p.sample(&[e], &Bindings::new(), 1, 7).unwrap_err();
    /// assert!(missing.needs_other_prime());
    /// assert!(p.sample_in::<SECOND_OFFSET>(&[e], &Bindings::new(), 1, 7).is_ok());
    /// ```
    pub fn sample_in<const C: u64>(
        &mut self,
        roots: &[Expr],
        bindings: &Bindings,
        points: usize,
        seed: u64,
    ) -> Result<Samples<C>, Undecided> {
        Ok(self.sample_after(&[], roots, bindings, (points, seed), &[])?.0)
    }

    /// [`Pool::sample_in`], and, where there is a `first`, for every point its values and those of all generators, its own before all others;
    /// `start` gives those with which every point begins.
    fn sample_after<const C: u64>(
        &mut self,
        first: &[Expr],
        roots: &[Expr],
        bindings: &Bindings,
        (points, seed): (usize, u64),
        start: &[Residue<C>],
    ) -> Result<(Samples<C>, Vec<Generated<C>>), Undecided> {
        let why = match self.sampled_after::<C>(first, roots, bindings, (Some(points), seed), start) {
            Err(Stop::Undecided(why @ Undecided::Kernel { .. })) => why,
            other => return other.map_err(reason),
        };
        // Known angles such as atan(1), functions of their inverses, and nested roots of constants.
        let all = [first, roots].concat();
        let Some(bound) = self.with_values(&all, bindings) else { return Err(why) };
        let composed = self.composed(&bound);
        if composed == bound {
            return Err(why);
        }
        let (first, roots) = composed.split_at(first.len());
        self.sampled_after::<C>(first, roots, &Bindings::new(), (Some(points), seed), start).map_err(
            |stop| match stop {
                Stop::OtherPrime(other) => other,
                Stop::Restart | Stop::Undecided(_) => why,
            },
        )
    }

    fn sampled<const C: u64>(
        &self,
        roots: &[Expr],
        bindings: &Bindings,
        points: Option<usize>,
        seed: u64,
    ) -> Result<Samples<C>, Stop> {
        Ok(self.sampled_after(&[], roots, bindings, (points, seed), &[])?.0)
    }

    fn sampled_after<const C: u64>(
        &self,
        first: &[Expr],
        roots: &[Expr],
        bindings: &Bindings,
        (points, seed): (Option<usize>, u64),
        start: &[Residue<C>],
    ) -> Result<(Samples<C>, Vec<Generated<C>>), Stop> {
        if let Some(limit) = self.reached_limit() {
            return Err(limit.into());
        }
        let Lowered { program, first, outputs, exact, ambiguous, conditions, extension } =
            lower::<C>(self, first, roots, bindings)?;
        if ambiguous > MAX_AMBIGUOUS {
            return Err(Undecided::Sign.into());
        }
        let points = points.unwrap_or(if ambiguous > 0 { POINTS_PER_SIGN << ambiguous } else { POINTS });
        let mut rng = SplitMix64::new(seed);
        let mut registers = Vec::with_capacity(program.steps.len());
        let (mut values, mut generated) = (Vec::with_capacity(points), Vec::new());
        let mut tries = points.max(1) * (TRIES << conditions.min(12));
        let mut no_root = false;
        while values.len() < points {
            let point = program.point(start, &mut rng);
            match program.run(&point, &mut registers) {
                Ok(()) => {
                    values.push(outputs.iter().map(|&r| registers[r]).collect());
                    if !first.is_empty() {
                        generated.push((first.iter().map(|&r| registers[r]).collect(), point));
                    }
                }
                Err(fault) => {
                    no_root |= fault == Fault::NoRoot;
                    tries -= 1;
                    if tries == 0 {
                        return Err(if no_root {
                            Stop::OtherPrime(Undecided::NoPoint)
                        } else {
                            Undecided::DivisionByZero.into()
                        });
                    }
                }
            }
        }
        let samples = Samples {
            values,
            degree: program.common_degree(&outputs) * extension.max(1.0),
            ambiguous_signs: ambiguous,
            roots: conditions > 0,
            distinct: if program.generators.is_empty() { 1 } else { points.min(POINTS) },
            exact,
        };
        Ok((samples, generated))
    }
}

/// Values of some expressions at a point, and of all generators.
type Generated<const C: u64> = (Vec<Residue<C>>, Vec<Residue<C>>);

fn reason(stop: Stop) -> Undecided {
    match stop {
        Stop::Undecided(u) | Stop::OtherPrime(u) => u,
        Stop::Restart => Undecided::TooComplex,
    }
}
