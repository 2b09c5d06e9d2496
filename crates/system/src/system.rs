//! A control system x' = f(x, u, u', …; p) with outputs and a point of interest.

use std::collections::BTreeMap;

use bracketry_files::{Document, FileError};
use bracketry_symbolic::{CompileError, Expr, Pool, Rational, Symbol, Tape};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::quantities::Quantities;

/// A named constant of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its symbol in the system's pool.
    pub symbol: Symbol,
    /// Exact value.
    pub value: Rational,
    /// Smallest admissible value.
    pub min: Option<Rational>,
    /// Largest admissible value.
    pub max: Option<Rational>,
    /// Unit, as free text.
    pub unit: Option<String>,
    /// Description.
    pub about: Option<String>,
}

impl Parameter {
    /// Whether its bounds leave it no value but its own, as with `fixed = true` in a model file: no fit changes it.
    pub fn is_fixed(&self) -> bool {
        self.min.as_ref() == Some(&self.value) && self.max.as_ref() == Some(&self.value)
    }
}

/// A time derivative of an input that the equations use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputDerivative {
    /// Index of the input.
    pub input: usize,
    /// Order, from 1.
    pub order: u32,
    /// The symbol that stands for it.
    pub symbol: Symbol,
}

/// Where local statements are made: constant expressions for every state and input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Point {
    /// One value per state.
    pub states: Vec<Expr>,
    /// One value per input.
    pub inputs: Vec<Expr>,
}

/// The values that an input can take, ends included.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputRange {
    /// The input.
    pub input: Symbol,
    /// Smallest value; none if there is no limit.
    pub min: Option<Rational>,
    /// Largest value; none if there is no limit.
    pub max: Option<Rational>,
}

/// How much later than it is commanded an input acts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputDelay {
    /// The input.
    pub input: Symbol,
    /// Seconds, not negative: an expression of parameters.
    pub delay: Expr,
}

/// How far the argument of a sign or unit vector may go before what sticks breaks loose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StaticLevel {
    /// The switching function, or the components of the unit vector, as they are written in the equations.
    pub components: Vec<Expr>,
    /// Static level over sliding level, at least 1: an expression of parameters.
    pub ratio: Expr,
}

/// What was eliminated when a model was read, so that its equations are x' = f(x, u).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Eliminated {
    /// An algebraic variable: its equations were solved for it. A definition of this name holds its value.
    Variable {
        /// Its name.
        name: String,
    },
    /// A mass matrix M of M(x) x' = f: the equations were solved for the derivatives of these states.
    MassMatrix {
        /// Their names.
        states: Vec<String>,
    },
}

impl std::fmt::Display for Eliminated {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Variable { name } => {
                write!(f, "the algebraic variable `{name}` is eliminated: the algebraic equations are solved for it")
            }
            Self::MassMatrix { states } => write!(
                f,
                "the mass matrix is eliminated: the equations are solved for the derivatives of {}",
                states.join(", ")
            ),
        }
    }
}

/// An algebraic variable z and the equation g(x, z, u) = 0 that stands beside the dynamics. Together, the equations determine all
/// algebraic variables: ∂g/∂z is regular (index 1).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Algebraic {
    /// Its symbol, which dynamics, definitions and outputs may contain.
    pub symbol: Symbol,
    /// The residual g.
    pub residual: Expr,
    /// Where the search for the value starts: a constant expression. It selects the branch where there are several solutions.
    pub guess: Expr,
}

/// A control system x' = f(x, u, u', …; p), read from a model file or made by an analysis.
///
/// Where inputs have delays, u stands for the delayed input u(t − d), in the equations and in everything said about them.
///
/// Definitions are expanded; parameters stay symbols with exact values.
#[derive(Clone, Default)]
pub struct System {
    /// Name of the model.
    pub name: String,
    /// The arena of every expression below.
    pub pool: Pool,
    /// The states, in order.
    pub states: Vec<Symbol>,
    /// The inputs, in order.
    pub inputs: Vec<Symbol>,
    /// Inputs that do not take all real values. Verdicts at the point respect them; ranks, which any open set of values has in
    /// common, need not.
    pub input_ranges: Vec<InputRange>,
    /// Inputs that act later than they are commanded.
    pub input_delays: Vec<InputDelay>,
    /// Input derivatives that occur in the equations, by input and order.
    pub input_derivatives: Vec<InputDerivative>,
    /// The parameters, in order.
    pub parameters: Vec<Parameter>,
    /// Named sub-expressions of the model file, expanded.
    pub definitions: Vec<(String, Expr)>,
    /// Time derivative of each state; its next value where the model is discrete in time.
    pub dynamics: Vec<Expr>,
    /// The period of a model that is discrete in time, x(t + period) = f(x, u), in seconds; none in continuous time. Only a reader
    /// that [accepts](crate::Accepted) such models gets one.
    pub period: Option<f64>,
    /// Algebraic variables that could not be eliminated. Only a reader that [accepts](crate::Accepted) them gets any.
    pub algebraic: Vec<Algebraic>,
    /// What was eliminated when the model was read.
    pub eliminated: Vec<Eliminated>,
    /// Measured outputs.
    pub outputs: Vec<(String, Expr)>,
    /// Functions that were written and cancel, as √x in (√x)²: where one of them has no value, the equations as written have none.
    pub canceled: Vec<Expr>,
    /// Static levels of dry friction above the sliding one.
    pub static_levels: Vec<StaticLevel>,
    /// Where local statements are made.
    pub point: Option<Point>,
    /// Units and labels, which reports and figures show.
    pub quantities: Quantities,
}

