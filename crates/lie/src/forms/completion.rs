//! Functions that complete others to coordinates, and functions that are constant along fields.

use bracketry_symbolic::{Expr, Node, Rational, Undecided as Exact};

use crate::algebra::field::Field;
use crate::algebra::integrals::search::integrals_of_involutive;
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::independent_rows;
use crate::feedback::outputs::named_functions;
use crate::forms::frame::Frame;
use crate::undecided::Undecided;

impl Frame {
    /// Those of `candidates` with independent differentials modulo those of `given`.
    pub(crate) fn completion(&mut self, given: &[Expr], candidates: &[Expr]) -> Result<Vec<Expr>, Undecided> {
        let all: Vec<Expr> = given.iter().chain(candidates).copied().collect();
        let rows = self.system.pool.jacobian(&all, &self.fields.states);
        let chosen = independent_rows(&mut self.system.pool, &rows, &self.fields.bindings, &mut self.evidence)?;
        Ok(chosen.into_iter().filter(|&k| k >= given.len()).map(|k| all[k]).collect())
    }

    /// The states as expressions.
    pub(crate) fn state_functions(&mut self) -> Vec<Expr> {
        let states = self.fields.states.clone();
        states.into_iter().map(|s| self.system.pool.sym(s)).collect()
    }

    /// The states that are constant along all of `fields`.
    pub(crate) fn constant_states(&mut self, fields: &[Field]) -> Result<Vec<Expr>, Undecided> {
        let mut list = Vec::new();
        for h in self.state_functions() {
            if self.fields.constant_along(&mut self.system.pool, h, fields, &mut self.evidence)? {
                list.push(h);
            }
        }
        Ok(list)
    }

    /// Functions that are constant along independent fields of an involutive distribution, as far as they are found, without
    /// divisors that are constant along it themselves.
    pub(crate) fn constants_along(&mut self, fields: &[Field]) -> Result<Vec<Expr>, Undecided> {
        let known = named_functions(&self.system);
        let pool = &mut self.system.pool;
        let (states, bindings) = (&self.fields.states, &self.fields.bindings);
        let found = match integrals_of_involutive(pool, states, fields, &known, bindings, &mut self.evidence) {
            Ok(found) => found.functions,
            Err(why @ Undecided::Exact(Exact::Stopped)) => return Err(why),
            Err(_) => Vec::new(),
        };
        let mut list = Vec::new();
        for h in found {
            list.push(self.without_constant_divisors(h, fields)?);
        }
        Ok(list)
    }

    /// φ D for φ = N/D with D constant along the fields, as φ is.
    fn without_constant_divisors(&mut self, h: Expr, fields: &[Field]) -> Result<Expr, Undecided> {
        let mut h = tidy(&mut self.system.pool, h);
        for e in self.system.pool.reachable(&[h]) {
            let pool = &mut self.system.pool;
            let Node::Pow(base, k) = pool.node(e) else { continue };
            if pool.number(k).is_none_or(|k| *k >= Rational::ZERO) {
                continue;
            }
            if self.fields.constant_along(pool, base, fields, &mut self.evidence)? {
                let divisor = pool.pow(base, k);
                let product = pool.div(h, divisor);
                h = tidy(pool, product);
            }
        }
        Ok(h)
    }
}
