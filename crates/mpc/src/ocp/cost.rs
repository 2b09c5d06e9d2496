//! Cost expressions with gradient and a positive semidefinite Hessian.

use super::bounds::{Bounds, Softness};
use super::constraint::PathConstraint;
use super::cost_names::{CostKind, CostNames, CostPoint, Remembered};
use super::cost_norms::CostNorms;
use super::cost_parts::CostParts;
use super::norm_widths::Widths;
use super::vector_function::VectorFunction;
use crate::error::{MpcError, check_length};
use bracketry_native::{Function, Workspace};
use bracketry_numerics::dense::{clip_to_psd, components};
use bracketry_symbolic::{Expr, Pool, Symbol, Tape};
use bracketry_system::System;

/// A scalar function l(x, u, t, r) of states, inputs, time and references, compiled with its derivatives.
///
/// Squares w r² with w > 0 have the Gauss–Newton Hessian 2 w ∇r ∇rᵀ with respect to (x, u), which is exact where r is affine. That
/// of the rest is exact where it is positive semidefinite; elsewhere the negative eigenvalues of each connected block are clipped
/// to zero. Norms are rounded where they vanish, in derivatives and for the solvers. Absolute values w |e| and w max(a, b) with w > 0 are
/// not differentiated: in a program, slacks take their place.
#[derive(Clone)]
pub struct CostFunction {
    variables: usize,
    references: usize,
    value: Function,
    derivatives: Function,
    /// Places (i ≤ j) of the second derivatives that the tape computes after value and gradient.
    entries: Vec<(usize, usize)>,
    /// Where squares have curved residuals: the same for the rest of the cost, then for the Gauss–Newton Hessian of the squares.
    squares: Option<[Vec<(usize, usize)>; 2]>,
    /// Absolute values, as functions that violate the bounds 0 and 0.
    absolute: Vec<PathConstraint>,
    components: Vec<Vec<usize>>,
    pattern: Vec<(usize, usize)>,
    widths: Widths,
    arguments: Vec<f64>,
    work: Workspace,
    out: Vec<f64>,
    /// The Hessian, n rows of n.
    full: Vec<f64>,
    /// That of the rest, and the one of Gauss and Newton; empty where there are no squares of curved residuals.
    rest: Vec<f64>,
    gauss_newton: Vec<f64>,
    /// One connected block of it.
    block: Vec<f64>,
    scratch: Vec<f64>,
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
        Self::of_system(system, kind, &references, &Remembered::default(), &mut pool, cost)
    }

    pub(crate) fn of_system(
        system: &System,
        kind: CostKind,
        references: &[String],
        rates: &Remembered,
        pool: &mut Pool,
        cost: Expr,
    ) -> Result<Self, MpcError> {
        let time = pool.symbol("t");
        let states = rates.states(system, pool);
        let references: Vec<Symbol> = references.iter().map(|r| pool.symbol(r)).collect();
        let inputs: &[Symbol] = if kind == CostKind::Stage { &system.inputs } else { &[] };
        Self::compile(pool, time, &states, inputs, &references, cost)
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
        let norms = CostNorms::of(pool, cost, &variables);
        let cost = norms.cost;
        all.extend(&norms.widths);
        let widths = norms.compile(pool, &all, variables.len())?;
        let parts = CostParts::of(pool, cost, &variables, &norms.rounded);
        let absolute = parts.absolute.iter().map(|term| {
            let function = VectorFunction::compile(pool, time, states, inputs, references, &[term.residual])?;
            let softness = Softness::Soft { linear: term.weight, quadratic: 0.0 };
            Ok(PathConstraint {
                name: String::new(),
                function,
                bounds: Bounds { min: 0.0, max: 0.0, softness },
                at_end: false,
            })
        });
        let absolute = absolute.collect::<Result<Vec<_>, MpcError>>()?;
        let (squares, gauss_newton) = parts.sum_of_squares(pool, &variables);
        let smooth = pool.add(parts.rest, squares);
        let gradient = pool.gradient(smooth, &variables);
        let mut outputs = vec![cost];
        outputs.extend(&gradient);
        let mut entries_of = |pool: &Pool, hessian: &[Vec<Expr>]| {
            let mut entries = Vec::new();
            for (i, row) in hessian.iter().enumerate() {
                for (j, &h) in row.iter().enumerate().skip(i).filter(|(_, h)| !pool.is_zero(**h)) {
                    entries.push((i, j));
                    outputs.push(h);
                }
            }
            entries
        };
        let exact = pool.hessian(smooth, &variables);
        let entries = entries_of(pool, &exact);
        let mut links: Vec<(usize, usize)> = entries.clone();
        let squares = parts.has_squares().then(|| {
            let rest = pool.hessian(parts.rest, &variables);
            [entries_of(pool, &rest), entries_of(pool, &gauss_newton)]
        });
        links.extend(squares.iter().flatten().flatten());
        links.retain(|(i, j)| i != j);
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
            rest: vec![0.0; if squares.is_some() { variables.len().pow(2) } else { 0 }],
            gauss_newton: vec![0.0; if squares.is_some() { variables.len().pow(2) } else { 0 }],
            squares,
            absolute,
            block: Vec::new(),
            scratch: Vec::new(),
            components,
            pattern,
            widths,
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
        self.arguments[n + m + 1..][..self.references].copy_from_slice(r);
    }

    /// Rounds norms by this share of their sizes, in values too; 0 makes them exact.
    pub(crate) fn round_norms(&mut self, share: f64) {
        self.widths.set_share(share);
    }

    /// Finds the sizes of norms.
    pub(crate) fn measure_norms(&mut self, at: CostPoint<'_>, sizes: &[f64]) {
        self.widths.measure(at, sizes);
    }

    pub(crate) fn has_norms(&self) -> bool {
        !self.widths.are_none()
    }

    /// The value l(x, u, t, r).
    pub fn value(&mut self, x: &[f64], u: &[f64], t: f64, r: &[f64]) -> f64 {
        self.load(x, u, t, r);
        let first = self.variables + 1 + self.references;
        self.arguments[first..].iter_mut().zip(self.widths.of_values()).for_each(|(a, w)| *a = w);
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
        let first = self.variables + 1 + self.references;
        self.arguments[first..].iter_mut().zip(self.widths.of_derivatives()).for_each(|(a, w)| *a = w);
        self.derivatives.call(&self.arguments, &mut self.work, &mut self.out);
        let n = self.variables;
        for (g, v) in gradient.iter_mut().zip(&self.out[1..=n]) {
            *g += weight * v;
        }
        let mut values = self.out[1 + n..].iter();
        let [rest, gauss_newton] = self.squares.as_ref().map_or([&[][..]; 2], |s| [&s[0], &s[1]]);
        for (entries, block) in
            [(self.entries.as_slice(), &mut self.full), (rest, &mut self.rest), (gauss_newton, &mut self.gauss_newton)]
        {
            for (&(i, j), &v) in entries.iter().zip(&mut values) {
                block[i * n + j] = v;
                block[j * n + i] = v;
            }
        }
    }

    /// The exact Hessian without absolute values, in full by rows, where derivatives were last asked for.
    pub(crate) fn last_hessian(&self) -> &[f64] {
        &self.full
    }

    /// Absolute values of the cost, as functions with the bounds 0 and 0 and the weight of a violation.
    pub(crate) fn absolute(&self) -> &[PathConstraint] {
        &self.absolute
    }

    /// The same, to be evaluated.
    pub(crate) fn absolute_mut(&mut self) -> &mut [PathConstraint] {
        &mut self.absolute
    }

    /// Adds `weight` times gradient and positive semidefinite Hessian (in the order of [`CostFunction::hessian_pattern`]).
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
        let clipped = if self.squares.is_some() { &self.rest } else { &self.full };
        for c in &self.components {
            let size = c.len();
            self.block.clear();
            self.block.extend(c.iter().flat_map(|&i| c.iter().map(move |&j| (i, j))).map(|(i, j)| clipped[i * n + j]));
            clip_to_psd(&mut self.block, size, &mut self.scratch);
            for a in 0..size {
                for b in a..size {
                    let square = self.gauss_newton.get(c[a] * n + c[b]).unwrap_or(&0.0);
                    hessian[at] += weight * (self.block[a * size + b] + square);
                    at += 1;
                }
            }
        }
    }
}