impl System {
    /// Finds the functions that cancel, right after reading: they were made and are not part of what was read. `others` are further
    /// equations, `met` what names stood for; a definition that no text names may have functions of its own.
    pub(crate) fn find_canceled(&mut self, others: impl IntoIterator<Item = Expr>, met: &FxHashSet<Expr>) {
        let mut roots = self.dynamics.clone();
        roots.extend(self.outputs.iter().map(|o| o.1));
        roots.extend(others);
        // Definitions are read over each other's names, which are expanded later.
        let mut names: FxHashSet<Symbol> = FxHashSet::default();
        for (name, e) in &self.definitions {
            let symbol = self.pool.symbol(name);
            names.insert(symbol);
            if !met.contains(e) && !met.contains(&self.pool.sym(symbol)) {
                roots.push(*e);
            }
        }
        self.canceled = self.pool.unused_partial_functions(&roots);
        self.canceled.retain(|&e| self.pool.symbols_of(&[e]).iter().all(|s| !names.contains(s)));
    }

    /// Name of a symbol.
    pub fn symbol_name(&self, s: Symbol) -> &str {
        self.pool.name(s)
    }

    /// Names of the states, in order.
    pub fn state_names(&self) -> Vec<String> {
        self.states.iter().map(|&s| self.pool.name(s).to_owned()).collect()
    }

    /// Names of the inputs, in order.
    pub fn input_names(&self) -> Vec<String> {
        self.inputs.iter().map(|&s| self.pool.name(s).to_owned()).collect()
    }

    /// Least and greatest value of an input in its unit, infinite where there is no limit; none for an input without a range.
    pub fn range_of_input(&self, input: usize) -> Option<(f64, f64)> {
        let range = self.input_ranges.iter().find(|r| r.input == self.inputs[input])?;
        let end = |r: &Option<Rational>, free: f64| r.as_ref().map_or(free, |r| r.to_f64().value());
        Some((end(&range.min, f64::NEG_INFINITY), end(&range.max, f64::INFINITY)))
    }

    /// Names of the parameters, in order.
    pub fn parameter_names(&self) -> Vec<String> {
        self.parameters.iter().map(|p| self.pool.name(p.symbol).to_owned()).collect()
    }

    /// Index of the state called `name`.
    pub fn state_index(&self, name: &str) -> Option<usize> {
        self.states.iter().position(|&s| self.pool.name(s) == name)
    }

