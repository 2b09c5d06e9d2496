//! What all exact decisions of an analysis rest on, taken together.

use bracketry_symbolic::{Certificate, Samples, Undecided};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use crate::residues::{Fp, OFFSET};

/// The decisions of an analysis, with the probability that any of them is wrong.
///
/// Ranks are taken modulo a prime at random points. A rank found is never too large; the
/// bound is on the probability that one was found too small.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    decisions: usize,
    points: u32,
    error: f64,
    /// Products that eliminations took.
    products: f64,
    /// Products that searches for functions took.
    searched: f64,
}

/// Most products in all eliminations of an analysis together.
const MAX_PRODUCTS: f64 = 1e9;
/// Most products in all searches for functions of an analysis together.
const MAX_SEARCH: f64 = 5e8;

impl Evidence {
    /// Takes one more decision into account (union bound).
    pub fn add(&mut self, certificate: &Certificate) {
        self.points = if self.points == 0 { certificate.points } else { self.points.min(certificate.points) };
        self.add_error(certificate.log10_error);
    }

    fn add_error(&mut self, log10_error: f64) {
        self.decisions += 1;
        self.error += 10f64.powf(log10_error);
    }

    /// Allows for the elimination of a matrix at three points before it is made.
    ///
    /// # Errors
    /// [`crate::undecided::Undecided::TooMany`] where the products of all eliminations become too many.
    pub(crate) fn allow_elimination(&mut self, rows: usize, columns: usize) -> Result<(), crate::undecided::Undecided> {
        self.spend(3.0 * rows as f64 * rows.min(columns) as f64 * columns as f64)
    }

    /// Takes products of eliminations into account.
    ///
    /// # Errors
    /// As [`Evidence::allow_elimination`].
    pub(crate) fn spend(&mut self, products: f64) -> Result<(), crate::undecided::Undecided> {
        if self.products + products > MAX_PRODUCTS {
            return Err(crate::undecided::Undecided::TooMany { products: MAX_PRODUCTS });
        }
        self.products += products;
        Ok(())
    }

    /// Allows for a search among the combinations of `columns` functions, if there is room for it.
    pub(crate) fn allow_search(&mut self, columns: usize) -> bool {
        self.searched += (columns as f64).powi(3);
        self.searched <= MAX_SEARCH
    }

    /// Takes a decision on the rank of a matrix of sampled values into account.
    ///
    /// # Errors
    /// [`Undecided::Sign`] if the sampled expressions hold a root of a square, whose sign is open.
    pub(crate) fn add_rank(&mut self, samples: &Samples<OFFSET>, rank: usize) -> Result<(), Undecided> {
        if samples.ambiguous_signs > 0 {
            return Err(Undecided::Sign);
        }
        // A minor with one more row has this degree (Schwartz–Zippel).
        let degree = samples.degree.max(1.0) * (rank + 1) as f64;
        self.add_error(degree.log10() - (Fp::MODULUS as f64).log10());
        Ok(())
    }

    /// Takes a rank of vectors into account that are constant, or linear in a random point.
    pub(crate) fn add_linear_rank(&mut self, rank: usize) {
        self.add_error(((rank + 1) as f64).log10() - (Fp::MODULUS as f64).log10());
    }

    /// Takes the span of the outputs' derivatives of so many orders at one point into account, where rates and outputs
    /// have this degree.
    ///
    /// With a common denominator q of rates and outputs, derivative k times q^(2k+1) is a polynomial whose degree is
    /// 2k + 1 times theirs; a gradient takes one more.
    ///
    /// # Errors
    /// [`Undecided::Degree`] if the degree leaves too little certainty.
    pub(crate) fn add_series(&mut self, degree: f64, rank: usize, orders: usize) -> Result<(), Undecided> {
        let log10_degree = (degree.max(1.0) * (2 * orders + 2) as f64 * (rank + 1) as f64).log10();
        let log10_error = log10_degree - (Fp::MODULUS as f64).log10();
        if log10_error > -3.0 {
            return Err(Undecided::Degree { log10_degree });
        }
        self.add_error(log10_error);
        Ok(())
    }

    /// Takes into account that each of `count` vectors lies in the span of `rank` sampled ones if it does at
    /// all points.
    ///
    /// # Errors
    /// [`Undecided::Sign`] if the sampled expressions hold a root of a square, whose sign is open.
    pub(crate) fn add_memberships(
        &mut self,
        samples: &Samples<OFFSET>,
        rank: usize,
        count: usize,
    ) -> Result<(), Undecided> {
        if samples.ambiguous_signs > 0 {
            return Err(Undecided::Sign);
        }
        let degree = samples.degree.max(1.0) * (rank + 1) as f64;
        let each = degree.log10() - (Fp::MODULUS as f64).log10();
        self.add_error(samples.values.len() as f64 * each + (count as f64).log10());
        Ok(())
    }

    /// Takes the comparison of all of `count` sampled expressions with each other into account.
    ///
    /// # Errors
    /// [`Undecided::Sign`] if the sampled expressions hold a root of a square, whose sign is open.
    pub(crate) fn add_equalities(&mut self, samples: &Samples<OFFSET>, count: usize) -> Result<(), Undecided> {
        if samples.ambiguous_signs > 0 {
            return Err(Undecided::Sign);
        }
        let points = samples.values.len();
        let each = samples.degree.max(1.0).log10() - (Fp::MODULUS as f64).log10();
        let pairs = 2.0 * (count as f64).log10();
        self.add_error(points as f64 * each + pairs);
        Ok(())
    }

    /// Number of decisions.
    pub fn decisions(&self) -> usize {
        self.decisions
    }

    /// Random points of the generic decision that used the fewest.
    pub fn points(&self) -> u32 {
        self.points
    }

    /// Decimal logarithm of the bound on the probability that any decision is wrong.
    pub fn log10_error(&self) -> f64 {
        self.error.log10()
    }

    /// The bound as text, rounded up to a power of ten: `< 1e-15`.
    pub fn error_text(&self) -> String {
        if self.decisions == 0 {
            return "0".to_owned();
        }
        // Errors below the smallest normal number vanish in the sum.
        let exponent = self.error.max(f64::MIN_POSITIVE).log10().floor() + 1.0;
        format!("< 1e{exponent}")
    }
}

impl Serialize for Evidence {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let decided = self.decisions > 0;
        let mut s = serializer.serialize_struct("Evidence", 3 + usize::from(decided))?;
        s.serialize_field("prime", "2^61-1")?;
        // Of values at a point and of what the first lacks the roots for.
        s.serialize_field("second_prime", &format!("2^61-{OFFSET}"))?;
        s.serialize_field("points", &self.points)?;
        if decided {
            s.serialize_field("error_probability", &self.error_text())?;
        } else {
            s.skip_field("error_probability")?;
        }
        s.end()
    }
}
