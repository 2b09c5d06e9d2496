//! Where the equations of a simulation break down: the state, the part of its equation that has no value, what to do.

use crate::Switched;
use crate::algebraic_root::NoRoot;
use crate::model::Model;
use crate::outcome::StopReason;
use bracketry_symbolic::{Expr, Func, Node, Symbol, Tape};
use bracketry_system::System;

/// What the equations do where a simulation stopped.
#[derive(Clone, Debug, PartialEq)]
pub enum Breakdown {
    /// The rate of a state has no finite value there, or right after it.
    NoValue {
        /// Index of the state.
        state: usize,
        /// The part of its equation that has none; absent where it was not found.
        part: Option<UndefinedPart>,
    },
    /// The input has no finite value there, or right after it.
    NoInput {
        /// Index of the input.
        input: usize,
    },
    /// The algebraic equations have no solution there, or right after it, on the branch of the motion.
    NoRoot(NoRoot),
    /// The rate of the state outgrows all others.
    Runaway {
        /// Index of the state.
        state: usize,
        /// Its rate, in its unit per second.
        rate: f64,
    },
}

/// A part of an equation, in the pool of its system, that has no finite value though its operands have one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UndefinedPart {
    /// The part.
    pub expression: Expr,
    /// Why.
    pub why: Undefined,
}

/// Why an expression has no finite value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Undefined {
    /// The denominator is 0.
    Denominator(Expr),
    /// The base of a power with a broken exponent is below 0.
    Base(Expr),
    /// The argument of a logarithm is 0 or below.
    Logarithm(Expr),
    /// The argument of an arc sine or arc cosine is beyond −1 to 1.
    Arc(Expr),
    /// It grows beyond all numbers.
    Overflow,
}

/// Part of the time at which a motion is followed beyond its end, at first and at last.
const BEYOND: [f64; 2] = [1e-14, 1e-3];
/// A rate that would change a state of this size within a second is no ordinary one.
const RUNAWAY: f64 = 1e6;

impl Breakdown {
    /// What happens at `t` in state `x`, where a simulation of `model`, compiled from `system`, stopped for `reason`; it looks a
    /// little beyond, in the direction of the motion, where everything is finite still.
    pub fn find(system: &System, model: &Model, reason: &StopReason, t: f64, x: &[f64]) -> Option<Self> {
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
                return Some(Self::NoInput { input: k });
            }
            if let Some(i) = rates(&mut model, at, &there).iter().position(|v| !v.is_finite()) {
                let part = part_without_value(system, i, &there, &inputs);
                return Some(Self::NoValue { state: i, part });
            }
            step *= 10.0;
            if step == 0.0 || step > BEYOND[1] {
                break;
            }
        }
        let relative = |i: &usize| rate[*i].abs() / (1.0 + x[*i].abs());
        let state = (0..rate.len()).max_by(|a, b| relative(a).total_cmp(&relative(b)))?;
        (relative(&state) > RUNAWAY).then(|| Self::Runaway { state, rate: rate[state] })
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

/// The innermost part of the equation of a state that has no finite value though its operands have one; `None` where derivatives of
/// inputs stand in the equations, or the equation is finite by itself.
fn part_without_value(system: &System, state: usize, x: &[f64], inputs: &[f64]) -> Option<UndefinedPart> {
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
    let why = match pool.node(part) {
        Node::Pow(base, _) if value(base) == 0.0 => Undefined::Denominator(base),
        Node::Pow(base, exponent) if value(base) < 0.0 && value(exponent).fract() != 0.0 => Undefined::Base(base),
        Node::Call(Func::Log, argument) => Undefined::Logarithm(argument),
        Node::Call(Func::Asin | Func::Acos, argument) => Undefined::Arc(argument),
        _ => Undefined::Overflow,
    };
    Some(UndefinedPart { expression: part, why })
}
