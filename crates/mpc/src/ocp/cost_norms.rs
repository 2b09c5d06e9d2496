//! Norms √(Σ c r²) in a cost, which have no derivative where they vanish.
//!
//! For the solvers, each becomes √(Σ c r² + ρ²), with a width ρ that is a share of the norm's typical size. The quadratic programs model it by
//! (Σ c r² + ρ²)/(2 s) + s/2, with s its value at the iterate: a bound from above that touches it there (E. Weiszfeld, Tohoku Math. J. 43,
//! 1937). A step in this model ends where the norm vanishes instead of far beyond.

use super::cost_names::CostPoint;
use super::cost_parts::{number, root};
use crate::error::MpcError;
use bracketry_native::{Function, Workspace};
use bracketry_symbolic::{Expr, Node, Pool, Symbol, Tape};

/// The width of a solution, as a share of the typical size of a norm: it changes a norm by less than this share of its size.
pub(crate) const FINEST_ROUNDING: f64 = 1e-5;

/// The squares c r² whose sum has this square root; none where it is another expression, or cannot vanish.
pub(super) fn squares_of(pool: &mut Pool, e: Expr) -> Option<Vec<(Expr, Expr)>> {
    let Node::Pow(base, exponent) = pool.node(e) else { return None };
    if number(pool, exponent) != Some(0.5) {
        return None;
    }
    let (mut squares, mut left) = (Vec::new(), vec![base]);
    while let Some(e) = left.pop() {
        if let Node::Add(a, b) = pool.node(e) {
            left.extend([b, a]);
            continue;
        }
        let (mut factor, mut factors, mut product) = (pool.int(1), Vec::new(), vec![e]);
        while let Some(e) = product.pop() {
            match pool.node(e) {
                Node::Mul(a, b) => product.extend([b, a]),
                _ if number(pool, e).is_some() => factor = pool.mul(factor, e),
                _ => factors.push(e),
            }
        }
        let positive = number(pool, factor).is_some_and(|c| c > 0.0);
        if !positive || factors.is_empty() {
            return None;
        }
        squares.push((factor, root(pool, &factors)?));
    }
    Some(squares)
}

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
        Ok(Widths { sizes: vec![1.0; count], share: 0.0, slopes })
    }
}

/// Widths of the norms of a cost.
#[derive(Clone)]
pub(super) struct Widths {
    /// Typical size of every norm.
    sizes: Vec<f64>,
    /// What the widths are of them in values of the cost; 0: the norms are exact.
    share: f64,
    /// Σ c (∂r/∂v)² of every norm for every variable v.
    slopes: Option<Function>,
}

impl Widths {
    pub(super) fn are_none(&self) -> bool {
        self.sizes.is_empty()
    }

    /// Finds the sizes of the norms from those of the variables.
    pub(super) fn measure(&mut self, at: CostPoint<'_>, sizes: &[f64]) {
        let Some(slopes) = &self.slopes else { return };
        let arguments: Vec<f64> = at.x.iter().chain(at.u).chain([&at.t]).chain(at.r).copied().collect();
        let mut out = vec![0.0; self.sizes.len() * sizes.len()];
        slopes.call(&arguments, &mut Workspace::default(), &mut out);
        for (size, slopes) in self.sizes.iter_mut().zip(out.chunks(sizes.len())) {
            let square: f64 = slopes.iter().zip(sizes).map(|(slope, s)| slope * s * s).sum();
            *size = if square > 0.0 && square.is_finite() { square.sqrt() } else { 1.0 };
        }
    }

    pub(super) fn set_share(&mut self, share: f64) {
        self.share = share;
    }

    /// Of values.
    pub(super) fn of_values(&self) -> impl Iterator<Item = f64> + '_ {
        self.sizes.iter().map(|size| self.share * size)
    }

    /// Of derivatives, which exact norms do not have everywhere.
    pub(super) fn of_derivatives(&self) -> impl Iterator<Item = f64> + '_ {
        self.sizes.iter().map(|size| self.share.max(FINEST_ROUNDING) * size)
    }
}
