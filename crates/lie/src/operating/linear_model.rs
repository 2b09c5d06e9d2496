//! The linear system around a point, as formulas and as numbers.

use std::collections::BTreeMap;

use bracketry_symbolic::{Bindings, Evaluation, Expr, Function, Node, Pool, Symbol, Tape};
use bracketry_system::{Point, System};
use nalgebra::DMatrix;
use rustc_hash::FxHashMap;
use serde::{Serialize, Serializer};

use crate::error::Error;
use crate::linear::matrix::RationalMatrix;
use crate::linear::zeros::Quadruple;
use crate::regular::regular_at;
use crate::residues::Fp;

/// A matrix of a linear system.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinearMatrix {
    /// Each entry as a formula of the parameters; of states and inputs too, where their values at the point are not exact.
    pub formulas: Vec<Vec<Function>>,
    /// The numbers at the point, parameters at their values.
    #[serde(serialize_with = "rows")]
    pub values: DMatrix<f64>,
}

pub(crate) fn rows<S: Serializer>(m: &DMatrix<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(m.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>()))
}

/// Whether the system rests at the point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Rest {
    /// All derivatives are zero.
    Equilibrium,
    /// All derivatives are zero but for rounding; the point is taken for an equilibrium.
    WithinRounding {
        /// The largest derivative.
        residual: f64,
    },
    /// The linear system describes deviations from a motion with these derivatives at the point, not from rest.
    Moving {
        /// The largest derivative.
        residual: f64,
    },
}

/// x' = A x + B u, y = C x + D u for deviations from a point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinearModel {
    /// Name of the model.
    pub model: String,
    /// Names of the states.
    pub states: Vec<String>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Inputs that act later than they are commanded, with their delays: u stands for the inputs as they arrive.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub input_delays: BTreeMap<String, f64>,
    /// Names of the outputs; the states where the model has no outputs.
    pub outputs: Vec<String>,
    /// Whether the outputs are the states because the model has none.
    pub states_are_outputs: bool,
    /// States, then inputs, at the point.
    pub point: Vec<f64>,
    /// Whether it is an equilibrium.
    pub rest: Rest,
    /// n × n.
    pub a: LinearMatrix,
    /// n × m.
    pub b: LinearMatrix,
    /// p × n.
    pub c: LinearMatrix,
    /// p × m.
    pub d: LinearMatrix,
    /// A, B, C, D where all entries are rational.
    #[serde(skip)]
    pub(crate) rational: Option<[RationalMatrix; 4]>,
    /// A, B, C modulo the prime, in one frame, where all entries are constants that have values there and some are irrational.
    #[serde(skip)]
    pub(crate) residues: Option<[Vec<Vec<Fp>>; 3]>,
}

impl LinearModel {
    pub(crate) fn quadruple(&self) -> Quadruple {
        let [a, b, c, d] = [&self.a, &self.b, &self.c, &self.d].map(|m| m.values.clone());
        Quadruple { a, b, c, d }
    }
}

/// Why there is no linear system.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotLinearizable {
    /// The equations use a derivative of an input.
    #[error(
        "the equations use derivatives of the input {input}: make the model affine first, so that they become states"
    )]
    InputDerivative {
        /// The input.
        input: String,
    },
    /// The equations have a jump or a kink at the point.
    #[error("the equations jump or have a kink where {name} = 0, as at this point: linearize at a nearby point")]
    NotSmooth {
        /// The switching function.
        name: String,
    },
    /// The equations have no value at the point, or jump there.
    #[error(transparent)]
    Irregular(#[from] Error),
    /// A derivative has no finite value.
    #[error("the derivative of {of} with respect to {by} has no finite value at the point")]
    NotFinite {
        /// Rate of a state, such as x', or output.
        of: String,
        /// State or input.
        by: String,
    },
}

/// Sizes below this, relative to the terms of an equation, are rounding.
const ROUNDING: f64 = 1e-9;

/// Rows of a matrix of constants.
type Constants = Vec<Vec<Expr>>;

/// What the entries of the matrices are formed of.
struct Frame {
    system: System,
    /// States and inputs whose values are exact.
    at: FxHashMap<Expr, Expr>,
    variables: Vec<Symbol>,
    point: Vec<f64>,
}

