//! The text of certificates.

use bracketry_certify::{Certification, CheckError, Conclusion, Conserved, Finding, Proof, Reason};
use bracketry_symbolic::Rational;
use bracketry_system::readable;

/// A reason as a sentence, with the next step where there is one.
pub(super) fn reason(why: &Reason) -> String {
    match why {
        Reason::InputDerivative { input } => {
            format!(
                "the equations use derivatives of the input {input}: make the model affine first (affinize), which makes states of them"
            )
        }
        Reason::InputDelay { input } => format!("the input {input} acts with a delay, which certificates do not treat"),
        Reason::NotPolynomial { of } => format!(
            "the derivative of {of} is no polynomial with rational coefficients, or one of more than 300 terms: replace other functions by Taylor polynomials, and say so"
        ),
        Reason::IrrationalPoint { name } => {
            format!(
                "{name} is no rational number at the point: write it as a fraction, or shift the state in the model"
            )
        }
        Reason::NotEquilibrium { state, derivative } => format!(
            "the point is no equilibrium: {state}' = {} there; trim finds one, and --at takes it as exact numbers",
            readable(*derivative)
        ),
        Reason::Unstable { eigenvalues } => format!(
            "the equilibrium is unstable: the linearization has {eigenvalues} eigenvalue{} with positive real part (exact)",
            if *eigenvalues == 1 { "" } else { "s" }
        ),
        Reason::Critical => {
            "the linearization has eigenvalues on the imaginary axis, so that no quadratic form of it shows a region"
                .to_owned()
        }
        Reason::Excluded { degree } => format!(
            "no sum of squares of degree up to {degree} has the form sought: linear equations of its coefficients have no solution (exact)"
        ),
        Reason::NotFound { degree } => {
            format!(
                "not found among sums of squares of degree up to {degree}: unknown, this is no proof that there is none"
            )
        }
        Reason::NotConfirmed => "a numerical solution did not pass the exact check: unknown".to_owned(),
        Reason::TooLarge => {
            "too many monomials for the semidefinite program: try --degree 2, or fewer states".to_owned()
        }
        Reason::OutOfTime => "out of time: unknown; give a longer --time-limit".to_owned(),
        Reason::NoPorts { inputs, outputs } => format!(
            "passivity needs as many outputs as inputs, at least one: the model has {inputs} inputs without feedback and {outputs} outputs"
        ),
        Reason::NotAffine => "the equations are not affine in the inputs: affinize makes them so".to_owned(),
        Reason::OutputForm => "an output is no polynomial of the states alone".to_owned(),
    }
}

fn number(q: &Rational) -> String {
    readable(q.to_f64().value())
}

fn conclusion(p: &Proof) -> &'static str {
    match p.conclusion {
        Conclusion::Conserved => "is constant along all motions",
        Conclusion::GloballyAsymptoticallyStable => {
            "proved: globally asymptotically stable; V is positive definite and radially unbounded, V' negative definite"
        }
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
        Some(0) => lines.push("  conserved polynomials: too many coefficients even for degree 1: unknown".to_owned()),
        Some(d) if c.polynomials.is_empty() => {
            lines.push(format!("  conserved polynomials: none of degree up to {d} (linear equations, exact)"));
        }
        Some(d) => lines.push(format!(
            "  conserved polynomials: all others of degree up to {d} are polynomials of these (linear equations, exact)"
        )),
        None if c.others.is_empty() => lines.push("  conserved functions: none found: unknown".to_owned()),
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
            "  note: the feedback of {input} is taken without the range that the model gives {input}: what is proved holds where it stays within"
        ));
    }
    if let Some(why) = &found.not_polynomial {
        lines.push(format!("  note: {}", reason(why)));
    }
    if let Some([left, axis, right]) = found.eigenvalues {
        lines.push(format!(
            "  eigenvalues of the linearization: {left} left, {axis} on the axis, {right} right (exact)"
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
        lines.push("  what is proved was checked in rational arithmetic; --json gives the Gram matrices".to_owned());
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
            format!("{model}: the certificate is about other equations, another point, or another feedback\n")
        }
        Err(CheckError::Flaw(flaw)) => format!("{model}: the certificate proves nothing: {flaw}\n"),
    }
}
