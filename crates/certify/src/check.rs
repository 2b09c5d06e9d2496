//! A certificate from elsewhere against a model.

use bracketry_symbolic::Limit;
use bracketry_system::System;

use crate::certificate::{Certificate, Claim, Conclusion, Flaw};
use crate::model::PolynomialModel;
use crate::reason::CertificateReason;

/// Why a certificate proves nothing of a model.
#[derive(Clone, Debug, PartialEq)]
pub enum CheckError {
    /// The model has no polynomial form at its point.
    Model(CertificateReason),
    /// The certificate is about other equations.
    OtherModel,
    /// The certificate proves nothing.
    Flaw(Flaw),
}

/// What a certificate proves of a model at its point: the equations must be the same, and [`Certificate::verify`] pass.
///
/// # Errors
/// [`CheckError`]: why it proves nothing.
pub fn check(system: &System, certificate: &Certificate) -> Result<Conclusion, CheckError> {
    let model = PolynomialModel::new(system, &Limit::default()).map_err(CheckError::Model)?;
    let mut same = certificate.states == model.states && certificate.field == model.drift;
    if let Claim::Passive { input_fields, outputs, .. } = &certificate.claim {
        same &= model.input_fields.as_ref() == Some(input_fields) && model.outputs.as_ref() == Some(outputs);
    }
    if !same {
        return Err(CheckError::OtherModel);
    }
    certificate.verify().map_err(CheckError::Flaw)
}
