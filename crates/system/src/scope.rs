//! The names that the equations of a model may use.

use std::collections::BTreeMap;

use bracketry_symbolic::{Expr, Names, Pool, Symbol};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::system::InputDerivative;

/// Declared names, and the derivatives of inputs.
pub(crate) struct Scope<'a> {
    pub(crate) plain: &'a FxHashMap<String, Expr>,
    pub(crate) inputs: &'a [String],
    pub(crate) derivatives: &'a mut Derivatives,
    /// What names stood for, of those that were met.
    pub(crate) met: &'a mut FxHashSet<Expr>,
}

/// der(u, k) met so far: (input, order) → symbol.
#[derive(Default)]
pub(crate) struct Derivatives(BTreeMap<(usize, u32), Symbol>);

impl Derivatives {
    /// The derivative of an order from 1 of an input.
    pub(crate) fn get(&mut self, pool: &mut Pool, input: usize, name: &str, order: u32) -> Expr {
        let text = if order == 1 { format!("der({name})") } else { format!("der({name}, {order})") };
        let s = *self.0.entry((input, order)).or_insert_with(|| pool.symbol(&text));
        pool.sym(s)
    }

    /// By input and order.
    pub(crate) fn list(&self) -> Vec<InputDerivative> {
        self.0.iter().map(|(&(input, order), &symbol)| InputDerivative { input, order, symbol }).collect()
    }
}

impl Names for Scope<'_> {
    fn lookup(&mut self, _pool: &mut Pool, name: &str) -> Option<Expr> {
        let e = self.plain.get(name).copied()?;
        self.met.insert(e);
        Some(e)
    }

    fn derivative(&mut self, pool: &mut Pool, name: &str, order: u32) -> Option<Expr> {
        let input = self.inputs.iter().position(|u| u == name)?;
        Some(self.derivatives.get(pool, input, name, order))
    }

    fn known(&self) -> Vec<String> {
        self.plain.keys().cloned().collect()
    }
}
