//! What the outputs tell about states and parameters.

use bracketry_symbolic::{Bindings, Expr, Pool, Symbol};

use crate::error::{Undecided, check_growth};
use crate::evidence::Evidence;
use crate::fields::{VectorFields, is_plain_zero};
use crate::growth::independent;

/// What the outputs determine at a generic point, for inputs that vary freely.
#[derive(Clone)]
pub struct Observability {
    /// States, then unknown parameters.
    pub variables: Vec<Symbol>,
    /// Independent differentials, by `variables`, of repeated Lie derivatives of the outputs.
    pub codistribution: Vec<Vec<Expr>>,
    bindings: Bindings,
}

impl Observability {
    /// Dimension of the codistribution.
    pub fn rank(&self) -> usize {
        self.codistribution.len()
    }

    /// Whether the outputs determine the value of `function` locally.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly.
    pub fn determines(&self, pool: &mut Pool, function: Expr, evidence: &mut Evidence) -> Result<bool, Undecided> {
        let mut all = self.codistribution.clone();
        all.push(pool.gradient(function, &self.variables));
        Ok(independent(pool, &all, &self.bindings, evidence)?.len() == self.rank())
    }
}

impl VectorFields {
    /// The Hermann–Krener rank condition for the states and the `unknown` parameters, which
    /// are treated as further states with derivative zero (and as generic, bound or not).
    ///
    /// Over the field of functions `L_X(a dh) = (X·a) dh + a dL_X h`, so only Lie derivatives
    /// of functions with a new independent differential need to be formed.
    ///
    /// # Errors
    /// [`Undecided`] if a function cannot be evaluated exactly.
    pub fn observability(
        &self,
        pool: &mut Pool,
        outputs: &[Expr],
        unknown: &[Symbol],
        evidence: &mut Evidence,
    ) -> Result<Observability, Undecided> {
        let variables: Vec<Symbol> = self.states.iter().chain(unknown).copied().collect();
        let mut bindings = Bindings::new();
        let mut roots = self.controls.concat();
        roots.extend(&self.drift);
        roots.extend(outputs);
        for s in pool.symbols_of(&roots) {
            if let Some(v) = self.bindings.get(s).filter(|_| !unknown.contains(&s)) {
                bindings.bind(s, v.clone());
            }
        }
        let first_node = pool.len();
        let mut differentials = Vec::new();
        let mut fresh = Vec::new();
        let mut candidates: Vec<Expr> = outputs.to_vec();
        while !candidates.is_empty() && differentials.len() < variables.len() {
            for h in candidates.drain(..) {
                check_growth(pool, first_node, [&[h], &[]], variables.len())?;
                let d = pool.gradient(h, &variables);
                if is_plain_zero(pool, &d) {
                    continue;
                }
                differentials.push(d);
                if independent(pool, &differentials, &bindings, evidence)?.len() == differentials.len() {
                    fresh.push(h);
                } else {
                    differentials.pop();
                }
            }
            for h in fresh.drain(..) {
                for x in std::iter::once(&self.drift).chain(&self.controls) {
                    let l = pool.lie_derivative(h, &self.states, x);
                    if pool.number(l).is_none() {
                        candidates.push(l);
                    }
                }
            }
        }
        Ok(Observability { variables, codistribution: differentials, bindings })
    }
}
