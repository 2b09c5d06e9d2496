//! Dynamics compiled from expressions.

use super::arguments::{Arguments, sparse_jacobian};
use super::field::Dynamics;
use super::implicit::ImplicitDynamics;
use super::second_derivatives::{SecondDerivatives, WeightedHessian};
use crate::error::MpcError;
use bracketry_native::{Function, Workspace};
use bracketry_sim::NoRoot;
use bracketry_symbolic::{Expr, Symbol, Tape};
use bracketry_system::{SwitchKind, SwitchedForm, System};

/// Dynamics compiled from expressions; `sign` is smoothed with a width that can be changed at any time.
///
/// ```
/// use bracketry_mpc::{Dynamics, SymbolicDynamics};
/// use bracketry_system::System;
/// let block = System::parse("block.toml", r#"
///     states = ["x", "v"]
///     inputs = ["a"]
///     dynamics = { x = "v", v = "a - sign(v)" }
/// "#).unwrap();
/// let mut dynamics = SymbolicDynamics::new(&block).unwrap();
/// dynamics.set_smoothing(0.5);
/// let mut dx = [0.0; 2];
/// dynamics.field(0.0, &[0.0, 1.0], &[3.0], &mut dx);
/// assert_eq!(dx, [1.0, 3.0 - 2f64.tanh()]);
/// assert_eq!(dynamics.relaxation_rate(0.0, &[0.0, 1.0], &[3.0]), 1.0 / 0.5);
/// ```
#[derive(Clone)]
pub struct SymbolicDynamics {
    states: usize,
    inputs: usize,
    field: Function,
    field_and_jacobian: Function,
    rates: Function,
    pattern: Vec<(usize, usize)>,
    second: SecondDerivatives,
    /// Compiled when it is first asked for.
    hessian: Option<WeightedHessian>,
    smoothed: bool,
    jumps: bool,
    width: f64,
    arguments: Arguments,
    work: Workspace,
    out: Vec<f64>,
    /// Where the system has algebraic variables, which are solved for.
    implicit: Option<Box<ImplicitDynamics<SymbolicDynamics>>>,
}

impl SymbolicDynamics {
    /// Compiles the dynamics of a system with smoothed signs, its parameters at their values.
    ///
    /// The smoothing width starts at 0.01 (in the unit of the sign's argument).
    ///
    /// # Errors
    /// [`MpcError::InputDerivative`] if the equations use a derivative of an input.
    pub fn new(system: &System) -> Result<Self, MpcError> {
        Self::with_live_parameters(system, &[])
    }

    /// As [`SymbolicDynamics::new`]; [`Dynamics::set_parameters`] changes the named parameters, in this order.
    ///
    /// ```
    /// use bracketry_mpc::{Dynamics, SymbolicDynamics};
    /// use bracketry_system::System;
    /// let system = System::parse("decay.toml", r#"
    ///     states = ["x"]
    ///     inputs = ["u"]
    ///     parameters = { a = 2, b = 1 }
    ///     dynamics = { x = "b*u - a*x" }
    /// "#).unwrap();
    /// let mut dynamics = SymbolicDynamics::with_live_parameters(&system, &["a"]).unwrap();
    /// let mut dx = [0.0];
    /// dynamics.field(0.0, &[1.0], &[0.0], &mut dx);
    /// assert_eq!(dx, [-2.0]);
    /// dynamics.set_parameters(&[5.0]);
    /// dynamics.field(0.0, &[1.0], &[0.0], &mut dx);
    /// assert_eq!(dx, [-5.0]);
    /// ```
    ///
    /// # Errors
    /// [`MpcError::NoSuchParameter`] for another name, [`MpcError::InputDerivative`] if the equations use a derivative of an
    /// input.
    pub fn with_live_parameters(system: &System, live: &[&str]) -> Result<Self, MpcError> {
        let whole = Self::explicit(&system.with_algebraic_states(), live)?;
        if system.algebraic.is_empty() {
            return Ok(whole);
        }
        let guess = system.algebraic.iter().map(|z| system.value(z.guess).unwrap_or(0.0)).collect();
        let implicit = Box::new(ImplicitDynamics::new(whole.clone(), guess));
        let (states, pattern) = (system.states.len(), implicit.pattern().to_vec());
        Ok(Self { states, pattern, implicit: Some(implicit), ..whole })
    }