impl LinearModel {
    /// At the point of the model, or at 0 where it has none.
    ///
    /// # Errors
    /// [`NotLinearizable`] where the equations are not smooth there.
    pub fn new(original: &System) -> Result<LinearModel, NotLinearizable> {
        if let Some(d) = original.input_derivatives.first() {
            let input = original.symbol_name(original.inputs[d.input]).to_owned();
            return Err(NotLinearizable::InputDerivative { input });
        }
        let mut system = original.clone();
        let zero = system.pool.int(0);
        let origin = || Point { states: vec![zero; original.states.len()], inputs: vec![zero; original.inputs.len()] };
        let point = system.point.clone().unwrap_or_else(origin);
        regular_at(&mut system, &point)?;
        let mut frame = Frame::new(original);
        let (dynamics, outputs) = frame.smooth_equations()?;
        let (states, inputs) = (original.states.clone(), original.inputs.clone());
        let of = |k: usize| match k.checked_sub(states.len()) {
            None => format!("{}'", original.symbol_name(states[k])),
            Some(k) => original.outputs.get(k).map_or_else(String::new, |o| o.0.clone()),
        };
        let states_are_outputs = original.outputs.is_empty();
        let output_rows: Vec<Expr> =
            if states_are_outputs { states.iter().map(|&x| frame.system.pool.sym(x)).collect() } else { outputs };
        let mut entries = Vec::new();
        let mut make = |rows: &[Expr], by: &[Symbol], first: usize| -> Result<LinearMatrix, NotLinearizable> {
            let (matrix, constants) = frame.matrix(rows, by).map_err(|(i, j)| NotLinearizable::NotFinite {
                of: of(i + first),
                by: original.symbol_name(by[j]).to_owned(),
            })?;
            entries.push(constants);
            Ok(matrix)
        };
        let (n, m) = (states.len(), inputs.len());
        let (a, b) = (make(&dynamics, &states, 0)?, make(&dynamics, &inputs, 0)?);
        let (c, d) = (make(&output_rows, &states, n)?, make(&output_rows, &inputs, n)?);
        let rest = frame.rest(&dynamics, &a.values);
        let rational = entries.iter().zip([n, m, n, m]).map(|(rows, columns)| frame.rational(rows, columns));
        let rational: Option<[RationalMatrix; 4]> =
            rational.collect::<Option<Vec<_>>>().and_then(|list| list.try_into().ok());
        let residues = if rational.is_some() { None } else { frame.residues(&entries[..3]) };
        let residues = residues.and_then(|list| list.try_into().ok());
        let outputs = if states_are_outputs {
            original.state_names()
        } else {
            original.outputs.iter().map(|o| o.0.clone()).collect()
        };
        Ok(LinearModel {
            model: original.name.clone(),
            states: original.state_names(),
            inputs: original.input_names(),
            input_delays: original.delays_by_name(),
            outputs,
            states_are_outputs,
            point: frame.point,
            rest,
            a,
            b,
            c,
            d,
            rational,
            residues,
        })
    }
}

impl Frame {
    fn new(original: &System) -> Self {
        let mut system = original.clone();
        let variables: Vec<Symbol> = system.states.iter().chain(&system.inputs).copied().collect();
        let zero = system.pool.int(0);
        let constants: Vec<Expr> = match &system.point {
            Some(p) => p.states.iter().chain(&p.inputs).copied().collect(),
            None => vec![zero; variables.len()],
        };
        let point: Vec<f64> = constants.iter().map(|&c| system.value(c).unwrap_or(f64::NAN)).collect();
        // A number with as many digits as a double is a result of rounding, and no formula.
        let mut at = FxHashMap::default();
        for (&s, &c) in variables.iter().zip(&constants) {
            let long = system.pool.number(c).is_some_and(|q| q.denominator().to_string().len() > 9);
            if !long {
                at.insert(system.pool.sym(s), c);
            }
        }
        Frame { system, at, variables, point }
    }

    fn numbers(&self, expressions: &[Expr]) -> Vec<f64> {
        let mut out = vec![f64::NAN; expressions.len()];
        if let Ok(tape) = self.system.compile(&self.variables, expressions) {
            tape.eval(&self.point, &mut Vec::new(), &mut out);
        }
        out
    }

    /// Dynamics and outputs with every switching function at its sign; where one vanishes, they and their derivatives must
    /// not depend on its sign at the point.
    fn smooth_equations(&mut self) -> Result<(Vec<Expr>, Vec<Expr>), NotLinearizable> {
        let form = self.system.switched_form();
        let n = form.dynamics.len();
        let all: Vec<Expr> = form.dynamics.iter().chain(&form.outputs).copied().collect();
        let surfaces: Vec<Expr> = form.switches.iter().map(|s| s.surface).collect();
        let mut signs = FxHashMap::default();
        let mut open = Vec::new();
        for (switch, &surface) in form.switches.iter().zip(&surfaces) {
            let surface = self.system.pool.substitute(surface, &signs);
            let value = self.numbers(&[surface])[0];
            let sign = self.system.pool.sym(switch.sign);
            if value.abs() <= ROUNDING {
                open.push((switch.clone(), sign));
            }
            let number = self.system.pool.int(if value < 0.0 { -1 } else { 1 });
            signs.insert(sign, number);
        }
        for (switch, sign) in open {
            let others: FxHashMap<Expr, Expr> =
                signs.iter().filter(|(s, _)| **s != sign).map(|(&a, &b)| (a, b)).collect();
            let free = self.system.pool.substitute_all(&all, &others);
            let mut local = free.clone();
            for &e in &free {
                local.extend(self.system.pool.gradient(e, &self.variables));
            }
            let [up, down] = [1, -1].map(|value| {
                let value = self.system.pool.int(value);
                self.system.pool.substitute_all(&local, &FxHashMap::from_iter([(sign, value)]))
            });
            let (up, down) = (self.numbers(&up), self.numbers(&down));
            if up.iter().zip(&down).any(|(a, b)| (a - b).is_nan() || (a - b).abs() > ROUNDING * (1.0 + a.abs())) {
                return Err(NotLinearizable::NotSmooth { name: switch.name });
            }
        }
        let mut smooth = self.system.pool.substitute_all(&all, &signs);
        let outputs = smooth.split_off(n);
        Ok((smooth, outputs))
    }

