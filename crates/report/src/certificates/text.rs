//! The text of certificates.

use bracketry_certify::{CertificateReason, Certification, CheckError, Claim, Conclusion, Conserved, Finding, Proof};
use bracketry_symbolic::Rational;
use bracketry_system::readable;

/// A reason as a sentence, with the next step where there is one.
pub(super) fn reason(why: &CertificateReason) -> String {
    match why {
        CertificateReason::InputDerivative { input } => {
            format!(
                "the equations use derivatives of the input {input}: make the model affine first (affinize), so that \
                 they become states"
            )
        }
        CertificateReason::InputDelay { input } => {
            format!("the input {input} acts with a delay, which certificates do not support")
        }
        CertificateReason::NotPolynomial { of } => format!(
            "the derivative of {of} is not a polynomial with rational coefficients and at most 300 terms: replace \
             other functions by Taylor polynomials, and state the approximation"
        ),
        CertificateReason::IrrationalPoint { name } => {
            format!(
                "{name} is not a rational number at the point: write it as a fraction, or shift the state in the model"
            )
        }
        CertificateReason::NotEquilibrium { state, derivative } => format!(
            "the point is not an equilibrium: {state}' = {} there; find one with trim and pass it to --at as exact \
             numbers",
            readable(*derivative)
        ),
        CertificateReason::Unstable { eigenvalues } => format!(
            "the equilibrium is unstable: the linearization has {eigenvalues} eigenvalue{} with positive real part (exact)",
            if *eigenvalues == 1 { "" } else { "s" }
        ),
        CertificateReason::Critical => {
            "the linearization has eigenvalues on the imaginary axis, so it has no quadratic Lyapunov function that gives a region"
                .to_owned()
        }
        CertificateReason::Excluded { degree } => format!(
            "no sum of squares of degree up to {degree} has the required form: the linear equations for its \
             coefficients have no solution (exact)"
        ),
        CertificateReason::NotFound { degree } => {
            format!("none found among sums of squares of degree up to {degree} (undecided)")
        }
        CertificateReason::NotConfirmed => "a numerical solution failed the exact check (undecided)".to_owned(),
        CertificateReason::TooLarge => {
            "too many monomials for the semidefinite program: use --degree 2 or a model with fewer states".to_owned()
        }
        CertificateReason::OutOfTime => "time or memory limit reached (undecided): raise --time-limit or --memory-limit".to_owned(),
        CertificateReason::NoPorts { inputs, outputs } => format!(
            "passivity needs as many outputs as inputs, at least one: the model has {inputs} inputs without feedback and {outputs} outputs"
        ),
        CertificateReason::NotAffine => {
            "the equations are not affine in the inputs: make the model affine first (affinize)".to_owned()
        }
        CertificateReason::OutputForm => "an output is not a polynomial of the states alone".to_owned(),
    }
}

fn number(q: &Rational) -> String {
    readable(q.to_f64().value())
}

fn conclusion(p: &Proof) -> &'static str {
    match p.conclusion {
        Conclusion::Conserved => "is constant along all motions",
        Conclusion::GloballyAsymptoticallyStable => match &p.certificate.claim {
            Claim::Lyapunov { decrease, .. } if !decrease.is_definite() => {
                "proved: globally asymptotically stable; V is positive definite and radially unbounded, V' <= 0, and no motion but \
                 rest stays where V' = 0 (LaSalle)"
            }
            _ => {
                "proved: globally asymptotically stable; V is positive definite and radially unbounded, V' negative definite"
            }
        },
        Conclusion::Stable => {
            "proved: stable, and all motions are bounded; V is positive definite and radially unbounded, V' <= 0"
        }
        Conclusion::RegionOfAttraction => {
            "proved: asymptotically stable, and every motion from this set tends to the point"
        }
        Conclusion::Passive => "proved: passive, S' <= u^T y with S >= 0",
        Conclusion::Lossless => "proved: passive and lossless, S' = u^T y with S >= 0",
    }
}

const REGION: &str = "region of attraction";

