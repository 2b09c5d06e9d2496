//! The searches of `certify`.

use std::time::{Duration, Instant};

use bracketry_symbolic::{Limit, Rational, StopFlag};
use bracketry_system::System;

use crate::certificate::{Certificate, Claim, Conclusion};
use crate::conserved::{conserved, first_integrals};
use crate::linearization::eigenvalues;
use crate::lyapunov::global;
use crate::model::{PolynomialModel, function};
use crate::passivity::storage;
use crate::reason::CertificateReason;
use crate::region::region;
use crate::report::{Certification, Conserved, Finding, Proof};

/// What is sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Find {
    /// Conserved functions.
    Conserved,
    /// A Lyapunov function on the whole space.
    Lyapunov,
    /// A region of attraction.
    Region,
    /// A storage function.
    Passivity,
}

/// Choices of [`certify`].
#[derive(Clone, Debug)]
pub struct CertifyOptions {
    /// What is sought.
    pub find: Vec<Find>,
    /// Largest degree of the functions: 2 or 4.
    pub degree: u32,
    /// Wall-clock time of all searches together; `None` for no limit.
    pub time_limit: Option<Duration>,
    /// Ends the searches early.
    pub stop: StopFlag,
}

impl Default for CertifyOptions {
    fn default() -> Self {
        CertifyOptions {
            find: vec![Find::Conserved, Find::Lyapunov, Find::Region, Find::Passivity],
            degree: 4,
            time_limit: Some(Duration::from_mins(2)),
            stop: StopFlag::default(),
        }
    }
}

/// A degree that functions cannot have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the degree is {degree}: use 2 or 4")]
pub struct DegreeError {
    /// As given.
    pub degree: u32,
}

/// Searches for conserved functions, Lyapunov functions, regions of attraction, and storage functions of a polynomial model at its
/// point. What is found is verified in exact arithmetic ([`Certificate::verify`]).
///
/// ```
/// use bracketry_certify::{Conclusion, CertifyOptions, certify};
/// use bracketry_system::System;
/// let text = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u - x - x^3 - v' }\noutputs = { y = 'v' }";
/// let found = certify(&System::parse("spring", text).unwrap(), &CertifyOptions::default()).unwrap();
/// let lyapunov = found.lyapunov.as_ref().and_then(|f| f.proof()).unwrap();
/// assert_eq!(lyapunov.conclusion, Conclusion::GloballyAsymptoticallyStable);
/// assert_eq!(lyapunov.certificate.verify(), Ok(lyapunov.conclusion));
/// ```
///
/// # Errors
/// [`DegreeError`] for another degree than 2 or 4.
pub fn certify(system: &System, options: &CertifyOptions) -> Result<Certification, DegreeError> {
    if ![2, 4].contains(&options.degree) {
        return Err(DegreeError { degree: options.degree });
    }
    let start = Instant::now();
    let limit = Limit::new(options.time_limit, &options.stop);
    let wanted = |f: Find| options.find.contains(&f);
    let mut found = Certification {
        model: system.name.clone(),
        point: Vec::new(),
        ignored_ranges: ignored_ranges(system),
        not_polynomial: None,
        eigenvalues: None,
        conserved: None,
        lyapunov: None,
        region: None,
        passivity: None,
        seconds: 0.0,
    };
    match PolynomialModel::new(system, &limit) {
        Ok(model) => {
            let names = model.states.iter().chain(&model.inputs).cloned();
            found.point = names.zip(model.point.iter().cloned()).collect();
            found.eigenvalues = Some(eigenvalues(&model));
            let finding = |result: Result<Certificate, CertificateReason>| finding(&model, result);
            if wanted(Find::Conserved) {
                let list = conserved(&model, options.degree, &limit);
                let polynomials = list.generators.into_iter().filter_map(|c| finding(Ok(c)).proof().cloned()).collect();
                found.conserved = Some(Conserved { polynomials, complete_to: Some(list.degree), others: Vec::new() });
            }
            if wanted(Find::Lyapunov) {
                found.lyapunov = Some(finding(global(&model, options.degree, &limit)));
            }
            if wanted(Find::Region) {
                let whole_space =
                    |f: &&Finding| f.proof().is_some_and(|p| p.conclusion == Conclusion::GloballyAsymptoticallyStable);
                let known = found.lyapunov.as_ref().filter(whole_space).cloned();
                let search = || finding(region(&model, options.degree, &limit));
                found.region = Some(known.unwrap_or_else(search));
            }
            if wanted(Find::Passivity) {
                found.passivity = Some(finding(storage(&model, options.degree, &limit)));
            }
        }
        Err(reason) => {
            if wanted(Find::Conserved) {
                let others = first_integrals(system, &limit);
                found.conserved = Some(Conserved { polynomials: Vec::new(), complete_to: None, others });
            }
            let missing = |f: Find| wanted(f).then(|| Finding::NotProved(reason.clone()));
            found.lyapunov = missing(Find::Lyapunov);
            found.region = missing(Find::Region);
            found.passivity = missing(Find::Passivity);
            found.not_polynomial = Some(reason);
        }
    }
    found.seconds = start.elapsed().as_secs_f64();
    Ok(found)
}

/// Inputs that a feedback sets and whose values have a range.
fn ignored_ranges(system: &System) -> Vec<String> {
    let closed = system.input_ranges.iter().filter(|r| !system.inputs.contains(&r.input));
    closed.map(|r| system.symbol_name(r.input).to_owned()).collect()
}

/// The exact check once more, on what is handed out.
fn finding(model: &PolynomialModel, result: Result<Certificate, CertificateReason>) -> Finding {
    let certificate = match result {
        Ok(certificate) => certificate,
        Err(reason) => return Finding::NotProved(reason),
    };
    let Ok(conclusion) = certificate.verify() else { return Finding::NotProved(CertificateReason::NotConfirmed) };
    let (p, level): (_, Option<Rational>) = match &certificate.claim {
        Claim::Conserved { function } | Claim::Lyapunov { function, .. } => (function, None),
        Claim::Region { function, level, .. } => (function, Some(level.clone())),
        Claim::Passive { storage, .. } => (storage, None),
    };
    let function = function(p, &model.states, &model.point);
    Finding::Proved(Box::new(Proof { certificate, conclusion, function, level }))
}
