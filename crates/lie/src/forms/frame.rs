//! What every form starts from: the smooth system with its fields, and a point that selects branches.

use bracketry_symbolic::{Bindings, Expr, Symbol, Tape, ZeroTest};
use bracketry_system::System;

use crate::algebra::field::VectorFields;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::forms::obstacle::{Obstacle, Stop, of_error};
use crate::modes::mode_fields;
use crate::undecided::Undecided;

/// A smooth system that is affine in its inputs.
#[derive(Clone)]
pub(crate) struct Frame {
    /// The system; everything is made in its pool.
    pub(crate) system: System,
    pub(crate) fields: VectorFields,
    /// The outputs that the form is about, by number.
    pub(crate) outputs: Vec<usize>,
    pub(crate) evidence: Evidence,
}

/// Where a base point is sought around the model's point: steps that are in no simple relation.
const STEPS: [f64; 7] = [0.137, 0.0911, 0.1731, 0.0613, 0.1193, 0.1571, 0.0787];

impl Frame {
    /// The fields of `system`, which must be affine in its inputs and have one mode.
    pub(crate) fn new(mut system: System, outputs: Vec<usize>) -> Result<Result<Self, Stop>, Error> {
        let modes = match mode_fields(&mut system) {
            Ok(modes) => modes,
            Err(error) => return of_error(error).map(Err),
        };
        if modes.len() > 1 {
            return Ok(Err(Stop::Unknown(Obstacle::Switches { modes: modes.len() })));
        }
        let Some(mode) = modes.into_iter().next() else {
            return Ok(Err(Stop::Unknown(Obstacle::Switches { modes: 0 })));
        };
        Ok(Ok(Frame { system, fields: mode.fields, outputs, evidence: Evidence::default() }))
    }

    /// The inputs as expressions.
    pub(crate) fn inputs(&mut self) -> Vec<Expr> {
        let inputs = self.system.inputs.clone();
        inputs.into_iter().map(|u| self.system.pool.sym(u)).collect()
    }

    /// The functions of the outputs that the form is about.
    pub(crate) fn output_functions(&self) -> Vec<Expr> {
        self.outputs.iter().map(|&k| self.system.outputs[k].1).collect()
    }

    /// Their names.
    pub(crate) fn output_names(&self) -> Vec<String> {
        self.outputs.iter().map(|&k| self.system.outputs[k].0.clone()).collect()
    }

    /// A feedback acts at once.
    pub(crate) fn without_delays(&self) -> Result<(), Stop> {
        match self.system.input_delays.first() {
            None => Ok(()),
            Some(d) => {
                let input = self.system.symbol_name(d.input).to_owned();
                Err(Stop::Unknown(Obstacle::Delay { input }))
            }
        }
    }

    /// Symbols that the system does not use: prefix1, prefix2, …, with underscores where it has such names.
    pub(crate) fn fresh(&mut self, prefix: &str, count: usize) -> Vec<Symbol> {
        let mut roots = self.system.dynamics.clone();
        roots.extend(self.system.outputs.iter().map(|o| o.1));
        let pool = &mut self.system.pool;
        let mut used = pool.symbols_of(&roots);
        used.extend(self.system.states.iter().chain(&self.system.inputs));
        used.extend(self.system.parameters.iter().map(|p| p.symbol));
        let mut prefix = prefix.to_owned();
        while (1..=count).any(|i| pool.find_symbol(&format!("{prefix}{i}")).is_some_and(|s| used.contains(&s))) {
            prefix.push('_');
        }
        (1..=count).map(|i| pool.symbol(&format!("{prefix}{i}"))).collect()
    }

    /// Whether a function is zero for all parameters (`Some(true)`), or for the given ones (`Some(false)`); `None` if it is
    /// not zero.
    pub(crate) fn is_zero(&mut self, e: Expr) -> Result<Option<bool>, Undecided> {
        let pool = &mut self.system.pool;
        if pool.is_zero(e) {
            return Ok(Some(true));
        }
        if let ZeroTest::Zero(certificate) = pool.zero_test(e, &Bindings::new()) {
            self.evidence.add(&certificate);
            return Ok(Some(true));
        }
        Ok(self.fields.vanishes(pool, e, &mut self.evidence)?.then_some(false))
    }

    /// The values of expressions of states at a point, parameters at their values.
    pub(crate) fn numbers(&self, expressions: &[Expr], arguments: &[Symbol], at: &[f64]) -> Option<Vec<f64>> {
        let tape: Tape = self.system.compile(arguments, expressions).ok()?;
        let mut out = vec![f64::NAN; expressions.len()];
        tape.eval(at, &mut Vec::new(), &mut out);
        Some(out)
    }

    /// Values of the states near the model's point (near 0 without one) at which all of `expressions` are finite, away from
    /// what may be singular at the point itself.
    pub(crate) fn base(&self, expressions: &[Expr]) -> Option<Vec<f64>> {
        let n = self.system.states.len();
        let given = self.system.point_values().map(|p| p.0);
        let center = given.clone().unwrap_or_else(|| vec![0.0; n]);
        // Close to a given point first, so that the branch is that of the point.
        let scales: &[f64] = if given.is_some() { &[0.02, -0.02, 0.3, -0.3, 3.0] } else { &[1.0, -1.0, 5.0, 0.2] };
        scales.iter().find_map(|scale| {
            let at: Vec<f64> = (0..n)
                .map(|i| center[i] + scale * STEPS[i % STEPS.len()] * (1.0 + 0.31 * (i / STEPS.len()) as f64))
                .collect();
            let values = self.numbers(expressions, &self.system.states, &at)?;
            values.iter().all(|v| v.is_finite()).then_some(at)
        })
    }
}