    /// Index of the input called `name`.
    pub fn input_index(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|&s| self.pool.name(s) == name)
    }

    /// What the model calls `t`, if anything: state, input or parameter.
    ///
    /// A model may have such a name: its equations contain no time, so that there it means one thing only. Where `t` is time
    /// as well (scenarios, costs, tables of data), such a model is ambiguous and has to be refused.
    pub fn declares_time(&self) -> Option<&'static str> {
        let named = |list: &[Symbol]| list.iter().any(|&s| self.pool.name(s) == "t");
        let parameters: Vec<Symbol> = self.parameters.iter().map(|p| p.symbol).collect();
        [("state", &self.states), ("input", &self.inputs), ("parameter", &parameters)]
            .into_iter()
            .find(|(_, list)| named(list))
            .map(|(kind, _)| kind)
    }

    /// Refuses a model that calls something `t`, for a document in which `t` is time.
    ///
    /// # Errors
    /// [`FileError`] that names the kind.
    pub fn leaves_time_free(&self, document: &Document) -> Result<(), FileError> {
        match self.declares_time() {
            None => Ok(()),
            Some(kind) => Err(document.missing(
                format!("the model calls a {kind} `t`, which is time here"),
                format!("rename the {kind} in the model"),
            )),
        }
    }

    /// Gives a parameter another value; false if there is none of that name.
    pub fn set_parameter(&mut self, name: &str, value: Rational) -> bool {
        let pool = &self.pool;
        match self.parameters.iter_mut().find(|p| pool.name(p.symbol) == name) {
            Some(p) => {
                p.value = value;
                true
            }
            None => false,
        }
    }

    /// The expressions with every parameter replaced by its exact value, made in the system's pool.
    pub fn with_values(&mut self, expressions: &[Expr]) -> Vec<Expr> {
        valued(&mut self.pool, &self.parameters, expressions)
    }

    /// Compiles expressions as functions of `arguments`, parameters at their values.
    ///
    /// # Errors
    /// [`CompileError::Unbound`] if something else than arguments and parameters is used.
    pub fn compile(&self, arguments: &[Symbol], expressions: &[Expr]) -> Result<Tape, CompileError> {
        let (mut pool, expressions) = self.pool.extract(expressions);
        let values = valued(&mut pool, &self.parameters, &expressions);
        Tape::compile(&pool, arguments, &values)
    }

    /// The value of a constant expression, parameters at their values; `None` if it is no number.
    pub fn value(&self, constant: Expr) -> Option<f64> {
        let tape = self.compile(&[], &[constant]).ok()?;
        let mut out = [f64::NAN];
        tape.eval(&[], &mut Vec::new(), &mut out);
        (!out[0].is_nan()).then_some(out[0])
    }

    /// The delay of every input in seconds, parameters at their values; 0 where there is none, `None` where it is no number.
    pub fn delay_values(&self) -> Vec<Option<f64>> {
        let of = |u: &Symbol| self.input_delays.iter().find(|d| d.input == *u);
        self.inputs.iter().map(|u| of(u).map_or(Some(0.0), |d| self.value(d.delay))).collect()
    }

    /// The inputs that act later than they are commanded, with their delays.
    pub fn delays_by_name(&self) -> BTreeMap<String, f64> {
        let named = self.input_names().into_iter().zip(self.delay_values());
        named.filter_map(|(name, delay)| Some((name, delay.filter(|d| *d > 0.0)?))).collect()
    }

    /// The point as numbers, states and inputs; `None` if the model gives none.
    pub fn point_values(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let point = self.point.as_ref()?;
        let values = |list: &[Expr]| {
            let mut out = vec![0.0; list.len()];
            let tape = Tape::compile(&self.pool, &[], list).ok()?;
            tape.eval(&[], &mut Vec::new(), &mut out);
            Some(out)
        };
        Some((values(&point.states)?, values(&point.inputs)?))
    }

    /// Whether there is a point and all states and inputs have finite values there: not the new input 1/u at u = 0.
    pub fn point_is_finite(&self) -> bool {
        self.point_values().is_some_and(|(states, inputs)| states.iter().chain(&inputs).all(|v| v.is_finite()))
    }

    /// The system in which the algebraic variables are the last states, with the residuals of their equations as rates: (f, g) as a
    /// function of (x, z, u), to be evaluated and differentiated, not to be integrated.
    #[must_use]
    pub fn with_algebraic_states(&self) -> System {
        let mut system = self.clone();
        for z in std::mem::take(&mut system.algebraic) {
            system.states.push(z.symbol);
            system.dynamics.push(z.residual);
            if let Some(point) = &mut system.point {
                point.states.push(z.guess);
            }
        }
        system
    }

    /// States, then inputs, then input derivatives: the usual arguments of a compiled right-hand side.
    pub fn arguments(&self) -> Vec<Symbol> {
        let mut a = self.states.clone();
        a.extend(&self.inputs);
        a.extend(self.input_derivatives.iter().map(|d| d.symbol));
        a
    }
}

/// Expressions of a pool with parameters at their values.
fn valued(pool: &mut Pool, parameters: &[Parameter], expressions: &[Expr]) -> Vec<Expr> {
    let values: FxHashMap<Expr, Expr> =
        parameters.iter().map(|p| (pool.sym(p.symbol), pool.rational(p.value.clone()))).collect();
    pool.substitute_all(expressions, &values)
}

impl std::fmt::Debug for System {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let equations: Vec<String> = self
            .states
            .iter()
            .zip(&self.dynamics)
            .map(|(&s, &e)| format!("{}' = {}", self.pool.name(s), self.pool.text(e)))
            .collect();
        f.debug_struct("System")
            .field("name", &self.name)
            .field("inputs", &self.input_names())
            .field("dynamics", &equations)
            .finish_non_exhaustive()
    }
}
