//! The names of expressions that are numbers.

use bracketry_symbolic::{Expr, Names, Pool};

/// No names: only numbers, `pi` and functions.
pub struct Constants;

impl Names for Constants {
    fn lookup(&mut self, _pool: &mut Pool, _name: &str) -> Option<Expr> {
        None
    }

    fn known(&self) -> Vec<String> {
        Vec::new()
    }
}
