//! Why a simulation stopped, as sentences.

use bracketry_sim::{Breakdown, NoRoot, NoRootReason, Outcome, ScenarioRun, Undefined, UndefinedPart};
use bracketry_symbolic::Expr;
use bracketry_system::{System, readable};

/// Longest expression that is shown.
const SHOWN: usize = 80;

/// Where and why a run of `system` stopped before its end; none if it reached it.
pub fn stop(system: &System, run: &ScenarioRun) -> Option<String> {
    let Outcome::Stopped { reason, t, .. } = &run.simulation.outcome else { return None };
    let why = run.breakdown.as_ref().map_or_else(|| reason.to_string(), |b| breakdown(system, b));
    Some(format!("stopped at t = {}: {why}", system.quantities.time_unit.text(readable(*t))))
}

/// What the equations of `system` do where a simulation stopped, and what to do about it.
pub fn breakdown(system: &System, breakdown: &Breakdown) -> String {
    match breakdown {
        Breakdown::NoValue { state, part } => {
            let state = system.symbol_name(system.states[*state]);
            match part.and_then(|part| clause(system, part)) {
                None => format!("the rate of `{state}` is not finite there"),
                Some(part) => format!("in the equation of `{state}`, {part}"),
            }
        }
        Breakdown::NoInput { input } => format!(
            "the input `{}` has no finite value there or right after; define it for the whole simulation",
            system.symbol_name(system.inputs[*input])
        ),
        Breakdown::NoRoot(failure) => {
            format!("the algebraic equations could not be solved there: {}", no_root(system, failure))
        }
        Breakdown::Runaway { state, rate } => format!(
            "`{}` diverges there, its rate is {}: it grows without bound in finite time, or its equation divides by \
             a value near 0; check its equation and parameter values",
            system.symbol_name(system.states[*state]),
            readable(*rate)
        ),
    }
}

/// Why algebraic equations have no solution, and what to do about it.
fn no_root(system: &System, failure: &NoRoot) -> String {
    let name = system.algebraic.get(failure.equation).map_or("?", |z| system.symbol_name(z.symbol));
    let (why, remedy) = match failure.why {
        NoRootReason::NotConverging => (
            "Newton's method does not converge",
            "give a `guess` near the solution at the start, or keep the motion where a solution exists",
        ),
        NoRootReason::Singular => (
            "their derivatives with respect to the algebraic variables are singular (index above 1) or not finite",
            "start elsewhere, or keep the motion where they are regular",
        ),
        NoRootReason::OtherBranch => {
            ("the branch of solutions on which the motion started ends in a fold", "keep the motion before the fold")
        }
    };
    format!("{why}; the residual of the equation of `{name}` is {}; {remedy}", readable(failure.residual))
}

/// A part without value, as a clause; none if it is too long to be shown.
fn clause(system: &System, part: UndefinedPart) -> Option<String> {
    let shown = |e: Expr| Some(system.pool.text(e)).filter(|text| text.chars().count() <= SHOWN);
    let text = shown(part.expression)?;
    let remedy = "keep the motion in its domain, or write the equation so that it is defined beyond it";
    Some(match part.why {
        Undefined::Denominator(base) => format!(
            "the denominator `{}` is 0; start elsewhere, or write the equation so that it is defined there",
            shown(base)?
        ),
        Undefined::Base(base) => {
            let base = shown(base)?;
            format!("`{text}` has no value where `{base}` is below 0; {remedy}, as with max({base}, 0)")
        }
        Undefined::Logarithm(argument) => {
            format!("`{text}` has no value where `{}` is 0 or below; {remedy}", shown(argument)?)
        }
        Undefined::Arc(argument) => {
            format!("`{text}` has no value where `{}` is outside -1 to 1; {remedy}", shown(argument)?)
        }
        Undefined::Overflow => format!("`{text}` overflows"),
    })
}
