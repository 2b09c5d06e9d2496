//! The field with its signs as arguments, and what is needed to hold a switching function at zero.

use crate::dynamics::{Arguments, sparse_jacobian};
use crate::error::{MpcError, check_value};
use bracketry_native::{Function, Workspace};
use bracketry_symbolic::{Expr, Symbol, Tape};
use bracketry_system::{SwitchKind, System};

/// Sets of switches are the bits of a word.
const MAX_SWITCHES: usize = 64;

/// The equations x' = f(t, x, u, s) with one sign s_i for every switching function σ_i, compiled with the derivatives that
/// event-driven integration and its sensitivities need. Unit vectors are rounded with a width.
#[derive(Clone)]
pub(crate) struct SwitchedField {
    pub(crate) states: usize,
    pub(crate) inputs: usize,
    pub(crate) switches: usize,
    /// Whether the sign may take any value in [−1, 1] on its surface; the others are merely crossed.
    pub(crate) sticks: Vec<bool>,
    /// Whether f is affine in the signs: then one solution of a linear system finds those that stick.
    pub(crate) affine: bool,
    /// Outputs: f (n), σ (k), σ̇ (k), ∂f/∂s (n × k), ∂σ̇/∂s (k × k).
    values: Function,
    /// The same, then ∇σ (k × n), then the entries of ∂f/∂(x, u) and of ∂σ̇/∂(x, u).
    derivatives: Function,
    pub(crate) field_pattern: Vec<(usize, usize)>,
    pub(crate) rate_pattern: Vec<(usize, usize)>,
    /// ∂σ̇/∂s of every component of a unit vector: divided by the width, the speed at which it relaxes onto rest.
    relaxation: Function,
    rounding: f64,
    arguments: Arguments,
    work: Workspace,
    out: Vec<f64>,
}

impl SwitchedField {
    pub(crate) fn new(system: &System, live: &[&str], rounding: f64) -> Result<Self, MpcError> {
        let mut system = system.clone();
        let form = system.set_valued_form();
        let signs: Vec<Symbol> = form.signs().iter().map(|s| s.sign).collect();
        check_value(
            signs.len() <= MAX_SWITCHES,
            "the number of switching functions",
            signs.len() as f64,
            "give a model with at most 64 for the exact flow, or smooth them",
        )?;
        let width = system.pool.symbol("smoothing#width");
        let width_expr = system.pool.sym(width);
        let mut rounded = system.smooth_signs(&form, width_expr);
        for &s in &signs {
            let e = system.pool.sym(s);
            rounded.remove(&e);
        }
        let f = system.pool.substitute_all(&form.dynamics, &rounded);
        let surfaces: Vec<Expr> = form.signs().iter().map(|s| s.surface).collect();
        let surfaces = system.pool.substitute_all(&surfaces, &rounded);

        let others: Vec<Symbol> = signs.iter().copied().chain([width]).collect();
        let mut arguments = Arguments::new(&mut system, live, &others)?;
        let pool = &mut system.pool;
        let time = pool.symbol("t");
        let columns: Vec<Symbol> = system.states.iter().chain(&system.inputs).copied().collect();
        let rates: Vec<Expr> = surfaces
            .iter()
            .map(|&e| {
                let along = pool.lie_derivative(e, &system.states, &f);
                let partial = pool.diff(e, time);
                pool.add(along, partial)
            })
            .collect();
        let mut relaxation = Vec::new();
        for c in &form.switches[form.signs().len()..] {
            let gains: Vec<Expr> = form.dynamics.iter().map(|&e| pool.diff(e, c.sign)).collect();
            relaxation.push(pool.lie_derivative(c.surface, &system.states, &gains));
        }
        let relaxation = pool.substitute_all(&relaxation, &rounded);
        let field_by_sign: Vec<Expr> = pool.jacobian(&f, &signs).concat();
        let rate_by_sign: Vec<Expr> = pool.jacobian(&rates, &signs).concat();
        let affine = field_by_sign.iter().all(|&e| signs.iter().all(|&s| !pool.depends_on(e, s)));

        let mut outputs = f.clone();
        outputs.extend(surfaces.iter().chain(&rates).chain(&field_by_sign).chain(&rate_by_sign));
        let values = Function::new(Tape::compile(pool, &arguments.symbols, &outputs)?);
        let relaxation = Function::new(Tape::compile(pool, &arguments.symbols, &relaxation)?);

        outputs.extend(pool.jacobian(&surfaces, &system.states).concat());
        let mut pattern_of = |rows: &[Expr]| -> Vec<(usize, usize)> {
            let entries = sparse_jacobian(pool, rows, &columns);
            outputs.extend(entries.iter().map(|entry| entry.2));
            entries.into_iter().map(|(i, j, _)| (i, j)).collect()
        };
        let field_pattern = pattern_of(&f);
        let rate_pattern = pattern_of(&rates);
        let derivatives = Function::new(Tape::compile(pool, &arguments.symbols, &outputs)?);
        if let Some(width) = arguments.values.last_mut() {
            *width = rounding;
        }
        Ok(Self {
            states: system.states.len(),
            inputs: system.inputs.len(),
            switches: signs.len(),
            sticks: form.signs().iter().map(|s| s.kind == SwitchKind::Jump).collect(),
            affine,
            relaxation,
            rounding,
            out: vec![0.0; derivatives.n_outputs()],
            values,
            derivatives,
            field_pattern,
            rate_pattern,
            arguments,
            work: Workspace::default(),
        })
    }

