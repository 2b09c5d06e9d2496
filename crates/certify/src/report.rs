//! What `certify` finds.

use bracketry_symbolic::{Function, Rational};

use crate::certificate::{Certificate, Conclusion};
use crate::reason::CertificateReason;

/// A certificate that was verified exactly, with its functions in the names of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// All that shows it.
    pub certificate: Certificate,
    /// What it proves.
    pub conclusion: Conclusion,
    /// The Lyapunov, storage, or conserved function, in the states themselves.
    pub function: Function,
    /// The level c of a region {V ≤ c}.
    pub level: Option<Rational>,
}

/// What became of one search.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// Proved.
    Proved(Box<Proof>),
    /// Not proved, for this reason; only [`CertificateReason::Unstable`] is a proof of the contrary.
    NotProved(CertificateReason),
}

impl Finding {
    /// The proof, if there is one.
    pub fn proof(&self) -> Option<&Proof> {
        match self {
            Finding::Proved(p) => Some(p),
            Finding::NotProved(_) => None,
        }
    }
}

/// Conserved functions.
#[derive(Clone, Debug, PartialEq)]
pub struct Conserved {
    /// Polynomials, of which all other conserved ones up to [`Conserved::complete_to`] are polynomials; verified exactly.
    pub polynomials: Vec<Proof>,
    /// The degree up to which the list is complete, exactly; none for a model that is not polynomial.
    pub complete_to: Option<u32>,
    /// For a model that is not polynomial: functions that the search for first integrals found, verified by exact zero tests.
    pub others: Vec<Function>,
}

/// The findings; those not asked for are absent.
#[derive(Clone, Debug, PartialEq)]
pub struct Certification {
    /// Name of the model.
    pub model: String,
    /// The equilibrium: states, then inputs that no feedback sets.
    pub point: Vec<(String, Rational)>,
    /// Inputs with a feedback whose ranges are not respected: what is proved holds where the feedback stays within them.
    pub ignored_ranges: Vec<String>,
    /// Why the model has no polynomial form; then only conserved functions are sought.
    pub not_polynomial: Option<CertificateReason>,
    /// Eigenvalues of the linearization with negative, zero, and positive real part, exactly.
    pub eigenvalues: Option<[usize; 3]>,
    /// Functions that are constant along all motions.
    pub conserved: Option<Conserved>,
    /// A Lyapunov function on the whole space.
    pub lyapunov: Option<Finding>,
    /// A region of attraction.
    pub region: Option<Finding>,
    /// A storage function.
    pub passivity: Option<Finding>,
    /// Seconds.
    pub seconds: f64,
}

impl Certification {
    /// Whether every search that was asked for found something.
    pub fn is_proved(&self) -> bool {
        let proved = |f: &Option<Finding>| f.as_ref().is_none_or(|f| f.proof().is_some());
        let conserved = self
            .conserved
            .as_ref()
            .is_none_or(|c| c.complete_to.is_some_and(|d| d > 0) || !c.polynomials.is_empty() || !c.others.is_empty());
        // Outside of a region where the whole space is attracted nothing is left to be found.
        proved(&self.lyapunov) && proved(&self.region) && proved(&self.passivity) && conserved
    }
}
