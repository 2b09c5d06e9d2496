//! Names in a model: what terms may use, and the states and inputs that a name stands for.

use bracketry_symbolic::{Expr, Names, Notation, Pool, Symbol};
use bracketry_system::{InputDerivative, System};
use rustc_hash::FxHashMap;

use crate::effect::Coefficient;
use crate::error::DiagnoseError;

/// What terms call the time since the start of a record, in seconds.
///
/// Equations of a model contain no time. An effect that needs it adds an input of this name, to be driven by the times
/// of the record.
pub const TIME_INPUT: &str = "time";

/// The name of a derivative of an input, as expressions print it.
pub(crate) fn derivative_name(input: &str, order: u32) -> String {
    if order == 1 { format!("der({input})") } else { format!("der({input}, {order})") }
}

/// States, inputs and parameters of a model.
pub(crate) fn symbols(system: &System) -> impl Iterator<Item = Symbol> {
    let moving = system.states.iter().chain(&system.inputs).copied();
    moving.chain(system.parameters.iter().map(|p| p.symbol))
}

/// The place of a state.
///
/// # Errors
/// [`DiagnoseError::UnknownName`].
pub(crate) fn state_index(system: &System, name: &str) -> Result<usize, DiagnoseError> {
    system.state_index(name).ok_or_else(|| unknown("state", name, &system.state_names()))
}

/// The place of an input.
///
/// # Errors
/// [`DiagnoseError::UnknownName`].
pub(crate) fn input_index(system: &System, name: &str) -> Result<usize, DiagnoseError> {
    system.input_index(name).ok_or_else(|| unknown("input", name, &system.input_names()))
}

/// That a name is none of those that are known.
pub(crate) fn unknown(what: &'static str, name: &str, known: &[String]) -> DiagnoseError {
    DiagnoseError::UnknownName { what, name: name.to_owned(), known: known.join(", ") }
}

/// The names of a model, for reading terms. Derivatives of inputs that the model does not use yet are made.
pub(crate) struct ModelNames {
    plain: FxHashMap<String, Expr>,
    inputs: Vec<(String, Symbol)>,
    /// Derivatives used so far; those of the model come first.
    derivatives: Vec<InputDerivative>,
    /// Whether [`TIME_INPUT`] stands for an input that the model does not have.
    time_is_free: bool,
    /// Set when a term uses the time.
    uses_time: bool,
}

impl ModelNames {
    pub(crate) fn new(system: &mut System) -> Self {
        let mut plain: FxHashMap<String, Expr> = system.definitions.iter().cloned().collect();
        for s in symbols(system).collect::<Vec<_>>() {
            let e = system.pool.sym(s);
            plain.insert(system.pool.name(s).to_owned(), e);
        }
        let inputs = system.input_names().into_iter().zip(system.inputs.iter().copied()).collect();
        ModelNames {
            time_is_free: !plain.contains_key(TIME_INPUT),
            plain,
            inputs,
            derivatives: system.input_derivatives.clone(),
            uses_time: false,
        }
    }

    /// Lets expressions use the coefficients of an effect that is not applied yet.
    pub(crate) fn with_coefficients(mut self, pool: &mut Pool, coefficients: &[Coefficient]) -> Self {
        for c in coefficients {
            let e = pool.var(&c.name);
            self.plain.insert(c.name.clone(), e);
        }
        self
    }

    /// Lets expressions use another name.
    pub(crate) fn add(&mut self, name: &str, e: Expr) {
        self.plain.insert(name.to_owned(), e);
    }

    /// Reads an expression.
    pub(crate) fn read(&mut self, pool: &mut Pool, text: &str) -> Result<Expr, DiagnoseError> {
        pool.parse_with(text, self).map_err(|e| DiagnoseError::Term { text: text.to_owned(), message: e.to_string() })
    }

    /// The layout of an expression, derivatives of inputs with dots.
    pub(crate) fn notation(&self, pool: &Pool, e: Expr) -> Notation {
        pool.notation(e).with_symbols(&|name| {
            let d = self.derivatives.iter().find(|d| pool.name(d.symbol) == name)?;
            Some(Notation::symbol(&*self.inputs[d.input].0).dotted(d.order))
        })
    }

    /// Registers in the system what terms have used beyond what it had.
    pub(crate) fn register(self, system: &mut System) {
        system.input_derivatives = self.derivatives;
        if self.uses_time {
            let symbol = system.pool.symbol(TIME_INPUT);
            system.inputs.push(symbol);
            if let Some(point) = &mut system.point {
                point.inputs.push(system.pool.int(0));
            }
        }
    }
}

impl Names for ModelNames {
    fn lookup(&mut self, pool: &mut Pool, name: &str) -> Option<Expr> {
        if self.time_is_free && name == TIME_INPUT {
            self.uses_time = true;
            return Some(pool.var(TIME_INPUT));
        }
        self.plain.get(name).copied()
    }

    fn derivative(&mut self, pool: &mut Pool, name: &str, order: u32) -> Option<Expr> {
        let input = self.inputs.iter().position(|(n, _)| n == name)?;
        let known = self.derivatives.iter().find(|d| d.input == input && d.order == order).map(|d| d.symbol);
        let symbol = known.unwrap_or_else(|| {
            let symbol = pool.symbol(&derivative_name(name, order));
            self.derivatives.push(InputDerivative { input, order, symbol });
            symbol
        });
        Some(pool.sym(symbol))
    }

    fn known(&self) -> Vec<String> {
        let mut known: Vec<String> = self.plain.keys().cloned().collect();
        known.sort_unstable();
        known
    }
}
