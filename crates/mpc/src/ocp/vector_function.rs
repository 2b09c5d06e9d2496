//! Vector functions of states, inputs, time and references.

use super::cost_names::{CostKind, CostNames, CostPoint};
use crate::error::{MpcError, check_length};
use bracketry_native::{Backend, Function, Workspace};
use bracketry_symbolic::{Expr, Pool, Symbol, Tape};
use bracketry_system::System;

/// A vector function g(x, u, t, r) of states, inputs, time and references, compiled with its exact Jacobian ∂g/∂(x, u).
#[derive(Clone)]
pub struct VectorFunction {
    states: usize,
    variables: usize,
    references: usize,
    outputs: usize,
    value: Function,
    derivatives: Function,
    pattern: Vec<(usize, usize)>,
    /// Second derivatives of the only component with their places (i ≤ j); by the interpreter, since few problems ask for them.
    second: Option<(Vec<(usize, usize)>, Function)>,
    arguments: Vec<f64>,
    work: Workspace,
    out: Vec<f64>,
}

impl VectorFunction {
    /// Reads one expression per component over the names of a system, the time `t` and references.
    ///
    /// ```
    /// use bracketry_mpc::ocp::VectorFunction;
    /// use bracketry_system::System;
    /// let system = System::parse("point.toml", r#"
    ///     states = ["p", "v"]
    ///     inputs = ["a"]
    ///     dynamics = { p = "v", v = "a" }
    /// "#).unwrap();
    /// let mut g = VectorFunction::parse(&system, &[], &["p + v^2", "a"]).unwrap();
    /// assert_eq!(g.values(&[1.0, 2.0], &[3.0], 0.0, &[]), [5.0, 3.0]);
    /// assert!(g.uses_inputs());
    /// ```
    ///
    /// # Errors
    /// A syntax error, or a name that is not known.
    pub fn parse(system: &System, references: &[&str], texts: &[&str]) -> Result<Self, MpcError> {
        let references: Vec<String> = references.iter().map(|s| (*s).to_owned()).collect();
        let (mut names, mut pool) = CostNames::new(system, CostKind::Stage, &references);
        let functions = texts.iter().map(|text| pool.parse_with(text, &mut names)).collect::<Result<Vec<Expr>, _>>()?;
        let time = pool.symbol("t");
        let references: Vec<Symbol> = references.iter().map(|r| pool.symbol(r)).collect();
        Self::compile(&mut pool, time, &system.states, &system.inputs, &references, &functions)
    }

    /// Compiles `functions` as functions of time, states, inputs and references.
    ///
    /// # Errors
    /// [`MpcError::Compile`] if an expression uses another name.
    pub fn compile(
        pool: &mut Pool,
        time: Symbol,
        states: &[Symbol],
        inputs: &[Symbol],
        references: &[Symbol],
        functions: &[Expr],
    ) -> Result<Self, MpcError> {
        let variables: Vec<Symbol> = states.iter().chain(inputs).copied().collect();
        let mut all = variables.clone();
        all.push(time);
        all.extend(references);
        let mut outputs = functions.to_vec();
        let mut pattern = Vec::new();
        for (i, &g) in functions.iter().enumerate() {
            for (j, &v) in variables.iter().enumerate() {
                let d = pool.diff(g, v);
                if !pool.is_zero(d) {
                    pattern.push((i, j));
                    outputs.push(d);
                }
            }
        }
        let mut places = Vec::new();
        let mut entries = Vec::new();
        if let &[g] = functions {
            for (i, row) in pool.hessian(g, &variables).into_iter().enumerate() {
                for (j, h) in row.into_iter().enumerate().skip(i).filter(|(_, h)| !pool.is_zero(*h)) {
                    places.push((i, j));
                    entries.push(h);
                }
            }
        }
        let second = if places.is_empty() {
            None
        } else {
            let tape = Tape::compile(pool, &all, &entries)?;
            Function::with_backend(tape, Backend::Tape).ok().map(|f| (places, f))
        };
        Ok(Self {
            second,
            states: states.len(),
            variables: variables.len(),
            references: references.len(),
            outputs: functions.len(),
            value: Function::new(Tape::compile(pool, &all, functions)?),
            derivatives: Function::new(Tape::compile(pool, &all, &outputs)?),
            pattern,
            arguments: vec![0.0; all.len()],
            work: Workspace::default(),
            out: vec![0.0; outputs.len()],
        })
    }

    /// Number of components.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Number of references.
    pub fn references(&self) -> usize {
        self.references
    }

    /// Whether any component depends on an input.
    pub fn uses_inputs(&self) -> bool {
        self.pattern.iter().any(|&(_, j)| j >= self.states)
    }

    /// Places (i, j) of the entries of ∂g/∂(x, u) that can differ from zero, row by row.
    pub fn jacobian_pattern(&self) -> &[(usize, usize)] {
        &self.pattern
    }

    /// Inputs that are missing (at the end of the horizon) count as zero, references beyond those used are ignored.
    fn load(&mut self, x: &[f64], u: &[f64], t: f64, r: &[f64]) {
        let n = self.states;
        self.arguments[..n].copy_from_slice(x);
        let inputs = &mut self.arguments[n..self.variables];
        if u.is_empty() {
            inputs.fill(0.0);
        } else {
            inputs.copy_from_slice(u);
        }
        self.arguments[self.variables] = t;
        self.arguments[self.variables + 1..].copy_from_slice(&r[..self.references]);
    }

    /// The values g(x, u, t, r).
    ///
    /// # Panics
    /// If a slice is shorter than the function needs.
    pub fn values(&mut self, x: &[f64], u: &[f64], t: f64, r: &[f64]) -> &[f64] {
        self.load(x, u, t, r);
        self.value.call(&self.arguments, &mut self.work, &mut self.out[..self.outputs]);
        &self.out[..self.outputs]
    }

    /// The values and the entries of the Jacobian in the order of [`VectorFunction::jacobian_pattern`].
    ///
    /// # Panics
    /// If a slice is shorter than the function needs.
    pub fn values_and_jacobian(&mut self, x: &[f64], u: &[f64], t: f64, r: &[f64]) -> (&[f64], &[f64]) {
        self.load(x, u, t, r);
        let all = self.outputs + self.pattern.len();
        self.derivatives.call(&self.arguments, &mut self.work, &mut self.out[..all]);
        self.out[..all].split_at(self.outputs)
    }

    /// Adds `weight` times the second derivatives of the only component to `hessian`, n + m rows of n + m entries. Components that
    /// are several count as affine.
    pub(crate) fn add_second_derivatives(&mut self, at: CostPoint<'_>, weight: f64, hessian: &mut [f64]) {
        if self.second.is_none() {
            return;
        }
        self.load(at.x, at.u, at.t, at.r);
        let Some((places, f)) = &self.second else { return };
        self.out.resize(self.out.len().max(places.len()), 0.0);
        f.call(&self.arguments, &mut self.work, &mut self.out[..places.len()]);
        let w = at.x.len() + at.u.len();
        for (&(i, j), h) in places.iter().zip(&self.out) {
            hessian[i * w + j] += weight * h;
            if i != j {
                hessian[j * w + i] += weight * h;
            }
        }
    }

    pub(super) fn check(&self, what: &'static str, states: usize, inputs: usize) -> Result<(), MpcError> {
        check_length(what, self.variables, states + inputs)?;
        check_length(what, self.states, states)
    }
}
