//! Where the equations of a simulation break down: the state, the part of its equation that has no value, what to do.

use std::fmt;

use bracketry_sim::{Model, StopReason, Switched};
use bracketry_symbolic::{Expr, Func, Node, Symbol, Tape};
use bracketry_system::{System, readable};

/// What the equations do where a simulation stopped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Breakdown {
    /// The rate of a state has no finite value there, or right after it.
    NoValue {
        /// The state.
        state: String,
        /// The part of its equation that has none, and why, as a clause; absent where it was not found.
        part: Option<String>,
    },
    /// The input has no finite value there, or right after it.
    NoInput {
        /// The input.
        input: String,
    },
    /// The state whose rate outgrows all others.
    Runaway {
        /// The state.
        state: String,
        /// Its rate, as it is printed.
        rate: String,
    },
}

impl fmt::Display for Breakdown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoValue { state, part: None } => write!(f, "the rate of `{state}` is not finite there"),
            Self::NoValue { state, part: Some(part) } => write!(f, "in the equation of `{state}`, {part}"),
            Self::NoInput { input } => write!(
                f,
                "the input `{input}` has no finite value there or right after; give it one at all times of the simulation"
            ),
            Self::Runaway { state, rate } => write!(
                f,
                "`{state}` runs away there, its rate is {rate}: it grows without bound in finite time, or divides by what comes near 0; \
                 check its equation and the values of its parameters"
            ),
        }
    }
}

/// Part of the time at which a motion is followed beyond its end, at first and at last.
const BEYOND: [f64; 2] = [1e-14, 1e-3];
/// A rate that would change a state of this size within a second is no ordinary one.
const RUNAWAY: f64 = 1e6;
/// Longest expression that is shown.
const SHOWN: usize = 80;

impl Breakdown {
    /// What happens at `t` in state `x`, where a simulation of `model`, compiled from `system`, stopped for `reason`; it looks a
    /// little beyond, in the direction of the motion, where everything is finite still.
    pub(crate) fn find(system: &System, model: &Model, reason: &StopReason, t: f64, x: &[f64]) -> Option<Self> {
        if !matches!(reason, StopReason::NonFinite | StopReason::StepTooSmall) {
            return None;
        }
        let mut model = model.clone();
        let rate = rates(&mut model, t, x);
        let finite = rate.iter().all(|v| v.is_finite());
        let mut step = if finite { BEYOND[0] } else { 0.0 };
        let size = t.abs().max(1e-3);
        loop {
            let at = t + step * size;
            let there: Vec<f64> =
                x.iter().zip(&rate).map(|(x, v)| if step > 0.0 { x + step * size * v } else { *x }).collect();
            let inputs = model.input_values(at);
            if let Some(k) = inputs.iter().position(|v| !v.is_finite()) {
                return Some(Self::NoInput { input: system.input_names()[k].clone() });
            }
            if let Some(i) = rates(&mut model, at, &there).iter().position(|v| !v.is_finite()) {
                let part = part_without_value(system, i, &there, &inputs);
                return Some(Self::NoValue { state: system.state_names()[i].clone(), part });
            }
            step *= 10.0;
            if step == 0.0 || step > BEYOND[1] {
                break;
            }
        }
        let relative = |i: &usize| rate[*i].abs() / (1.0 + x[*i].abs());
        let fastest = (0..rate.len()).max_by(|a, b| relative(a).total_cmp(&relative(b)))?;
        let state = system.state_names()[fastest].clone();
        (relative(&fastest) > RUNAWAY).then(|| Self::Runaway { state, rate: readable(rate[fastest]) })
    }
}

/// The rates of the states, with every sign at 0.
fn rates(model: &mut Model, t: f64, x: &[f64]) -> Vec<f64> {
    let mut rate = vec![0.0; model.dim()];
    model.enter_segment(t);
    let signs = vec![0.0; model.arguments()];
    model.rhs(t, x, &signs, &mut rate);
    rate
}

/// The innermost part of the equation of a state that has no finite value though its operands have one, as a clause; `None` where
/// derivatives of inputs stand in the equations, or the equation is finite by itself.
fn part_without_value(system: &System, state: usize, x: &[f64], inputs: &[f64]) -> Option<String> {
    if !system.input_derivatives.is_empty() {
        return None;
    }
    let pool = &system.pool;
    let root = system.dynamics[state];
    let parts = pool.reachable(&[root]);
    let parameters = system.parameters.iter();
    let symbols: Vec<Symbol> = system.arguments().into_iter().chain(parameters.clone().map(|p| p.symbol)).collect();
    let values = x.iter().chain(inputs).copied().chain(parameters.map(|p| p.value.to_f64().value()));
    let values: Vec<f64> = values.collect();
    let tape = Tape::compile(pool, &symbols, &parts).ok()?;
    let mut results = vec![0.0; parts.len()];
    tape.eval(&values, &mut Vec::new(), &mut results);
    let value = |e: Expr| parts.binary_search(&e).map_or(f64::NAN, |k| results[k]);
    let mut part = root;
    if value(part).is_finite() {
        return None;
    }
    while let Some(inner) = pool.node(part).operands().find(|e| !value(*e).is_finite()) {
        part = inner;
    }
    let shown = |text: String| if text.chars().count() > SHOWN { None } else { Some(text) };
    let text = shown(pool.text(part))?;
    let of = |e: Expr| -> Option<(String, f64)> { Some((shown(pool.text(e))?, value(e))) };
    let beyond = "keep the motion where it has one, or write the equation so that it holds beyond";
    let clause = match pool.node(part) {
        Node::Pow(base, exponent) => {
            let (base, b) = of(base)?;
            if b == 0.0 {
                format!(
                    "`{base}` stands in a denominator and is 0; begin elsewhere, or write the equation so that it holds there"
                )
            } else if b < 0.0 && value(exponent).fract() != 0.0 {
                format!("`{text}` has no value where `{base}` is below 0; {beyond}, as with max({base}, 0)")
            } else {
                format!("`{text}` grows beyond all numbers")
            }
        }
        Node::Call(Func::Log, argument) => {
            let (argument, _) = of(argument)?;
            format!("`{text}` has no value where `{argument}` is 0 or below; {beyond}")
        }
        Node::Call(Func::Asin | Func::Acos, argument) => {
            let (argument, _) = of(argument)?;
            format!("`{text}` has no value where `{argument}` is beyond -1 to 1; {beyond}")
        }
        _ => format!("`{text}` grows beyond all numbers"),
    };
    Some(clause)
}