    /// For a system without algebraic variables.
    fn explicit(system: &System, live: &[&str]) -> Result<Self, MpcError> {
        let mut system = system.clone();
        let form = system.set_valued_form();
        let rates = relaxation_rates(&mut system, &form);
        let width_symbol = system.pool.symbol("smoothing#width");
        let width = system.pool.sym(width_symbol);
        let signs = system.smooth_signs(&form, width);
        let f = system.pool.substitute_all(&form.dynamics, &signs);
        let rates = system.pool.substitute_all(&rates, &signs);
        let arguments = Arguments::new(&mut system, live, &[width_symbol])?;
        let pool = &mut system.pool;
        let columns: Vec<Symbol> = system.states.iter().chain(&system.inputs).copied().collect();
        let jacobian = sparse_jacobian(pool, &f, &columns);
        let mut outputs = f.clone();
        outputs.extend(jacobian.iter().map(|entry| entry.2));
        let all = &arguments.symbols;
        let field_and_jacobian = Function::new(Tape::compile(pool, all, &outputs)?);
        Ok(Self {
            states: system.states.len(),
            inputs: system.inputs.len(),
            field: Function::new(Tape::compile(pool, all, &f)?),
            rates: Function::new(Tape::compile(pool, all, &rates)?),
            out: vec![0.0; field_and_jacobian.n_outputs()],
            field_and_jacobian,
            pattern: jacobian.iter().map(|&(i, j, _)| (i, j)).collect(),
            smoothed: !form.switches.is_empty(),
            jumps: !form.unit_vectors.is_empty() || form.signs().iter().any(|s| s.kind == SwitchKind::Jump),
            second: SecondDerivatives::new(pool, all.clone(), columns, f.len(), jacobian),
            hessian: None,
            width: 0.01,
            arguments,
            work: Workspace::default(),
            implicit: None,
        })
    }

    fn load(&mut self, t: f64, x: &[f64], u: &[f64]) {
        self.arguments.load(t, x, u);
        if let Some(width) = self.arguments.values.last_mut() {
            *width = self.width;
        }
    }
}

impl Dynamics for SymbolicDynamics {
    fn states(&self) -> usize {
        self.states
    }
    fn inputs(&self) -> usize {
        self.inputs
    }
    fn field(&mut self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64]) {
        if let Some(implicit) = &mut self.implicit {
            return implicit.field(t, x, u, dx);
        }
        self.load(t, x, u);
        self.field.call(&self.arguments.values, &mut self.work, dx);
    }
    fn jacobian_pattern(&self) -> &[(usize, usize)] {
        &self.pattern
    }
    fn field_and_jacobian(&mut self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64], jacobian: &mut [f64]) {
        if let Some(implicit) = &mut self.implicit {
            return implicit.field_and_jacobian(t, x, u, dx, jacobian);
        }
        self.load(t, x, u);
        self.field_and_jacobian.call(&self.arguments.values, &mut self.work, &mut self.out);
        dx.copy_from_slice(&self.out[..self.states]);
        jacobian.copy_from_slice(&self.out[self.states..]);
    }
    fn second_derivatives(&mut self) -> Result<Vec<(usize, usize)>, MpcError> {
        if let Some(implicit) = &mut self.implicit {
            return implicit.second_derivatives();
        }
        if self.hessian.is_none() {
            self.hessian = Some(self.second.compile()?);
        }
        Ok(self.hessian.as_ref().map_or(Vec::new(), |h| h.pattern().to_vec()))
    }
    fn weighted_hessian(&mut self, t: f64, x: &[f64], u: &[f64], weights: &[f64], hessian: &mut [f64]) {
        if let Some(implicit) = &mut self.implicit {
            return implicit.weighted_hessian(t, x, u, weights, hessian);
        }
        self.load(t, x, u);
        match &mut self.hessian {
            Some(h) => h.call(&self.arguments.values, weights, &mut self.work, hessian),
            None => hessian.fill(f64::NAN),
        }
    }
    fn parameters(&self) -> usize {
        self.arguments.parameters()
    }
    fn set_parameters(&mut self, parameters: &[f64]) {
        if let Some(implicit) = &mut self.implicit {
            implicit.whole().set_parameters(parameters);
        }
        self.arguments.set_parameters(parameters);
    }
    fn is_smoothed(&self) -> bool {
        self.smoothed
    }
    fn has_jumps(&self) -> bool {
        self.jumps
    }
    fn set_smoothing(&mut self, width: f64) {
        self.width = width;
    }
    fn take_failure(&mut self) -> Option<(f64, NoRoot)> {
        self.implicit.as_mut().and_then(|implicit| implicit.take_failure())
    }
    fn relaxation_rate(&mut self, t: f64, x: &[f64], u: &[f64]) -> f64 {
        if self.rates.n_outputs() == 0 || self.implicit.is_some() {
            return 0.0;
        }
        self.load(t, x, u);
        let mut rates = vec![0.0; self.rates.n_outputs()];
        self.rates.call(&self.arguments.values, &mut self.work, &mut rates);
        rates.iter().fold(0.0, |m: f64, r| m.max(r.abs())) / self.width
    }
}

/// For every sign s of a function σ: the rate ∂σ̇/∂s that, divided by the smoothing width, is the speed at which the smoothed
/// dynamics relax onto σ = 0 (for Coulomb friction: μg). It decides how small an explicit integration step must be.
fn relaxation_rates(system: &mut System, form: &SwitchedForm) -> Vec<Expr> {
    let mut rates = Vec::new();
    for switch in form.switches.iter().filter(|s| s.kind == SwitchKind::Jump) {
        let gains: Vec<Expr> = form.dynamics.iter().map(|&f| system.pool.diff(f, switch.sign)).collect();
        let states = system.states.clone();
        rates.push(system.pool.lie_derivative(switch.surface, &states, &gains));
    }
    rates
}
