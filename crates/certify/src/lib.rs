//! Certificates for polynomial systems: conserved functions, Lyapunov functions, regions of attraction, and storage functions.
//!
//! Functions are sought by semidefinite programming, in floating point. What is reported was then proved: the Gram matrices are
//! rounded to rational numbers, projected onto the equations that they have to satisfy, and checked in exact arithmetic
//! ([`Certificate::verify`]), which needs the certificate only.

mod certificate;
mod certify;
mod check;
mod conserved;
mod gram;
mod levels;
mod linearization;
mod lyapunov;
mod model;
mod monomials;
mod passivity;
mod portrait;
mod reason;
mod region;
mod report;
mod rest;
mod semidefinite;
mod series;
mod sum_of_squares;

pub use certificate::{Certificate, Claim, Conclusion, Flaw};
pub use certify::{CertifyOptions, DegreeError, Find, certify};
pub use check::{CheckError, check};
pub use gram::Gram;
pub use model::{FeedbackError, with_feedback};
pub use portrait::{Portrait, PortraitError, portrait};
pub use reason::CertificateReason;
pub use report::{Certification, Conserved, Finding, Proof};
