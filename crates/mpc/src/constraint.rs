//! Constraints beyond bounds: functions of states and inputs, norms of them, a set for the last state.

use crate::cost::{CostKind, CostNames};
use crate::error::{MpcError, check_length};
use crate::ocp::{Bounds, Ocp, Softness, ordered, positive, weight};
use crate::trajectory::Trajectory;
use bracketry_native::{Function, Workspace};
use bracketry_symbolic::{Expr, Pool, Symbol, Tape};
use bracketry_system::System;
use nalgebra::{DMatrix, SymmetricEigen};
use std::ops::Range;

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
    arguments: Vec<f64>,
    work: Workspace,
    out: Vec<f64>,
}

impl VectorFunction {
    /// Reads one expression per component over the names of a system, the time `t` and references.
    ///
    /// ```
    /// use bracketry_mpc::VectorFunction;
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
        Ok(Self {
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
        self.derivatives.call(&self.arguments, &mut self.work, &mut self.out);
        self.out.split_at(self.outputs)
    }

    fn check(&self, what: &'static str, states: usize, inputs: usize) -> Result<(), MpcError> {
        check_length(what, self.variables, states + inputs)?;
        check_length(what, self.states, states)
    }
}

/// Grid points at which a constraint holds: those with an input when it depends on inputs, else those after the first,
/// whose state nothing can change.
fn grid_points(uses_inputs: bool, steps: usize) -> Range<usize> {
    if uses_inputs { 0..steps } else { 1..steps + 1 }
}

/// min ≤ g(x, u, t, r) ≤ max, at the grid points 0 … N−1 if g depends on an input, else 1 … N. In a quadratic program it is
/// linearised.
#[derive(Clone)]
pub struct PathConstraint {
    /// The function g, with one component.
    pub function: VectorFunction,
    /// Its bounds. Violations of hard ones are penalised per unit of g: scale g so that 1 is a large violation.
    pub bounds: Bounds,
}

impl PathConstraint {
    /// Grid points at which it holds.
    pub fn grid_points(&self, steps: usize) -> Range<usize> {
        grid_points(self.function.uses_inputs(), steps)
    }
}

/// ‖g(x, u, t, r)‖ ≤ h(x, u, t, r) with the Euclidean norm, at the grid points 0 … N−1 if either depends on an input, else
/// 1 … N: limits on the length of an input vector, friction cones. In a quadratic program g and h are linearised and the
/// norm stays, as a second-order cone.
#[derive(Clone)]
pub struct NormConstraint {
    /// The vector g.
    pub vector: VectorFunction,
    /// The limit h, with one component.
    pub limit: VectorFunction,
    /// What a violation ‖g‖ − h costs.
    pub softness: Softness,
}

impl NormConstraint {
    /// Grid points at which it holds.
    pub fn grid_points(&self, steps: usize) -> Range<usize> {
        grid_points(self.vector.uses_inputs() || self.limit.uses_inputs(), steps)
    }
}

/// (x_N − c)ᵀ P (x_N − c) ≤ α. Its violation is √((x_N − c)ᵀ P (x_N − c)) − √α.
#[derive(Clone, Debug, PartialEq)]
pub struct TerminalSet {
    /// P, row by row: symmetric, positive semidefinite.
    pub matrix: Vec<Vec<f64>>,
    /// The centre c.
    pub centre: Vec<f64>,
    /// The level α > 0.
    pub level: f64,
    /// What a violation v costs: linear·v + quadratic·v², without the factor dt of bounds along the horizon.
    pub softness: Softness,
}

/// Largest relative asymmetry and negative eigenvalue of a matrix that passes as symmetric and positive semidefinite.
const SEMIDEFINITE_TOLERANCE: f64 = 1e-9;

impl TerminalSet {
    fn eigen(&self) -> SymmetricEigen<f64, nalgebra::Dyn> {
        let n = self.centre.len();
        SymmetricEigen::new(DMatrix::from_fn(n, n, |i, j| f64::midpoint(self.matrix[i][j], self.matrix[j][i])))
    }

    /// Rows of a matrix W with WᵀW = P, so that the set is ‖W (x − c)‖ ≤ √α; directions without weight are left out.
    pub(crate) fn root(&self) -> Vec<Vec<f64>> {
        let eigen = self.eigen();
        let largest = eigen.eigenvalues.amax();
        (0..self.centre.len())
            .filter(|&i| eigen.eigenvalues[i] > SEMIDEFINITE_TOLERANCE * largest)
            .map(|i| eigen.eigenvectors.column(i).iter().map(|v| v * eigen.eigenvalues[i].sqrt()).collect())
            .collect()
    }

