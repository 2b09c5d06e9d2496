//! How many values parameters and initial states can have that give the same outputs.
//!
//! The outputs' Taylor coefficients at a random point, up to the first one of each output whose differential depends on
//! those before, generate a field that is closed under differentiation: the derivative of an algebraic relation gives the
//! next coefficient as a rational function of those before. So all other coefficients follow from them, and the values
//! that give the same outputs are the solutions of polynomial equations (Hong, Ovchinnikov, Pogudin, and Yap 2019 and
//! 2020, who bound the probability of error). The number of values of each variable is the number of distinct roots of
//! its minimal polynomial modulo the ideal, by a Gröbner basis modulo a prime. Variables that are not even locally
//! determined are given values as far as they are independent, which changes no number of values of the others.

use bracketry_symbolic::{Pool, Residue, SECOND_OFFSET, THIRD_OFFSET, Undecided as Exact};
use serde::Serialize;

use crate::observability::identifiability::groebner::{Basis, NoBasis, Work, distinct_roots};
use crate::observability::identifiability::jets::{NoEquations, equations};
use crate::observability::identifiability::local_identifiability::{Question, SEED, point};
use crate::residues::unit_row;
use crate::undecided::Undecided;

/// Products of terms that a basis may take.
const MAX_PRODUCTS: usize = 30_000_000;
/// Solutions that are counted.
const MAX_SOLUTIONS: usize = 300;

/// Why the number of values is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GlobalReason {
    /// The equations are no quotients of polynomials.
    NotRational,
    /// The polynomial equations are too large.
    TooLarge,
    /// The time limit, or the memory limit.
    Time,
    /// There are several solutions of the equations that were formed; more derivatives may exclude some, since inputs are
    /// unknown or initial values special.
    MoreDerivatives,
    /// Two primes do not agree, or a field lacks a number.
    Primes,
}

/// Numbers of values, by variable; none where it was given a value.
pub(crate) struct Solutions<const C: u64> {
    pub(crate) counts: Vec<Option<usize>>,
    /// Values at the point, and those of the other solution, where there are two in all.
    pub(crate) pair: Option<(Vec<Residue<C>>, Vec<Residue<C>>)>,
}

impl Question {
    pub(crate) fn solutions<const C: u64>(&self, pool: &mut Pool, seed: u64) -> Result<Solutions<C>, GlobalReason> {
        let here = point::<C>(pool, self, &self.special, seed).map_err(|why| match why {
            Undecided::Exact(Exact::Stopped | Exact::TimeLimit | Exact::MemoryLimit) => GlobalReason::Time,
            Undecided::Exact(why) if why.needs_other_prime() => GlobalReason::Primes,
            _ => GlobalReason::TooLarge,
        })?;
        let own = self.variables.len();
        let columns = self.program.directions();
        let mut span = self.with_known(&here.span);
        let mut given = vec![true; columns];
        for i in (0..own).rev() {
            let known = self.known.contains(&i);
            // Not determined, and independent of those before: any value will do.
            given[i] = known || (!span.contains(&unit_row(i, columns)) && span.insert(unit_row(i, columns)));
        }
        let system = equations(&self.program, &here.series, &given, &here.heights).map_err(|why| match why {
            NoEquations::NotRational => GlobalReason::NotRational,
            NoEquations::TooLarge => GlobalReason::TooLarge,
        })?;
        let late = {
            let pool = &*pool;
            move || pool.reached_limit().is_some()
        };
        let mut work = Work::new(MAX_PRODUCTS, &late);
        let no_basis = |why: NoBasis| match why {
            NoBasis::TooLarge => GlobalReason::TooLarge,
            NoBasis::Stopped => GlobalReason::Time,
        };
        let basis = Basis::of(system.polynomials, &mut work).map_err(no_basis)?;
        let standard = basis.standard_monomials(system.variables, MAX_SOLUTIONS).ok_or(GlobalReason::TooLarge)?;
        let mut counts = vec![None; own];
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for (i, p) in system.asked.iter().take(own).enumerate() {
            let value = here.values[i];
            first.push(value);
            let Some(p) = p else {
                second.push(value);
                continue;
            };
            let minimal = basis.minimal_polynomial(p, &standard, &mut work).map_err(no_basis)?;
            counts[i] = Some(distinct_roots(&minimal));
            second.push(if minimal.len() == 3 { -minimal[1] - value } else { value });
        }
        let pair = (standard.len() == 2).then_some((first, second));
        Ok(Solutions { counts, pair })
    }

    /// The numbers of values, on which two primes agree.
    pub(crate) fn counts(&self, pool: &mut Pool) -> Result<Vec<Option<usize>>, GlobalReason> {
        let a = self.solutions::<1>(pool, SEED).map(|s| s.counts);
        let a = match a {
            Err(GlobalReason::Primes) => self.solutions::<THIRD_OFFSET>(pool, SEED).map(|s| s.counts)?,
            other => other?,
        };
        let b = self.solutions::<SECOND_OFFSET>(pool, SEED ^ 2)?.counts;
        let same = a.iter().zip(&b).all(|(a, b)| a.is_some() == b.is_some() && a == b);
        if same { Ok(a) } else { Err(GlobalReason::Primes) }
    }
}