fn finding(heading: &str, symbol: &str, f: &Finding) -> Vec<String> {
    match f {
        Finding::NotProved(why) => vec![format!("  {heading}: {}", reason(why))],
        Finding::Proved(p) => {
            let mut lines = vec![format!("  {heading}: {}", conclusion(p)), format!("    {symbol} = {}", p.function)];
            match &p.level {
                Some(level) => lines.push(format!("    set {{V <= {}}}", number(level))),
                None if heading == REGION => lines.push("    the whole space".to_owned()),
                None => {}
            }
            lines
        }
    }
}

fn conserved(c: &Conserved) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    match c.complete_to {
        Some(0) => {
            lines.push("  conserved polynomials: too many coefficients even for degree 1 (undecided)".to_owned());
        }
        Some(d) if c.polynomials.is_empty() => {
            lines.push(format!("  conserved polynomials: none of degree up to {d} (linear equations, exact)"));
        }
        Some(d) => lines.push(format!(
            "  conserved polynomials: all others of degree up to {d} are polynomials of these (linear equations, exact)"
        )),
        None if c.others.is_empty() => lines.push("  conserved functions: none found (undecided)".to_owned()),
        None => lines.push("  conserved functions, found by the search for first integrals:".to_owned()),
    }
    lines.extend(c.polynomials.iter().map(|p| format!("    {}", p.function)));
    lines.extend(c.others.iter().map(|f| format!("    {f}")));
    lines
}

/// The findings in text.
pub fn certification_text(found: &Certification) -> String {
    let at: Vec<String> = found.point.iter().map(|(name, q)| format!("{name} = {}", number(q))).collect();
    let place = if at.is_empty() { String::new() } else { format!(" at {}", at.join(", ")) };
    let mut lines = vec![format!("{}: certificates{place}", found.model)];
    for input in &found.ignored_ranges {
        lines.push(format!(
            "  note: the feedback of {input} ignores the range of {input} in the model: the proofs hold where it \
             stays within the range"
        ));
    }
    if let Some(why) = &found.not_polynomial {
        lines.push(format!("  note: {}", reason(why)));
    }
    if let Some([left, axis, right]) = found.eigenvalues {
        lines.push(format!(
            "  eigenvalues of the linearization: {left} in the left half-plane, {axis} on the imaginary axis, {right} in the right \
             half-plane (exact)"
        ));
    }
    lines.extend(found.conserved.iter().flat_map(conserved));
    let findings = [
        ("Lyapunov function", "V", &found.lyapunov),
        (REGION, "V", &found.region),
        ("passivity", "S", &found.passivity),
    ];
    if found.not_polynomial.is_none() {
        for (heading, symbol, f) in findings {
            lines.extend(f.iter().flat_map(|f| finding(heading, symbol, f)));
        }
    }
    let any = found.conserved.iter().any(|c| !c.polynomials.is_empty())
        || findings.iter().any(|(_, _, f)| f.as_ref().is_some_and(|f| f.proof().is_some()));
    if any {
        lines.push("  all proofs were checked in rational arithmetic; --json gives the Gram matrices".to_owned());
    }
    lines.join("\n") + "\n"
}

/// The outcome of a check in text.
pub fn check_text(model: &str, outcome: &Result<Conclusion, CheckError>) -> String {
    match outcome {
        Ok(conclusion) => {
            let what = match conclusion {
                Conclusion::Conserved => "a conserved function",
                Conclusion::GloballyAsymptoticallyStable => "global asymptotic stability",
                Conclusion::Stable => "stability, with all motions bounded",
                Conclusion::RegionOfAttraction => "a region of attraction",
                Conclusion::Passive => "passivity",
                Conclusion::Lossless => "passivity without loss",
            };
            format!("{model}: the certificate proves {what} (checked in rational arithmetic)\n")
        }
        Err(CheckError::Model(why)) => format!("{model}: the certificate proves nothing here: {}\n", reason(why)),
        Err(CheckError::OtherModel) => {
            format!("{model}: the certificate is for other equations, another point, or another feedback\n")
        }
        Err(CheckError::Flaw(flaw)) => format!("{model}: the certificate proves nothing: {flaw}\n"),
    }
}
