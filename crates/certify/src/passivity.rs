//! Storage functions of passive systems.

use bracketry_lie::linear::MultivariatePolynomial;
use bracketry_symbolic::Limit;

use crate::certificate::{Certificate, Claim};
use crate::gram::Gram;
use crate::linearization::negative;
use crate::lyapunov::{MAX_SUBSETS_OF, is_inside, proper_subsets, sum_of_squares, unknown};
use crate::model::{PolynomialModel, rate};
use crate::monomials::monomials;
use crate::reason::CertificateReason;
use crate::sum_of_squares::program::{AffinePolynomial, MAX_UNKNOWNS, Program, Unsolved};

/// A storage function of degree at most `largest` for the inputs and outputs in their order: S ≥ 0, ∇S·f ≤ 0, ∇S·g = h (Hill and
/// Moylan 1976).
pub(crate) fn storage(model: &PolynomialModel, largest: u32, limit: &Limit) -> Result<Certificate, CertificateReason> {
    let (m, p) = (model.inputs.len(), model.output_names.len());
    if m == 0 || m != p {
        return Err(CertificateReason::NoPorts { inputs: m, outputs: p });
    }
    let fields = model.input_fields.as_ref().ok_or(CertificateReason::NotAffine)?;
    let outputs = model.outputs.as_ref().ok_or(CertificateReason::OutputForm)?;
    let search = Search { model, fields, outputs, limit };
    let n = model.dimension();
    let mut reason = CertificateReason::NotFound { degree: largest };
    for d in (2..=largest).step_by(2) {
        let mut decided = None;
        // All states first; where the rate vanishes with some of them, its Gram matrix in all has no margin.
        let restricted = if n <= MAX_SUBSETS_OF { proper_subsets(n) } else { Vec::new() };
        for subset in [u32::MAX].into_iter().chain(restricted) {
            match search.with(d, subset) {
                Ok(certificate) => return Ok(certificate),
                Err(why) => {
                    decided.get_or_insert(why);
                }
            }
            // Where the outputs have no integral at all, no rate helps.
            if decided == Some(Unsolved::Contradiction) || limit.is_reached() {
                break;
            }
        }
        reason = decided.map_or(reason, |why| CertificateReason::of(why, d));
    }
    Err(reason)
}

struct Search<'a> {
    model: &'a PolynomialModel,
    fields: &'a [Vec<MultivariatePolynomial>],
    outputs: &'a [MultivariatePolynomial],
    limit: &'a Limit,
}

impl Search<'_> {
    /// S of degree d whose rate is minus a sum of squares in the states of the subset.
    fn with(&self, d: u32, subset: u32) -> Result<Certificate, Unsolved> {
        let n = self.model.dimension();
        let template = monomials(n, 2..=d).filter(|t| t.len() <= MAX_UNKNOWNS).ok_or(Unsolved::TooLarge)?;
        let s = unknown(&template);
        let equations = self.fields.iter().zip(self.outputs);
        let zero =
            equations.map(|(g, h)| AffinePolynomial { constant: negative(h), ..s.mapped(|v| rate(v, g)) }).collect();
        let mut fall = sum_of_squares(n, s.mapped(|v| negative(&self.model.rate(v))))?;
        fall.basis.retain(|m| is_inside(m, subset));
        let constraints = vec![sum_of_squares(n, s.clone())?, fall];
        let program = Program { unknowns: template.len(), constraints, zero };
        let exact = program.certified(&vec![0; n], self.limit)?;
        let [positive, dissipation]: [Gram; 2] = exact.grams.try_into().map_err(|_| Unsolved::NotRounded)?;
        let claim = Claim::Passive {
            input_fields: self.fields.to_vec(),
            outputs: self.outputs.to_vec(),
            storage: s.at(&exact.unknowns),
            positive,
            dissipation,
        };
        let certificate = Certificate { states: self.model.states.clone(), field: self.model.drift.clone(), claim };
        certificate.verify().map(|_| certificate).map_err(|_| Unsolved::NotRounded)
    }
}
