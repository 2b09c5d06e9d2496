//! Global Lyapunov functions.

use bracketry_lie::linear::MultivariatePolynomial;
use bracketry_symbolic::{Limit, Rational};

use crate::certificate::{Certificate, Claim, Conclusion};
use crate::linearization::{eigenvalues, lengths, lyapunov_of, negative};
use crate::model::PolynomialModel;
use crate::monomials::{Monomial, degree, monomials};
use crate::reason::CertificateReason;
use crate::sum_of_squares::program::{AffinePolynomial, Constraint, MAX_UNKNOWNS, Margin, Program, Unsolved};

/// The monomials that V is sought of: quadratic, with products of squares, all; as far as a program may have that many unknowns.
fn templates(n: usize, largest: u32) -> Vec<Vec<Monomial>> {
    let mut list = vec![monomials(n, 2..=2)];
    for d in (4..=largest).step_by(2) {
        let all = monomials(n, 2..=d);
        let even = |m: &Monomial| degree(m) == 2 || m.iter().all(|k| k % 2 == 0);
        list.push(all.clone().map(|all| all.into_iter().filter(even).collect()));
        list.push(all);
    }
    list.into_iter().flatten().filter(|template| template.len() <= MAX_UNKNOWNS).collect()
}

/// V with unknown coefficients.
pub(crate) fn unknown(template: &[Monomial]) -> AffinePolynomial {
    let term = |m: &Monomial| MultivariatePolynomial::term(Rational::ONE, m.clone());
    AffinePolynomial { constant: MultivariatePolynomial::default(), linear: template.iter().map(term).collect() }
}

/// Largest degree among the parts.
pub(crate) fn largest_degree(p: &AffinePolynomial) -> u32 {
    p.linear.iter().chain([&p.constant]).map(MultivariatePolynomial::degree).max().unwrap_or(0)
}

/// The sum-of-squares constraint on p, which vanishes at the origin.
///
/// # Errors
/// [`Unsolved::TooLarge`].
pub(crate) fn sum_of_squares(n: usize, p: AffinePolynomial) -> Result<Constraint, Unsolved> {
    let basis = monomials(n, 1..=largest_degree(&p).div_ceil(2)).ok_or(Unsolved::TooLarge)?;
    Ok(Constraint { polynomial: p, basis, margin: Margin::Largest })
}

/// Most states for which V' is sought that vanishes with some of them.
pub(crate) const MAX_SUBSETS_OF: usize = 4;

/// A Lyapunov function of degree at most `largest` on the whole space.
pub(crate) fn global(model: &PolynomialModel, largest: u32, limit: &Limit) -> Result<Certificate, CertificateReason> {
    let [_, on_axis, right] = eigenvalues(model);
    if right > 0 {
        return Err(CertificateReason::Unstable { eigenvalues: right });
    }
    let n = model.dimension();
    let powers = lyapunov_of(model).map_or_else(|| vec![0; n], |p| lengths(&p, 1.0));
    let search = Search { model, powers, limit };
    let mut reason = CertificateReason::TooLarge;
    let mut stable = None;
    for template in templates(n, largest) {
        match search.with(&template, |_| true) {
            Ok((certificate, Conclusion::GloballyAsymptoticallyStable)) => return Ok(certificate),
            Ok((certificate, _)) => stable = stable.or(Some(certificate)),
            Err(Unsolved::OutOfTime) => return stable.ok_or(CertificateReason::OutOfTime),
            Err(why) => {
                // The last word is that of the richest template that could be decided.
                if why != Unsolved::TooLarge {
                    reason = CertificateReason::of(why, largest);
                }
            }
        }
    }
    // A rate that vanishes with some states shows stability only; a stable linearization is better served by a region.
    if stable.is_none() && n <= MAX_SUBSETS_OF && (on_axis > 0 || model.degree() > 1) {
        stable = search.semidefinite(largest);
    }
    stable.ok_or(reason)
}

struct Search<'a> {
    model: &'a PolynomialModel,
    powers: Vec<i32>,
    limit: &'a Limit,
}

impl Search<'_> {
    /// V of the template whose rate is minus a sum of squares of polynomials in the monomials that `allowed` keeps.
    fn with(
        &self,
        template: &[Monomial],
        allowed: impl Fn(&Monomial) -> bool,
    ) -> Result<(Certificate, Conclusion), Unsolved> {
        let n = self.model.dimension();
        let v = unknown(template);
        let fall = v.mapped(|p| negative(&self.model.rate(p)));
        let mut decrease = sum_of_squares(n, fall)?;
        decrease.basis.retain(allowed);
        // V and its rate may be multiplied by any number.
        let positive = Constraint { margin: Margin::One, ..sum_of_squares(n, v.clone())? };
        let constraints = vec![positive, decrease];
        let program = Program { unknowns: template.len(), constraints, zero: Vec::new() };
        let exact = program.certified(&self.powers, self.limit)?;
        let function = v.at(&exact.unknowns);
        let mut grams = exact.grams.into_iter();
        let (Some(positive), Some(decrease)) = (grams.next(), grams.next()) else { return Err(Unsolved::NotRounded) };
        let claim = Claim::Lyapunov { function, positive, decrease };
        let certificate = Certificate { states: self.model.states.clone(), field: self.model.drift.clone(), claim };
        match certificate.verify() {
            Ok(conclusion) => Ok((certificate, conclusion)),
            Err(_) => Err(Unsolved::NotRounded),
        }
    }

    /// V whose rate vanishes where some of the states do, as few as possible.
    fn semidefinite(&self, largest: u32) -> Option<Certificate> {
        let n = self.model.dimension();
        for template in templates(n, largest) {
            for subset in proper_subsets(n) {
                if self.limit.is_reached() {
                    return None;
                }
                let inside = |m: &Monomial| is_inside(m, subset);
                if let Ok((certificate, _)) = self.with(&template, inside) {
                    return Some(certificate);
                }
            }
        }
        None
    }
}

/// Sets of variables other than that of all, as bits, the largest first.
pub(crate) fn proper_subsets(n: usize) -> Vec<u32> {
    let mut subsets: Vec<u32> = (0..(1u32 << n) - 1).collect();
    subsets.sort_by_key(|s| std::cmp::Reverse(s.count_ones()));
    subsets
}

/// Whether a monomial has variables of the set only.
pub(crate) fn is_inside(m: &[u32], subset: u32) -> bool {
    m.iter().enumerate().all(|(i, &k)| k == 0 || i >= 32 || subset >> i & 1 == 1)
}
