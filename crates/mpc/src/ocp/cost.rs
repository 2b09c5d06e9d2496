//! Cost expressions with gradient and convexified exact Hessian.

use crate::dense::{clip_to_psd, components};
use crate::error::{MpcError, check_length};
use bracketry_native::{Function, Workspace};
use bracketry_symbolic::{Expr, Names, Pool, Symbol, Tape};
use bracketry_system::System;

/// Arguments of a cost: state, input, time (s) and references.
#[derive(Clone, Copy)]
pub(crate) struct CostPoint<'a> {
    pub(crate) x: &'a [f64],
    pub(crate) u: &'a [f64],
    pub(crate) t: f64,
    pub(crate) r: &'a [f64],
}

/// A scalar function l(x, u, t, r) of states, inputs, time and references, compiled with its derivatives.
///
/// Its Hessian with respect to (x, u) is exact where it is positive semidefinite (always, for sums of squares of linear
/// expressions); elsewhere the negative eigenvalues of each connected block are clipped to zero.
#[derive(Clone)]
pub struct CostFunction {
    variables: usize,
    references: usize,
    value: Function,
    derivatives: Function,
    /// Places (i ≤ j) of the second derivatives that the tape computes after value and gradient.
    entries: Vec<(usize, usize)>,
    components: Vec<Vec<usize>>,
    pattern: Vec<(usize, usize)>,
    arguments: Vec<f64>,
    work: Workspace,
    out: Vec<f64>,
    /// The Hessian, n rows of n.
    full: Vec<f64>,
    /// One connected block of it.
    block: Vec<f64>,
    scratch: Vec<f64>,
}

/// Which variables a cost may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CostKind {
    /// States and inputs: the integrand.
    Stage,
    /// States only: the cost of the end.
    Terminal,
}

/// The names of a cost expression: states, inputs, time, references, parameters, definitions and outputs of the model.
pub(crate) struct CostNames<'a> {
    system: &'a System,
    kind: CostKind,
    references: &'a [String],
    /// Definitions and outputs, parameters at their values.
    defined: Vec<(String, Expr)>,
}

impl<'a> CostNames<'a> {
    /// The names, and the pool in which expressions over them are to be read. A reference with the name of a parameter
    /// stands in its place.
    pub(crate) fn new(system: &'a System, kind: CostKind, references: &'a [String]) -> (Self, Pool) {
        let mut valued = system.clone();
        let pool = &valued.pool;
        valued.parameters.retain(|p| !references.iter().any(|r| r == pool.name(p.symbol)));
        let (names, expressions): (Vec<String>, Vec<Expr>) =
            system.definitions.iter().chain(&system.outputs).cloned().unzip();
        let defined = names.into_iter().zip(valued.with_values(&expressions)).collect();
        (Self { system, kind, references, defined }, valued.pool)
    }

    fn inputs(&self) -> &[Symbol] {
        if self.kind == CostKind::Stage { &self.system.inputs } else { &[] }
    }
}

impl Names for CostNames<'_> {
    fn lookup(&mut self, pool: &mut Pool, name: &str) -> Option<Expr> {
        let called = |s: &Symbol| self.system.symbol_name(*s) == name;
        if name == "t" || self.references.iter().any(|r| r == name) {
            return Some(pool.var(name));
        }
        if let Some(p) = self.system.parameters.iter().find(|p| called(&p.symbol)) {
            return Some(pool.rational(p.value.clone()));
        }
        if self.system.states.iter().chain(self.inputs()).any(called) {
            return Some(pool.var(name));
        }
        let (_, e) = self.defined.iter().find(|(n, _)| n == name)?;
        let forbidden = |u: &Symbol| !self.inputs().contains(u) && pool.depends_on(*e, *u);
        (!self.system.inputs.iter().any(forbidden)).then_some(*e)
    }
    fn known(&self) -> Vec<String> {
        let mut names = self.system.state_names();
        names.extend(self.inputs().iter().map(|u| self.system.symbol_name(*u).to_owned()));
        names.push("t".into());
        names.extend(self.system.parameters.iter().map(|p| self.system.symbol_name(p.symbol).to_owned()));
        names.extend(self.references.iter().cloned());
        names.extend(self.defined.iter().map(|(n, _)| n.clone()));
        names
    }
}

impl CostFunction {
    /// Reads a cost over the names of a system (states, inputs, parameters, definitions, outputs), the time `t` and references.
    ///
    /// ```
    /// use bracketry_mpc::{CostFunction, CostKind};
    /// use bracketry_system::System;
    /// let text = r#"states = ["p"]
    /// inputs = ["u"]
    /// dynamics = { p = "u" }"#;
    /// let system = System::parse("integrator.toml", text).unwrap();
    /// let mut cost = CostFunction::parse(&system, CostKind::Stage, &["goal"], "(p - goal)^2 + u^2").unwrap();
    /// assert_eq!(cost.value(&[3.0], &[2.0], 0.0, &[1.0]), 8.0);
    /// ```
    ///
    /// # Errors
    /// A syntax error, or a name that may not stand there.
    pub fn parse(system: &System, kind: CostKind, references: &[&str], text: &str) -> Result<Self, MpcError> {
        let references: Vec<String> = references.iter().map(|s| (*s).to_owned()).collect();
        let (mut names, mut pool) = CostNames::new(system, kind, &references);
        let cost = pool.parse_with(text, &mut names)?;
        Self::of_system(system, kind, &references, &mut pool, cost)
    }

