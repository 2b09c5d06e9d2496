//! Verdicts from several primes: a coefficient may be a multiple of one of them.
//!
//! What differs from zero modulo a prime does so in truth, and a rank modulo a prime is never too large. The opposite
//! verdicts, "zero" and "smaller rank", are therefore confirmed modulo a second prime. Where a field lacks a root, or
//! mistakes a constant for another number, the next one is asked.

use dashu_ratio::RBig;

use super::echelon::Echelon;
use super::field::{Residue, SECOND_OFFSET, THIRD_OFFSET};
use super::lowering::Stop;
use super::{Bindings, Certificate, POINTS, Rank, SEED, Undecided, ZeroTest, reason};
use crate::node::Expr;
use crate::pool::Pool;

/// Number of primes that have to agree.
const ENOUGH: usize = 2;

/// What one prime says about a function.
enum Vanishing {
    /// Known exactly.
    Exactly,
    /// It vanishes at all points.
    Here(Certificate),
    /// It does not vanish.
    Not,
}

/// What one prime says about a matrix.
struct Prefixes {
    /// Rank of the rows 0 … i.
    ranks: Vec<usize>,
    /// Bound of the degree of the entries over a common denominator.
    degree: f64,
    distinct: usize,
    roots: bool,
}

/// True if another prime may decide what this one could not.
fn may_pass(stop: &Stop) -> bool {
    matches!(stop, Stop::OtherPrime(_) | Stop::Undecided(Undecided::DivisionByZero))
}

impl Pool {
    /// [`Pool::zero_test`] without cases.
    pub(super) fn zero_directly(&self, e: Expr, bindings: &Bindings) -> ZeroTest {
        let moduli = [Self::vanishing::<1>, Self::vanishing::<SECOND_OFFSET>, Self::vanishing::<THIRD_OFFSET>];
        let (mut found, mut refused): (Vec<Certificate>, Option<Stop>) = (Vec::new(), None);
        let mut contradicted = None;
        for vanishing in moduli {
            match vanishing(self, e, bindings) {
                Ok(Vanishing::Exactly) => {
                    return Certificate::new(POINTS, 1.0, false).map_or_else(ZeroTest::Unknown, ZeroTest::Zero);
                }
                Ok(Vanishing::Not) => return ZeroTest::NonZero,
                Ok(Vanishing::Here(certificate)) => found.push(certificate),
                Err(stop) if may_pass(&stop) => refused = Some(stop),
                Err(stop) if found.is_empty() => return ZeroTest::Unknown(reason(stop)),
                Err(stop) => contradicted = Some(stop),
            }
            if found.len() == ENOUGH {
                return ZeroTest::Zero(found[0]);
            }
        }
        match (found.first(), contradicted, refused) {
            // The other fields lack what is needed.
            (Some(&certificate), None, _) => ZeroTest::Zero(certificate),
            (_, Some(stop), _) | (None, None, Some(stop)) => ZeroTest::Unknown(reason(stop)),
            (None, None, None) => ZeroTest::Unknown(Undecided::NoPoint),
        }
    }

    fn vanishing<const C: u64>(&self, e: Expr, bindings: &Bindings) -> Result<Vanishing, Stop> {
        let s = self.sampled::<C>(&[e], bindings, None, SEED)?;
        if let Some(v) = &s.exact[0] {
            return Ok(if *v == RBig::ZERO { Vanishing::Exactly } else { Vanishing::Not });
        }
        match s.values.iter().filter(|v| v[0].is_zero()).count() {
            0 => Ok(Vanishing::Not),
            n if n == s.values.len() => Ok(Vanishing::Here(Certificate::new(s.distinct, s.degree, s.roots)?)),
            _ if s.ambiguous_signs > 0 => Err(Undecided::Sign.into()),
            _ => Ok(Vanishing::Not),
        }
    }

    /// [`Pool::rank`] without cases.
    pub(super) fn rank_directly(&self, rows: &[Vec<Expr>], bindings: &Bindings) -> Result<Rank, Undecided> {
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let moduli = [Self::prefixes::<1>, Self::prefixes::<SECOND_OFFSET>, Self::prefixes::<THIRD_OFFSET>];
        let (mut found, mut refused): (Vec<Prefixes>, Option<Stop>) = (Vec::new(), None);
        for prefixes in moduli {
            match prefixes(self, rows, bindings) {
                Ok(p) => found.push(p),
                Err(stop) if may_pass(&stop) => {
                    refused = Some(stop);
                    continue;
                }
                Err(stop) => return Err(reason(stop)),
            }
            // A rank modulo a prime is never too large: one that reaches every bound is right.
            if found.len() == 1 && found[0].ranks.iter().enumerate().all(|(i, &r)| r == columns.min(i + 1)) {
                break;
            }
            if found.len() == ENOUGH && found[0].ranks == found[1].ranks {
                break;
            }
        }
        let dominates = |p: &&Prefixes| found.iter().all(|q| p.ranks.iter().zip(&q.ranks).all(|(a, b)| a >= b));
        match (found.iter().find(dominates), refused) {
            (Some(best), _) => best.rank(columns),
            (None, Some(stop)) if found.is_empty() => Err(reason(stop)),
            (None, _) => Err(Undecided::NoPoint),
        }
    }

    fn prefixes<const C: u64>(&self, rows: &[Vec<Expr>], bindings: &Bindings) -> Result<Prefixes, Stop> {
        let flat: Vec<Expr> = rows.iter().flatten().copied().collect();
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let s = self.sampled::<C>(&flat, bindings, None, SEED)?;
        // The generic rank is the largest of those at the points.
        let mut ranks = vec![0; rows.len()];
        for (k, values) in s.values.iter().enumerate() {
            let mut at = 0;
            let matrix: Vec<Vec<Residue<C>>> = rows
                .iter()
                .map(|r| {
                    at += r.len();
                    values[at - r.len()..at].to_vec()
                })
                .collect();
            let e = Echelon::new(&matrix, columns);
            for (i, p) in ranks.iter_mut().enumerate() {
                let here = e.independent.partition_point(|&j| j <= i);
                if s.ambiguous_signs > 0 && k > 0 && here != *p {
                    return Err(Undecided::Sign.into());
                }
                *p = here.max(*p);
            }
        }
        Ok(Prefixes { ranks, degree: s.degree, distinct: s.distinct, roots: s.roots })
    }
}

impl Prefixes {
    fn rank(&self, columns: usize) -> Result<Rank, Undecided> {
        let before = std::iter::once(&0).chain(&self.ranks);
        let independent: Vec<usize> =
            self.ranks.iter().zip(before).enumerate().filter(|(_, (r, b))| r > b).map(|(i, _)| i).collect();
        let rank = independent.len();
        // A minor that is one larger has this degree.
        let degree = self.degree * (rank + 1).min(columns.min(self.ranks.len())).max(1) as f64;
        Ok(Rank { rank, independent, certificate: Certificate::new(self.distinct, degree, self.roots)? })
    }
}
