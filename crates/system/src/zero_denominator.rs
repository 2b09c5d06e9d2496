//! Denominators that the values of parameters make zero everywhere.

use bracketry_symbolic::{Expr, Node};

use crate::system::System;

/// A denominator that is zero whatever the state and the inputs, by the values of parameters.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the denominator `{denominator}` in the equation of `{equation}` is 0 with {}\n   = give other values in [parameters]",
    values.join(", ")
)]
pub struct ZeroDenominator {
    /// The state or output in whose equation it stands.
    pub equation: String,
    /// The denominator as it is printed.
    pub denominator: String,
    /// The parameters in it, as `m = 0`.
    pub values: Vec<String>,
}

impl System {
    /// Refuses a model that divides by zero everywhere because of the values of its parameters.
    ///
    /// # Errors
    /// [`ZeroDenominator`] for the first such denominator, of the states before the outputs.
    ///
    /// ```
    /// use bracketry_system::System;
    /// let text = "states = ['v']\ninputs = ['u']\nparameters = { m = 0 }\ndynamics = { v = 'u/m' }";
    /// let error = System::parse("mass", text).unwrap().check_denominators().unwrap_err();
    /// assert_eq!((error.equation.as_str(), error.denominator.as_str(), &*error.values), ("v", "m", &["m = 0".to_owned()][..]));
    /// ```
    pub fn check_denominators(&self) -> Result<(), ZeroDenominator> {
        let states = self.state_names().into_iter().zip(self.dynamics.iter().copied());
        let equations: Vec<(String, Expr)> = states.chain(self.outputs.iter().cloned()).collect();
        // The pool takes what the values leave of a denominator.
        let mut system = self.clone();
        for (equation, e) in equations {
            for part in self.pool.reachable(&[e]) {
                let Some(base) = self.denominator(part) else { continue };
                let used = self.pool.symbols_of(&[base]);
                let inside: Vec<_> = self.parameters.iter().filter(|p| used.contains(&p.symbol)).collect();
                if inside.is_empty() {
                    continue;
                }
                let value = system.with_values(&[base]);
                if value.iter().all(|v| system.pool.is_zero(*v)) {
                    let shown = |p: &&crate::Parameter| {
                        format!("{} = {}", self.symbol_name(p.symbol), p.value.to_f64().value())
                    };
                    return Err(ZeroDenominator {
                        equation,
                        denominator: self.pool.text(base),
                        values: inside.iter().map(shown).collect(),
                    });
                }
            }
        }
        Ok(())
    }

    /// The base of a power with a negative number as exponent.
    fn denominator(&self, e: Expr) -> Option<Expr> {
        let Node::Pow(base, exponent) = self.pool.node(e) else { return None };
        self.pool.number(exponent).is_some_and(|n| n.to_f64().value() < 0.0).then_some(base)
    }
}