    pub(crate) fn of_system(
        system: &System,
        kind: CostKind,
        references: &[String],
        pool: &mut Pool,
        cost: Expr,
    ) -> Result<Self, MpcError> {
        let time = pool.symbol("t");
        let references: Vec<Symbol> = references.iter().map(|r| pool.symbol(r)).collect();
        let inputs: &[Symbol] = if kind == CostKind::Stage { &system.inputs } else { &[] };
        Self::compile(pool, time, &system.states, inputs, &references, cost)
    }

    /// Compiles `cost` as a function of time, states, inputs and references.
    ///
    /// # Errors
    /// [`MpcError::Compile`] if the expression uses another name.
    pub fn compile(
        pool: &mut Pool,
        time: Symbol,
        states: &[Symbol],
        inputs: &[Symbol],
        references: &[Symbol],
        cost: Expr,
    ) -> Result<Self, MpcError> {
        let variables: Vec<Symbol> = states.iter().chain(inputs).copied().collect();
        let mut all = variables.clone();
        all.push(time);
        all.extend(references);
        let gradient = pool.gradient(cost, &variables);
        let mut outputs = vec![cost];
        outputs.extend(&gradient);
        let mut entries = Vec::new();
        for (i, &g) in gradient.iter().enumerate() {
            for (j, &v) in variables.iter().enumerate().skip(i) {
                let h = pool.diff(g, v);
                if !pool.is_zero(h) {
                    entries.push((i, j));
                    outputs.push(h);
                }
            }
        }
        let links: Vec<(usize, usize)> = entries.iter().copied().filter(|(i, j)| i != j).collect();
        let components = components(variables.len(), &links);
        let pattern = components
            .iter()
            .flat_map(|c| c.iter().enumerate().flat_map(move |(p, &i)| c[p..].iter().map(move |&j| (i, j))))
            .collect();
        let derivatives = Function::new(Tape::compile(pool, &all, &outputs)?);
        Ok(Self {
            variables: variables.len(),
            references: references.len(),
            value: Function::new(Tape::compile(pool, &all, &[cost])?),
            out: vec![0.0; derivatives.n_outputs()],
            derivatives,
            entries,
            full: vec![0.0; variables.len().pow(2)],
            block: Vec::new(),
            scratch: Vec::new(),
            components,
            pattern,
            arguments: vec![0.0; all.len()],
            work: Workspace::default(),
        })
    }

    /// Number of references.
    pub fn references(&self) -> usize {
        self.references
    }

    /// Number of states and inputs.
    pub fn variables(&self) -> usize {
        self.variables
    }

    pub(crate) fn check(&self, what: &'static str, variables: usize) -> Result<(), MpcError> {
        check_length(what, self.variables, variables)
    }

    fn load(&mut self, x: &[f64], u: &[f64], t: f64, r: &[f64]) {
        let (n, m) = (x.len(), u.len());
        self.arguments[..n].copy_from_slice(x);
        self.arguments[n..n + m].copy_from_slice(u);
        self.arguments[n + m] = t;
        self.arguments[n + m + 1..].copy_from_slice(r);
    }

    /// The value l(x, u, t, r).
    pub fn value(&mut self, x: &[f64], u: &[f64], t: f64, r: &[f64]) -> f64 {
        self.load(x, u, t, r);
        let mut out = [0.0];
        self.value.call(&self.arguments, &mut self.work, &mut out);
        out[0]
    }

    /// Places (i ≤ j) that the Hessian can occupy, every diagonal place among them.
    pub fn hessian_pattern(&self) -> &[(usize, usize)] {
        &self.pattern
    }

    /// Adds `weight` times the gradient; the Hessian is then in `full`.
    fn differentiate(&mut self, at: CostPoint<'_>, weight: f64, gradient: &mut [f64]) {
        self.load(at.x, at.u, at.t, at.r);
        self.derivatives.call(&self.arguments, &mut self.work, &mut self.out);
        let n = self.variables;
        for (g, v) in gradient.iter_mut().zip(&self.out[1..=n]) {
            *g += weight * v;
        }
        for (&(i, j), &v) in self.entries.iter().zip(&self.out[1 + n..]) {
            self.full[i * n + j] = v;
            self.full[j * n + i] = v;
        }
    }

    /// The exact Hessian, in full by rows, where derivatives were last asked for.
    pub(crate) fn last_hessian(&self) -> &[f64] {
        &self.full
    }

    /// Adds `weight` times gradient and convexified Hessian (in the order of [`CostFunction::hessian_pattern`]).
    pub(crate) fn add_derivatives(
        &mut self,
        at: CostPoint<'_>,
        weight: f64,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) {
        self.differentiate(at, weight, gradient);
        let n = self.variables;
        let mut at = 0;
        for c in &self.components {
            let size = c.len();
            self.block.clear();
            self.block
                .extend(c.iter().flat_map(|&i| c.iter().map(move |&j| (i, j))).map(|(i, j)| self.full[i * n + j]));
            clip_to_psd(&mut self.block, size, &mut self.scratch);
            for a in 0..size {
                for b in a..size {
                    hessian[at] += weight * self.block[a * size + b];
                    at += 1;
                }
            }
        }
    }
}
