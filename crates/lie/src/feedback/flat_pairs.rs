//! Pairs of functions that are flat outputs of two inputs without drift.

use bracketry_symbolic::{Expr, Func, Node, Pool};

use crate::algebra::field::{Field, VectorFields};
use crate::algebra::integrals::search::integrals;
use crate::algebra::matrix::generic_rank;
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::involutive;
use crate::budget::check_size;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

impl VectorFields {
    /// Sine and cosine of every state that occurs within one, alone or in a sum of angles.
    pub(crate) fn circular_functions(&self, pool: &mut Pool) -> Vec<Expr> {
        let mut roots = self.controls.concat();
        roots.extend(&self.drift);
        let mut list = Vec::new();
        for e in pool.reachable(&roots) {
            let Node::Call(Func::Sin | Func::Cos | Func::Tan, a) = pool.node(e) else { continue };
            for s in pool.symbols_of(&[a]) {
                if self.states.contains(&s) {
                    let x = pool.sym(s);
                    for f in [pool.sin(x), pool.cos(x)] {
                        if !list.contains(&f) {
                            list.push(f);
                        }
                    }
                }
            }
        }
        list
    }

    /// Whether two functions with independent differentials have a common annihilator inside a
    /// distribution with one dimension less than the space: their derivatives along it have rank one.
    pub(crate) fn annihilator_within(
        &self,
        pool: &mut Pool,
        pair: &[Expr],
        distribution: &[Field],
        evidence: &mut Evidence,
    ) -> Result<bool, Undecided> {
        let gradients: Vec<Field> = pair.iter().map(|&h| pool.gradient(h, &self.states)).collect();
        if generic_rank(pool, &gradients, &self.bindings, evidence)? < 2 {
            return Ok(false);
        }
        let along: Vec<Vec<Expr>> = pair
            .iter()
            .map(|&h| distribution.iter().map(|y| pool.lie_derivative(h, &self.states, y)).collect())
            .collect();
        Ok(generic_rank(pool, &along, &self.bindings, evidence)? == 1)
    }

    /// `h` with a second function, if the fields of the distribution along which h is constant have two integrals.
    pub(crate) fn completed(
        &self,
        pool: &mut Pool,
        h: Expr,
        distribution: &[Field],
        known: &[Expr],
        first: usize,
        evidence: &mut Evidence,
    ) -> Result<Option<Vec<Expr>>, Undecided> {
        check_size(pool, first)?;
        let slopes: Vec<Expr> = distribution.iter().map(|y| pool.lie_derivative(h, &self.states, y)).collect();
        let mut pivot = None;
        for (i, &s) in slopes.iter().enumerate() {
            if !self.vanishes(pool, s, evidence)? {
                pivot = Some(i);
                break;
            }
        }
        let Some(p) = pivot else { return Ok(None) };
        let mut constant = Vec::new();
        for (i, y) in distribution.iter().enumerate().filter(|x| x.0 != p) {
            let share = pool.div(slopes[i], slopes[p]);
            let field: Field = y
                .iter()
                .zip(&distribution[p])
                .map(|(&a, &b)| {
                    let term = pool.mul(share, b);
                    let e = pool.sub(a, term);
                    tidy(pool, e)
                })
                .collect();
            constant.push(field);
        }
        if !involutive(pool, &self.states, &constant, 0, &self.bindings, evidence)? {
            return Ok(None);
        }
        let mut functions = vec![h];
        functions.extend(known);
        functions.extend(self.circular_functions(pool));
        let found = integrals(pool, &self.states, &constant, &functions, &self.bindings, evidence)?;
        for &second in &found.functions {
            let pair = [h, tidy(pool, second)];
            if self.annihilator_within(pool, &pair, distribution, evidence)? {
                return Ok(Some(pair.to_vec()));
            }
        }
        Ok(None)
    }
}
