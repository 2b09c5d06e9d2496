//! Arguments of compiled equations: time, states, inputs, parameters, and what else they depend on.

use crate::error::MpcError;
use bracketry_symbolic::{Expr, Pool, Symbol};
use bracketry_system::System;

/// Symbols and numbers of the arguments (t, x, u, p, …) of a system's equations.
#[derive(Clone)]
pub(crate) struct Arguments {
    pub(crate) symbols: Vec<Symbol>,
    pub(crate) values: Vec<f64>,
    /// Places of the live parameters.
    live: Vec<usize>,
}

impl Arguments {
    /// The arguments of a system without derivatives of inputs, the parameters at their values, then `others` at 0.
    ///
    /// # Errors
    /// [`MpcError::InputDerivative`], or [`MpcError::NoSuchParameter`] for a live parameter that the system does not have.
    pub(crate) fn new(system: &mut System, live: &[&str], others: &[Symbol]) -> Result<Self, MpcError> {
        if let Some(d) = system.input_derivatives.first() {
            return Err(MpcError::InputDerivative { name: system.symbol_name(d.symbol).to_owned() });
        }
        let mut symbols = vec![system.pool.symbol("t")];
        symbols.extend(system.states.iter().chain(&system.inputs));
        let first = symbols.len();
        symbols.extend(system.parameters.iter().map(|p| p.symbol));
        symbols.extend(others);
        let mut values = vec![0.0; symbols.len()];
        for (value, p) in values[first..].iter_mut().zip(&system.parameters) {
            *value = p.value.to_f64().value();
        }
        let names = system.parameter_names();
        let place = |name: &&str| {
            let at = names.iter().position(|known| known == name);
            at.map(|i| first + i)
                .ok_or_else(|| MpcError::NoSuchParameter { name: (*name).to_owned(), known: names.clone() })
        };
        let live = live.iter().map(place).collect::<Result<Vec<usize>, MpcError>>()?;
        Ok(Self { symbols, values, live })
    }

    /// Number of live parameters.
    pub(crate) fn parameters(&self) -> usize {
        self.live.len()
    }

    /// Gives the live parameters their values.
    pub(crate) fn set_parameters(&mut self, parameters: &[f64]) {
        for (&place, &value) in self.live.iter().zip(parameters) {
            self.values[place] = value;
        }
    }

    /// Sets time, states and inputs.
    pub(crate) fn load(&mut self, t: f64, x: &[f64], u: &[f64]) {
        let (n, m) = (x.len(), u.len());
        self.values[0] = t;
        self.values[1..=n].copy_from_slice(x);
        self.values[1 + n..1 + n + m].copy_from_slice(u);
    }
}

/// Places (i, j) and expressions of the entries ∂f_i/∂v_j that are not zero, row by row.
pub(crate) fn sparse_jacobian(pool: &mut Pool, functions: &[Expr], variables: &[Symbol]) -> Vec<(usize, usize, Expr)> {
    let mut entries = Vec::new();
    for (i, row) in pool.jacobian(functions, variables).into_iter().enumerate() {
        entries.extend(row.into_iter().enumerate().filter(|(_, e)| !pool.is_zero(*e)).map(|(j, e)| (i, j, e)));
    }
    entries
}
