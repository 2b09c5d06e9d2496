//! The parts of a cost: weighted squares, weighted absolute values, weighted norms, and the rest.
//!
//! A square w r² has the positive semidefinite Gauss–Newton Hessian 2 w ∇r ∇rᵀ, which stays a good model where the exact one
//! 2 w (∇r ∇rᵀ + r ∇²r) is indefinite. An absolute value w |e| has no derivative where e = 0, which is where it is small: in a
//! quadratic program it becomes a slack that is at least e and −e.

use bracketry_symbolic::{Expr, Func, Func2, Node, Pool, Symbol};

/// A weight times a function of the residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Term {
    /// Positive; the same as an expression.
    pub(super) weight: f64,
    pub(super) factor: Expr,
    /// The residual; depends on a variable.
    pub(super) residual: Expr,
}

/// The sum Σ w r² + Σ w |e| + Σ w √(Σ c r²) + rest.
#[derive(Debug)]
pub(super) struct CostParts {
    /// Squares whose residual is not affine in the variables; those of affine ones stay in the rest, whose Hessian they have.
    pub(super) squares: Vec<Term>,
    pub(super) absolute: Vec<Term>,
    /// Norms, with residuals that are norms as a whole.
    pub(super) norms: Vec<Term>,
    pub(super) rest: Expr,
}

impl CostParts {
    /// Takes a cost apart, with these norms among its terms.
    pub(super) fn of(pool: &mut Pool, cost: Expr, variables: &[Symbol], norms: &[Expr]) -> Self {
        let mut parts = Self { squares: Vec::new(), absolute: Vec::new(), norms: Vec::new(), rest: pool.int(0) };
        let one = pool.int(1);
        parts.add(pool, one, cost, (variables, norms));
        if parts.squares.is_empty() && parts.absolute.is_empty() && parts.norms.is_empty() {
            // As it was written, so that it is computed as it was written.
            parts.rest = cost;
        }
        parts
    }

    /// Whether the programs have another Hessian than that of the rest.
    pub(super) fn has_squares(&self) -> bool {
        !(self.squares.is_empty() && self.norms.is_empty())
    }

    /// The sum of the squares and norms and its Gauss–Newton Hessian 2 Σ w ∇r ∇rᵀ + Σ w/s Σ c ∇r ∇rᵀ, with s the value of a norm.
    pub(super) fn sum_of_squares(&self, pool: &mut Pool, variables: &[Symbol]) -> (Expr, Vec<Vec<Expr>>) {
        let zero = pool.int(0);
        let mut sum = zero;
        let mut hessian = vec![vec![zero; variables.len()]; variables.len()];
        let two = pool.int(2);
        for term in &self.squares {
            let square = pool.powi(term.residual, 2);
            let weighted = pool.mul(term.factor, square);
            sum = pool.add(sum, weighted);
            let twice = pool.mul(two, term.factor);
            add_outer_product(pool, &mut hessian, twice, term.residual, variables);
        }
        for term in &self.norms {
            let weighted = pool.mul(term.factor, term.residual);
            sum = pool.add(sum, weighted);
            let inverse = pool.powi(term.residual, -1);
            for (factor, residual) in squares_of(pool, term.residual).unwrap_or_default() {
                let factor = pool.mul(factor, inverse);
                let factor = pool.mul(factor, term.factor);
                add_outer_product(pool, &mut hessian, factor, residual, variables);
            }
        }
        (sum, hessian)
    }

    /// Adds `factor` times `e`.
    fn add(&mut self, pool: &mut Pool, factor: Expr, e: Expr, among: (&[Symbol], &[Expr])) {
        let (variables, norms) = among;
        if let Node::Add(a, b) = pool.node(e) {
            self.add(pool, factor, a, among);
            self.add(pool, factor, b, among);
            return;
        }
        let (mut constant, mut varying) = (factor, Vec::new());
        let mut left = vec![e];
        while let Some(e) = left.pop() {
            match pool.node(e) {
                Node::Mul(a, b) => left.extend([b, a]),
                _ if variables.iter().any(|v| pool.depends_on(e, *v)) => varying.push(e),
                _ => constant = pool.mul(constant, e),
            }
        }
        if let &[only] = varying.as_slice() {
            match pool.node(only) {
                // w (a + b) is a sum, and so is w max(a, b) = w/2 (a + b + |a − b|).
                Node::Add(..) => return self.add(pool, constant, only, among),
                Node::Call2(kind @ (Func2::Max | Func2::Min), a, b) if number(pool, constant).is_some() => {
                    let half = pool.ratio(1, 2);
                    let half = pool.mul(half, constant);
                    let difference = pool.sub(a, b);
                    let distance = pool.call(Func::Abs, difference);
                    let signed = if kind == Func2::Min { pool.neg(half) } else { half };
                    if number(pool, signed).is_some_and(|w| w > 0.0) {
                        self.add(pool, half, a, among);
                        self.add(pool, half, b, among);
                        return self.add(pool, signed, distance, among);
                    }
                }
                _ => {}
            }
        }
        if let Some(weight) = number(pool, constant).filter(|w| *w > 0.0 && w.is_finite()) {
            if let &[only] = varying.as_slice()
                && let Node::Call(Func::Abs, residual) = pool.node(only)
            {
                return self.absolute.push(Term { weight, factor: constant, residual });
            }
            if let &[only] = varying.as_slice()
                && norms.contains(&only)
            {
                return self.norms.push(Term { weight, factor: constant, residual: only });
            }
            if let Some(residual) = root(pool, &varying)
                && !is_affine(pool, residual, variables)
            {
                return self.squares.push(Term { weight, factor: constant, residual });
            }
        }
        let product = varying.into_iter().fold(constant, |p, e| pool.mul(p, e));
        self.rest = pool.add(self.rest, product);
    }
}

