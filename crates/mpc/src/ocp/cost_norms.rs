//! Norms √(Σ c r²) in a cost, which have no derivative where they vanish.
//!
//! For the solvers, each becomes √(Σ c r² + ρ²), with a width ρ that is a share of the norm's typical size. The quadratic programs model it by
//! (Σ c r² + ρ²)/(2 s) + s/2, with s its value at the iterate: a bound from above that touches it there (Weiszfeld 1937). A step in this
//! model ends where the norm vanishes instead of far beyond.

use super::cost_parts::squares_of;
use super::norm_widths::Widths;
use crate::error::MpcError;
use bracketry_native::Function;
use bracketry_symbolic::{Expr, Node, Pool, Symbol, Tape};

/// The norms of a cost that depend on a variable, each with the symbol of its width.
pub(super) struct CostNorms {
    /// The cost with widths.
    pub(super) cost: Expr,
    /// The norms with their widths, and the widths.
    pub(super) rounded: Vec<Expr>,
    pub(super) widths: Vec<Symbol>,
    /// Squares c r² of every norm.
    squares: Vec<Vec<(Expr, Expr)>>,
}

impl CostNorms {
    pub(super) fn of(pool: &mut Pool, cost: Expr, variables: &[Symbol]) -> Self {
        let mut norms = Self { cost, rounded: Vec::new(), widths: Vec::new(), squares: Vec::new() };
        let mut replaced = Vec::new();
        for e in pool.reachable(&[cost]) {
            if !variables.iter().any(|v| pool.depends_on(e, *v)) {
                continue;
            }
            let (Some(squares), Node::Pow(base, half)) = (squares_of(pool, e), pool.node(e)) else { continue };
            let width = pool.symbol(&format!("width#{}", norms.widths.len()));
            let square = pool.sym(width);
            let square = pool.powi(square, 2);
            let sum = pool.add(base, square);
            let rounded = pool.pow(sum, half);
            replaced.push((e, rounded));
            norms.rounded.push(rounded);
            norms.widths.push(width);
            norms.squares.push(squares);
        }
        if !replaced.is_empty() {
            norms.cost = pool.substitute_all(&[cost], &replaced.into_iter().collect())[0];
        }
        norms
    }

    /// The widths at work, for a cost of these arguments.
    pub(super) fn compile(&self, pool: &mut Pool, arguments: &[Symbol], variables: usize) -> Result<Widths, MpcError> {
        let mut slopes = Vec::new();
        for squares in &self.squares {
            for &v in &arguments[..variables] {
                let mut sum = pool.int(0);
                for &(factor, r) in squares {
                    let slope = pool.diff(r, v);
                    let square = pool.powi(slope, 2);
                    let term = pool.mul(factor, square);
                    sum = pool.add(sum, term);
                }
                slopes.push(sum);
            }
        }
        let count = self.widths.len();
        let slopes = if count == 0 {
            None
        } else {
            Some(Function::new(Tape::compile(pool, &arguments[..arguments.len() - count], &slopes)?))
        };
        Ok(Widths::new(count, slopes))
    }
}
