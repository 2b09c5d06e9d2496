//! What a cost or constraint may name, and its arguments.

use super::scaled_rows::{coefficient_name, over_scaled_time};
use bracketry_symbolic::{Expr, Names, Pool, Rational, Symbol};
use bracketry_system::System;

/// Arguments of a cost: state, input, time (s) and references.
#[derive(Clone, Copy)]
pub(crate) struct CostPoint<'a> {
    pub(crate) x: &'a [f64],
    pub(crate) u: &'a [f64],
    pub(crate) t: f64,
    pub(crate) r: &'a [f64],
}

/// Which variables a cost may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CostKind {
    /// States and inputs: the integrand.
    Stage,
    /// States only: the cost of the end.
    Terminal,
}

/// Inputs that a problem remembers for one interval: those whose rates it uses, and constants that it decides on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Remembered {
    /// Their indices.
    pub(crate) inputs: Vec<usize>,
    /// The period, s: `rate(u)` is the change of u since the interval before over the period.
    pub(crate) period: Rational,
    /// Those that are held over the whole horizon. Where there is no input, at its end, their value over the interval before
    /// takes their place.
    pub(crate) constants: Vec<usize>,
    /// The one of them that time is scaled by.
    pub(crate) time_scale: Option<usize>,
}

impl Remembered {
    /// The states of a problem's functions: those of the system, then the previous inputs.
    pub(crate) fn states(&self, system: &System, pool: &mut Pool) -> Vec<Symbol> {
        let mut states = system.states.clone();
        states.extend(self.inputs.iter().map(|&j| before(system, j, pool)));
        states
    }
}

impl Remembered {
    /// The expressions with the value over the interval before in place of every constant.
    fn without_inputs(&self, system: &System, pool: &mut Pool, expressions: &[Expr]) -> Vec<Expr> {
        if self.constants.is_empty() {
            return expressions.to_vec();
        }
        let constants = self.constants.iter().map(|&j| {
            let (now, before) = (pool.sym(system.inputs[j]), before(system, j, pool));
            (now, pool.sym(before))
        });
        let constants = constants.collect();
        pool.substitute_all(expressions, &constants)
    }

    /// The functions of one or more constraints: as functions of the state alone where no input but the constants is in them.
    pub(crate) fn at_grid_points(&self, system: &System, pool: &mut Pool, functions: &[Expr]) -> Option<Vec<Expr>> {
        let mut inputs = (0..system.inputs.len()).filter(|j| !self.constants.contains(j));
        let uses = |j: usize| functions.iter().any(|&g| pool.depends_on(g, system.inputs[j]));
        if inputs.any(uses) { None } else { Some(self.without_inputs(system, pool, functions)) }
    }
}

/// `r`, `der(r)`, `der(r, 2)`: the name of a derivative of a reference.
pub(crate) fn derivative_name(name: &str, order: u32) -> String {
    match order {
        0 => name.to_owned(),
        1 => format!("der({name})"),
        _ => format!("der({name}, {order})"),
    }
}

/// The symbol of the value of input j over the interval before.
fn before(system: &System, j: usize, pool: &mut Pool) -> Symbol {
    pool.symbol(&format!("{}#before", system.symbol_name(system.inputs[j])))
}

/// The names of a cost expression: states, inputs, time, references, parameters, definitions and outputs of the model.
pub(crate) struct CostNames<'a> {
    system: &'a System,
    kind: CostKind,
    references: &'a [String],
    remembered: Remembered,
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
        let algebraic = |e: Expr| system.algebraic.iter().any(|z| system.pool.depends_on(e, z.symbol));
        let (names, expressions): (Vec<String>, Vec<Expr>) =
            names.into_iter().zip(expressions).filter(|(_, e)| !algebraic(*e)).unzip();
        let defined = names.into_iter().zip(valued.with_values(&expressions)).collect();
        (Self { system, kind, references, remembered: Remembered::default(), defined }, valued.pool)
    }

    /// With inputs that are remembered.
    pub(crate) fn with_remembered(mut self, remembered: &Remembered) -> Self {
        self.remembered = remembered.clone();
        self
    }

    /// The time.
    fn time(&self, pool: &mut Pool) -> Expr {
        let t = pool.var("t");
        match self.remembered.time_scale {
            Some(j) => {
                let scale = pool.sym(self.system.inputs[j]);
                pool.mul(scale, t)
            }
            None => t,
        }
    }

    pub(super) fn inputs(&self) -> &[Symbol] {
        if self.kind == CostKind::Stage { &self.system.inputs } else { &[] }
    }
}

impl CostNames<'_> {
    /// A reference, over scaled time where it has coefficients.
    fn reference(&self, pool: &mut Pool, name: &str) -> Option<Expr> {
        let is_one = |name: &str| self.references.iter().any(|r| r == name);
        match self.remembered.time_scale.filter(|_| is_one(&coefficient_name(name, 1))) {
            Some(j) => {
                let scale = pool.sym(self.system.inputs[j]);
                Some(over_scaled_time(pool, name, scale))
            }
            None => is_one(name).then(|| pool.var(name)),
        }
    }

    /// An expression where there are inputs, or none: constants are the value before then.
    fn at_kind(&self, pool: &mut Pool, e: Expr) -> Expr {
        if self.kind == CostKind::Stage { e } else { self.remembered.without_inputs(self.system, pool, &[e])[0] }
    }

    /// What a name stands for where there are inputs.
    fn meaning(&self, pool: &mut Pool, name: &str) -> Option<Expr> {
        let called = |s: &Symbol| self.system.symbol_name(*s) == name;
        if name == "t" {
            return Some(self.time(pool));
        }
        if let Some(reference) = self.reference(pool, name) {
            return Some(reference);
        }
        if let Some(p) = self.system.parameters.iter().find(|p| called(&p.symbol)) {
            return Some(pool.rational(p.value.clone()));
        }
        if self.system.states.iter().chain(&self.system.inputs).any(called) {
            return Some(pool.var(name));
        }
        self.defined.iter().find(|(n, _)| n == name).map(|(_, e)| *e)
    }
}

impl Names for CostNames<'_> {
    fn lookup(&mut self, pool: &mut Pool, name: &str) -> Option<Expr> {
        let e = self.meaning(pool, name)?;
        if self.kind == CostKind::Stage {
            return Some(e);
        }
        let e = self.at_kind(pool, e);
        let mut inputs = self.system.inputs.iter();
        inputs.all(|u| !pool.depends_on(e, *u)).then_some(e)
    }
    /// The derivative of a reference is a reference of its own.
    fn derivative(&mut self, pool: &mut Pool, name: &str, order: u32) -> Option<Expr> {
        let e = self.reference(pool, &derivative_name(name, order))?;
        Some(self.at_kind(pool, e))
    }
    fn rate(&mut self, pool: &mut Pool, name: &str) -> Option<Expr> {
        let j = self.system.input_index(name).filter(|j| self.remembered.inputs.contains(j))?;
        let (now, before) = (pool.var(name), before(self.system, j, pool));
        let before = pool.sym(before);
        let change = pool.sub(now, before);
        let mut period = pool.rational(self.remembered.period.clone());
        if let Some(scale) = self.remembered.time_scale {
            let scale = pool.sym(self.system.inputs[scale]);
            period = pool.mul(scale, period);
        }
        (self.kind == CostKind::Stage).then(|| pool.div(change, period))
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