    fn violation(&self, x: &[f64]) -> f64 {
        let e: Vec<f64> = x.iter().zip(&self.centre).map(|(x, c)| x - c).collect();
        let square: f64 =
            self.matrix.iter().zip(&e).map(|(row, a)| a * row.iter().zip(&e).map(|(p, b)| p * b).sum::<f64>()).sum();
        (square.max(0.0).sqrt() - self.level.sqrt()).max(0.0)
    }

    fn check(&self, states: usize) -> Result<(), MpcError> {
        check_length("the centre of the terminal set", self.centre.len(), states)?;
        check_length("the matrix of the terminal set", self.matrix.len(), states)?;
        positive("the level of the terminal set", self.level)?;
        for row in &self.matrix {
            check_length("a row of the terminal set's matrix", row.len(), states)?;
        }
        for &value in self.matrix.iter().flatten().chain(&self.centre) {
            if !value.is_finite() {
                return Err(MpcError::Value {
                    what: "an entry of the terminal set".into(),
                    value,
                    remedy: "give a finite number",
                });
            }
        }
        let size = self.matrix.iter().flatten().fold(0.0, |a: f64, v| a.max(v.abs()));
        if size == 0.0 {
            return Err(MpcError::Value {
                what: "the largest entry of the terminal set's matrix".into(),
                value: size,
                remedy: "give a matrix that is not zero",
            });
        }
        for i in 0..states {
            for j in 0..i {
                let value = self.matrix[i][j] - self.matrix[j][i];
                if value.abs() > SEMIDEFINITE_TOLERANCE * size {
                    return Err(MpcError::Value {
                        what: format!("the asymmetry of the terminal set's matrix at ({i}, {j})"),
                        value,
                        remedy: "give a symmetric matrix",
                    });
                }
            }
        }
        let value = self.eigen().eigenvalues.min();
        if value < -SEMIDEFINITE_TOLERANCE * size {
            return Err(MpcError::Value {
                what: "the smallest eigenvalue of the terminal set's matrix".into(),
                value,
                remedy: "give a positive semidefinite matrix",
            });
        }
        soft_weights("the terminal set", self.softness)
    }
}

fn soft_weights(what: &str, softness: Softness) -> Result<(), MpcError> {
    if let Softness::Soft { linear, quadratic } = softness {
        weight(format!("the linear weight of {what}"), linear)?;
        weight(format!("the quadratic weight of {what}"), quadratic)?;
    }
    Ok(())
}

/// Violations and what they cost: v is in the unit of the constraint, `relative` is v over its scale if it is hard.
struct Violation {
    cost: f64,
    relative: f64,
}

impl Softness {
    /// Weights of a violation and of its square; `factor` is dt along the horizon, `hard` the weight of hard ones.
    pub(crate) fn weights(self, factor: f64, hard: f64) -> (f64, f64) {
        match self {
            Softness::Soft { linear, quadratic } => (factor * linear, factor * quadratic),
            Softness::Hard => (hard, 0.0),
        }
    }

    fn judge(self, v: f64, factor: f64, hard: f64, scale: f64) -> Violation {
        let (linear, quadratic) = self.weights(factor, hard / scale);
        Violation {
            cost: linear * v + quadratic * v * v,
            relative: if self == Softness::Hard { v / scale } else { 0.0 },
        }
    }
}

impl Ocp {
    /// Checks blocks, path constraints, norm constraints and the terminal set.
    pub(crate) fn check_constraints(&self, states: usize, inputs: usize) -> Result<(), MpcError> {
        for &length in &self.move_blocks {
            positive("the length of a move block", length as f64)?;
        }
        let intervals: usize = self.move_blocks.iter().sum();
        if !self.move_blocks.is_empty() && intervals < self.steps {
            return Err(MpcError::Length {
                what: "the sum of the move blocks",
                found: intervals,
                expected: self.steps,
            });
        }
        for (index, c) in self.path_constraints.iter().enumerate() {
            c.function.check("a path constraint's list of variables", states, inputs)?;
            check_length("a path constraint's function", c.function.outputs(), 1)?;
            ordered("path constraint", index, c.bounds.min, c.bounds.max)?;
            soft_weights("a path constraint", c.bounds.softness)?;
        }
        for c in &self.norm_constraints {
            c.vector.check("a norm constraint's list of variables", states, inputs)?;
            c.limit.check("a norm constraint's list of variables", states, inputs)?;
            check_length("a norm constraint's limit", c.limit.outputs(), 1)?;
            positive("the number of components of a norm constraint", c.vector.outputs() as f64)?;
            soft_weights("a norm constraint", c.softness)?;
        }
        self.terminal_set.as_ref().map_or(Ok(()), |s| s.check(states))
    }

