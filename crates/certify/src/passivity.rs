//! Storage functions of passive systems.

use bracketry_lie::MultivariatePolynomial;

use crate::certificate::{Certificate, Claim};
use crate::linearization::negative;
use crate::lyapunov::{sum_of_squares, unknown};
use crate::model::{PolynomialModel, rate};
use crate::monomials::monomials;
use crate::reason::Reason;
use crate::semidefinite::Limit;
use crate::sum_of_squares::program::{AffinePolynomial, Program};

/// A storage function of degree at most `largest` for the inputs and outputs in their order: S ≥ 0, ∇S·f ≤ 0, ∇S·g = h (Hill and
/// Moylan, IEEE Trans. Autom. Control 21 (1976) 708–711).
pub(crate) fn storage(model: &PolynomialModel, largest: u32, limit: &Limit) -> Result<Certificate, Reason> {
    let (m, p) = (model.inputs.len(), model.output_names.len());
    if m == 0 || m != p {
        return Err(Reason::NoPorts { inputs: m, outputs: p });
    }
    let fields = model.input_fields.as_ref().ok_or(Reason::NotAffine)?;
    let outputs = model.outputs.as_ref().ok_or(Reason::OutputForm)?;
    let n = model.dimension();
    let mut reason = Reason::NotFound { degree: largest };
    for d in (2..=largest).step_by(2) {
        let template = monomials(n, 2..=d);
        let s = unknown(&template);
        let zero = fields
            .iter()
            .zip(outputs)
            .map(|(g, h)| AffinePolynomial { constant: negative(h), ..s.mapped(|v| rate(v, g)) })
            .collect();
        let fall = s.mapped(|v| negative(&model.rate(v)));
        let constraints = vec![sum_of_squares(n, s.clone()), sum_of_squares(n, fall)];
        let program = Program { unknowns: template.len(), constraints, zero };
        let exact = match program.certified(&vec![0; n], limit) {
            Ok(exact) => exact,
            Err(why) => {
                reason = Reason::of(why, d);
                continue;
            }
        };
        let function: MultivariatePolynomial = s.at(&exact.unknowns);
        let mut grams = exact.grams.into_iter();
        let (Some(positive), Some(dissipation)) = (grams.next(), grams.next()) else { continue };
        let claim = Claim::Passive {
            input_fields: fields.clone(),
            outputs: outputs.clone(),
            storage: function,
            positive,
            dissipation,
        };
        let certificate = Certificate { states: model.states.clone(), field: model.drift.clone(), claim };
        if certificate.verify().is_ok() {
            return Ok(certificate);
        }
        reason = Reason::NotConfirmed;
    }
    Err(reason)
}
