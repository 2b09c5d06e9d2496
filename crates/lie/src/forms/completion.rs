//! Functions that complete others to coordinates, and functions that are constant along fields.

use bracketry_symbolic::{Expr, Node, Rational, Undecided as Exact};
use nalgebra::DVector;

use crate::algebra::field::Field;
use crate::algebra::integrals::search::integrals_of_involutive;
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::independent_rows;
use crate::feedback::outputs::named_functions;
use crate::forms::frame::Frame;
use crate::undecided::Undecided;

/// A row of which less than this part is left beside others depends on them.
const INDEPENDENT: f64 = 1e-6;

impl Frame {
    /// Those of `candidates` with independent differentials modulo those of `given`. Of several choices, one that is regular at the
    /// model's point, if there is one.
    pub(crate) fn completion(&mut self, given: &[Expr], candidates: &[Expr]) -> Result<Vec<Expr>, Undecided> {
        let mut all: Vec<Expr> = given.iter().chain(candidates).copied().collect();
        let mut rows = self.system.pool.jacobian(&all, &self.fields.states);
        if let Some(first) = self.independent_at_the_point(&rows, given.len()) {
            let in_order = |k: &usize| (*k >= given.len() && !first.contains(k), *k);
            let mut order: Vec<usize> = (0..all.len()).collect();
            order.sort_by_key(in_order);
            all = order.iter().map(|&k| all[k]).collect();
            rows = order.iter().map(|&k| rows[k].clone()).collect();
        }
        let chosen = independent_rows(&mut self.system.pool, &rows, &self.fields.bindings, &mut self.evidence)?;
        Ok(chosen.into_iter().filter(|&k| k >= given.len()).map(|k| all[k]).collect())
    }

    /// Numbers of the rows, from `given` on, that are independent of those before them at the model's point; `None` without a point, or
    /// where a row has no value there.
    fn independent_at_the_point(&self, rows: &[Field], given: usize) -> Option<Vec<usize>> {
        let (point, _) = self.system.point_values()?;
        let mut span: Vec<DVector<f64>> = Vec::new();
        let mut independent = Vec::new();
        for (k, row) in rows.iter().enumerate() {
            let row = DVector::from_vec(self.numbers(row, &self.system.states, &point)?);
            let length = row.norm();
            let mut rest = row;
            for _ in 0..2 {
                for b in &span {
                    rest.axpy(-b.dot(&rest), b, 1.0);
                }
            }
            let left = rest.norm();
            if !left.is_finite() {
                return None;
            }
            if left > INDEPENDENT * length {
                span.push(rest / left);
                if k >= given {
                    independent.push(k);
                }
            }
        }
        Some(independent)
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