    /// Largest number of references that a constraint asks for.
    pub(crate) fn constraint_references(&self) -> usize {
        let path = self.path_constraints.iter().map(|c| c.function.references());
        let norm = self.norm_constraints.iter().map(|c| c.vector.references().max(c.limit.references()));
        path.chain(norm).max().unwrap_or(0)
    }

    /// The first interval of the block that each interval belongs to. A horizon that has become shorter than the blocks has
    /// lost its first intervals.
    pub(crate) fn block_starts(&self, steps: usize) -> Vec<usize> {
        if self.move_blocks.is_empty() {
            return (0..steps).collect();
        }
        let lost = self.move_blocks.iter().sum::<usize>().saturating_sub(steps);
        let mut starts = Vec::with_capacity(steps);
        let mut begin = 0;
        for &length in &self.move_blocks {
            let first = begin.max(lost);
            begin += length;
            starts.extend((first..begin).map(|_| first - lost));
        }
        starts
    }

    /// Visits the violation of every path constraint, norm constraint and of the terminal set along a trajectory that starts
    /// at grid point `k0` of the run.
    fn visit_constraints(&mut self, k0: usize, z: &Trajectory, hard: f64, mut visit: impl FnMut(Violation)) {
        let (steps, dt) = (z.steps(), self.dt);
        let input = |k: usize| if k < steps { z.u(k) } else { &[] };
        let mut path = std::mem::take(&mut self.path_constraints);
        for c in &mut path {
            for k in c.grid_points(steps) {
                let t = (k0 + k) as f64 * dt;
                let g = c.function.values(z.x(k), input(k), t, self.reference(k0 + k))[0];
                visit(c.bounds.softness.judge(c.bounds.violation(g), dt, hard, 1.0));
            }
        }
        self.path_constraints = path;
        let mut norm = std::mem::take(&mut self.norm_constraints);
        for c in &mut norm {
            for k in c.grid_points(steps) {
                let t = (k0 + k) as f64 * dt;
                let r = self.reference(k0 + k);
                let g = c.vector.values(z.x(k), input(k), t, r).iter().map(|v| v * v).sum::<f64>().sqrt();
                let v = (g - c.limit.values(z.x(k), input(k), t, r)[0]).max(0.0);
                visit(c.softness.judge(v, dt, hard, 1.0));
            }
        }
        self.norm_constraints = norm;
        if let Some(s) = &self.terminal_set {
            visit(s.softness.judge(s.violation(z.x(steps)), 1.0, hard, s.level.sqrt()));
        }
    }

    /// Largest violation of a path or norm constraint, soft or hard, along a run of states x and inputs u (one fewer), each in
    /// its own unit; NaN when a constrained value is no number.
    pub fn largest_constraint_violation(&mut self, x: &[Vec<f64>], u: &[Vec<f64>]) -> f64 {
        let (steps, dt) = (u.len(), self.dt);
        let input = |k: usize| u.get(k).map_or(&[][..], Vec::as_slice);
        let mut values = vec![0.0];
        let mut path = std::mem::take(&mut self.path_constraints);
        for c in &mut path {
            for k in c.grid_points(steps) {
                let g = c.function.values(&x[k], input(k), k as f64 * dt, self.reference(k))[0];
                values.push(if g.is_nan() { g } else { c.bounds.violation(g) });
            }
        }
        self.path_constraints = path;
        let mut norm = std::mem::take(&mut self.norm_constraints);
        for c in &mut norm {
            for k in c.grid_points(steps) {
                let (t, r) = (k as f64 * dt, self.reference(k));
                let g = c.vector.values(&x[k], input(k), t, r).iter().map(|v| v * v).sum::<f64>().sqrt();
                values.push(g - c.limit.values(&x[k], input(k), t, r)[0]);
            }
        }
        self.norm_constraints = norm;
        // `f64::max` would drop a NaN.
        values.into_iter().fold(0.0, |worst: f64, v| if worst.is_nan() || v.is_nan() { f64::NAN } else { worst.max(v) })
    }

    /// Cost of violated path and norm constraints and of leaving the terminal set; hard ones at `hard` per unit of scale.
    pub(crate) fn constraint_penalty(&mut self, k0: usize, trajectory: &Trajectory, hard: f64) -> f64 {
        let mut sum = 0.0;
        self.visit_constraints(k0, trajectory, hard, |v| sum += v.cost);
        sum
    }

    /// Largest violation of a hard path or norm constraint or terminal set, in units of its scale.
    pub(crate) fn hard_constraint_violation(&mut self, k0: usize, trajectory: &Trajectory) -> f64 {
        let mut worst = 0.0_f64;
        self.visit_constraints(k0, trajectory, 0.0, |v| worst = worst.max(v.relative));
        worst
    }
}