    /// Gives the live parameters their values.
    pub(crate) fn set_parameters(&mut self, values: &[f64]) {
        self.arguments.set_parameters(values);
    }

    fn load(&mut self, t: f64, x: &[f64], u: &[f64], s: &[f64]) {
        self.arguments.load(t, x, u);
        let first = self.arguments.values.len() - 1 - s.len();
        self.arguments.values[first..first + s.len()].copy_from_slice(s);
    }

    /// Evaluates everything but the derivatives by state and input.
    pub(crate) fn evaluate(&mut self, t: f64, x: &[f64], u: &[f64], s: &[f64]) {
        self.load(t, x, u, s);
        let count = self.values.n_outputs();
        self.values.call(&self.arguments.values, &mut self.work, &mut self.out[..count]);
    }

    /// Evaluates everything.
    pub(crate) fn differentiate(&mut self, t: f64, x: &[f64], u: &[f64], s: &[f64]) {
        self.load(t, x, u, s);
        self.derivatives.call(&self.arguments.values, &mut self.work, &mut self.out);
    }

    /// f.
    pub(crate) fn field(&self) -> &[f64] {
        &self.out[..self.states]
    }

    /// σ.
    pub(crate) fn surface(&self, i: usize) -> f64 {
        self.out[self.states + i]
    }

    /// σ̇ = ∇σ·f + ∂σ/∂t.
    pub(crate) fn rate(&self, i: usize) -> f64 {
        self.out[self.states + self.switches + i]
    }

    /// ∂f_j/∂s_i.
    pub(crate) fn field_by_sign(&self, j: usize, i: usize) -> f64 {
        self.out[self.states + 2 * self.switches + j * self.switches + i]
    }

    /// ∂σ̇_i/∂s_j.
    pub(crate) fn rate_by_sign(&self, i: usize, j: usize) -> f64 {
        let (n, k) = (self.states, self.switches);
        self.out[n + 2 * k + n * k + i * k + j]
    }

    fn first_derivative(&self) -> usize {
        let (n, k) = (self.states, self.switches);
        n + 2 * k + n * k + k * k
    }

    /// ∂σ_i/∂x_j, after [`SwitchedField::differentiate`].
    pub(crate) fn gradient(&self, i: usize, j: usize) -> f64 {
        self.out[self.first_derivative() + i * self.states + j]
    }

    /// ∇σ_i, after [`SwitchedField::differentiate`].
    pub(crate) fn gradient_of(&self, i: usize) -> &[f64] {
        let first = self.first_derivative() + i * self.states;
        &self.out[first..first + self.states]
    }

    /// Entries of ∂f/∂(x, u) in the order of their pattern, after [`SwitchedField::differentiate`].
    pub(crate) fn field_entries(&self) -> &[f64] {
        let first = self.first_derivative() + self.switches * self.states;
        &self.out[first..first + self.field_pattern.len()]
    }

    /// Entries of ∂σ̇/∂(x, u) in the order of their pattern, after [`SwitchedField::differentiate`].
    pub(crate) fn rate_entries(&self) -> &[f64] {
        let first = self.first_derivative() + self.switches * self.states + self.field_pattern.len();
        &self.out[first..]
    }

    /// Speed, in 1/s, at which the rounded unit vectors relax onto rest; 0 where there is none.
    pub(crate) fn relaxation_rate(&mut self, t: f64, x: &[f64], u: &[f64], s: &[f64]) -> f64 {
        let count = self.relaxation.n_outputs();
        if count == 0 {
            return 0.0;
        }
        self.load(t, x, u, s);
        self.relaxation.call(&self.arguments.values, &mut self.work, &mut self.out[..count]);
        self.out[..count].iter().fold(0.0_f64, |m, r| m.max(r.abs())) / self.rounding
    }
}