/// Adds `factor` times ∇r ∇rᵀ.
fn add_outer_product(pool: &mut Pool, hessian: &mut [Vec<Expr>], factor: Expr, residual: Expr, variables: &[Symbol]) {
    let gradient = pool.gradient(residual, variables);
    for (row, &a) in hessian.iter_mut().zip(&gradient) {
        let scaled = pool.mul(factor, a);
        for (h, &b) in row.iter_mut().zip(&gradient) {
            let product = pool.mul(scaled, b);
            *h = pool.add(*h, product);
        }
    }
}

/// r where the product of the factors is r².
fn root(pool: &mut Pool, factors: &[Expr]) -> Option<Expr> {
    let mut root = pool.int(1);
    for &f in factors {
        let Node::Pow(base, exponent) = pool.node(f) else { return None };
        let exponent = pool.integer(exponent).filter(|k| *k > 0 && k % 2 == 0)?;
        let power = pool.powi(base, exponent / 2);
        root = pool.mul(root, power);
    }
    Some(root)
}

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

fn is_affine(pool: &mut Pool, e: Expr, variables: &[Symbol]) -> bool {
    let hessian = pool.hessian(e, variables);
    hessian.iter().flatten().all(|h| pool.is_zero(*h))
}

/// The value of an expression of numbers.
fn number(pool: &Pool, e: Expr) -> Option<f64> {
    Some(match pool.node(e) {
        Node::Num(_) => pool.number(e)?.to_f64().value(),
        Node::Pi => std::f64::consts::PI,
        Node::Sym(_) => return None,
        Node::Add(a, b) => number(pool, a)? + number(pool, b)?,
        Node::Mul(a, b) => number(pool, a)? * number(pool, b)?,
        Node::Pow(a, b) => number(pool, a)?.powf(number(pool, b)?),
        Node::Call(f, a) => f.eval(number(pool, a)?),
        Node::Call2(f, a, b) => f.eval(number(pool, a)?, number(pool, b)?),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn parts(text: &str) -> (Pool, CostParts) {
        let mut pool = Pool::new();
        let variables = ["x", "u"].map(|n| pool.symbol(n));
        let e = pool.parse(text).unwrap();
        let parts = CostParts::of(&mut pool, e, &variables, &[]);
        (pool, parts)
    }

    fn counts(text: &str) -> (usize, usize) {
        let (_, p) = parts(text);
        (p.squares.len(), p.absolute.len())
    }

    #[test]
    fn squares_of_curved_residuals_are_found_wherever_the_weight_is_positive() {
        assert_eq!(counts("sin(x)^2 + 3*(1 - cos(x))^2/2 + u^2"), (2, 0));
        assert_eq!(counts("4*(sin(x)^2 + (x*u)^2)"), (2, 0));
        // Affine residuals have the Hessian that they have anyway; a negative square has none to offer.
        assert_eq!(counts("10*(x - 1)^2 + 0.1*u^2 - sin(x)^2 + sin(x)"), (0, 0));
    }

    #[test]
    fn absolute_values_and_maxima_with_positive_weight_are_found() {
        assert_eq!(counts("abs(u) + 2*abs(x - u)"), (0, 2));
        assert_eq!(counts("max(x, 0) - min(x, u)"), (0, 2));
        assert_eq!(counts("-abs(u) + min(x, 0) + x*abs(u) + w*abs(x)"), (0, 0));
    }

    #[test]
    fn the_parts_add_up_to_the_cost() {
        let text = "2*(sin(x)^2 + abs(u - x)) + max(x, 3*u)/5 - x*u + 7*(x*u)^2";
        let (mut pool, p) = parts(text);
        let mut sum = p.rest;
        for (terms, square) in [(&p.squares, true), (&p.absolute, false)] {
            for t in terms {
                let value = if square { pool.powi(t.residual, 2) } else { pool.call(Func::Abs, t.residual) };
                let term = pool.mul(t.factor, value);
                sum = pool.add(sum, term);
            }
        }
        let cost = pool.parse(text).unwrap();
        let variables = ["x", "u"].map(|n| pool.symbol(n));
        let tape = bracketry_symbolic::Tape::compile(&pool, &variables, &[sum, cost]).unwrap();
        let f = bracketry_native::Function::new(tape);
        for point in [[0.3, -0.8], [-1.2, 0.4], [2.0, 5.0]] {
            let mut out = [0.0; 2];
            f.call(&point, &mut bracketry_native::Workspace::default(), &mut out);
            assert!((out[0] - out[1]).abs() < 1e-12 * out[1].abs(), "{out:?}");
        }
    }
}