    /// The Jacobian at the point; the entry that has no finite value otherwise.
    fn matrix(&mut self, rows: &[Expr], by: &[Symbol]) -> Result<(LinearMatrix, Constants), (usize, usize)> {
        let (mut formulas, mut constants) = (Vec::new(), Vec::new());
        let mut values = DMatrix::zeros(rows.len(), by.len());
        for (i, &e) in rows.iter().enumerate() {
            let gradient = self.system.pool.gradient(e, by);
            for (j, value) in self.numbers(&gradient).into_iter().enumerate() {
                if !value.is_finite() {
                    return Err((i, j));
                }
                values[(i, j)] = value;
            }
            let here: Vec<Expr> = self
                .system
                .pool
                .substitute_all(&gradient, &self.at)
                .into_iter()
                .map(|e| tidied(&mut self.system.pool, e))
                .collect();
            let with_values: Vec<Expr> =
                self.system.with_values(&here).into_iter().map(|e| self.system.pool.simplify(e)).collect();
            for (j, &e) in with_values.iter().enumerate() {
                // Without rounding where the point is known exactly.
                if let Some(value) = self.system.pool.constant_value(e, &Bindings::default()) {
                    values[(i, j)] = value;
                }
            }
            formulas.push(Function::list(&self.system.pool, &here));
            constants.push(with_values);
        }
        Ok((LinearMatrix { formulas, values }, constants))
    }

    /// A matrix of constants with `columns` columns, where all are rational.
    fn rational(&self, rows: &[Vec<Expr>], columns: usize) -> Option<RationalMatrix> {
        let number = |&e: &Expr| self.system.pool.number(e).cloned();
        let rows: Option<Vec<Vec<_>>> = rows.iter().map(|row| row.iter().map(number).collect()).collect();
        rows.map(|rows| RationalMatrix::new(rows, columns))
    }

    /// Matrices of constants modulo the prime.
    fn residues(&mut self, matrices: &[Constants]) -> Option<Vec<Vec<Vec<Fp>>>> {
        let pool = &mut self.system.pool;
        let all = matrices.concat().concat();
        // At a point that is known to rounding only, entries are no constants.
        if !pool.symbols_of(&all).is_empty() {
            return None;
        }
        let mut values = pool.evaluate(&mut Evaluation::new(Bindings::new()), &all).ok()?.values.pop()?.into_iter();
        Some(matrices.iter().map(|m| m.iter().map(|row| values.by_ref().take(row.len()).collect()).collect()).collect())
    }

    fn rest(&mut self, dynamics: &[Expr], a: &DMatrix<f64>) -> Rest {
        let values = self.numbers(dynamics);
        let residual = values.iter().map(|v| v.abs()).max_by(f64::total_cmp).unwrap_or(0.0);
        let here = self.system.pool.substitute_all(dynamics, &self.at);
        let exact = self.system.with_values(&here).into_iter().all(|e| {
            let e = self.system.pool.simplify(e);
            self.system.pool.is_zero(e) || self.system.pool.zero_test(e, &Bindings::default()).is_zero()
        });
        if exact && self.at.len() == self.variables.len() {
            return Rest::Equilibrium;
        }
        let scale = |i: usize| -> f64 { (0..a.ncols()).map(|j| a[(i, j)].abs() * self.point[j].abs().max(1.0)).sum() };
        let rounding = values.iter().enumerate().all(|(i, v)| v.abs() <= ROUNDING * (1.0 + scale(i)));
        if rounding { Rest::WithinRounding { residual } } else { Rest::Moving { residual } }
    }
}

/// Simplified, with numbers for constants such as cos(pi) that are whole or half.
fn tidied(pool: &mut Pool, e: Expr) -> Expr {
    let mut numbers = FxHashMap::default();
    for n in pool.reachable(&[e]) {
        if !matches!(pool.node(n), Node::Call(..)) || !pool.symbols_of(&[n]).is_empty() {
            continue;
        }
        let Ok(tape) = Tape::compile(pool, &[], &[n]) else { continue };
        let mut out = [f64::NAN];
        tape.eval(&[], &mut Vec::new(), &mut out);
        let twice = (2.0 * out[0]).round();
        if (2.0 * out[0] - twice).abs() < 1e-12 && twice.abs() < 1e9 {
            let number = pool.ratio(twice as i64, 2);
            let difference = pool.sub(n, number);
            if pool.zero_test(difference, &Bindings::default()).is_zero() {
                numbers.insert(n, number);
            }
        }
    }
    let e = pool.substitute(e, &numbers);
    pool.simplify(e)
}
