//! Sums of squares with positive coefficients, as they stand under the root of a size |σ|.

use bracketry_symbolic::{Directed, Expr, Func, Node, Rational};

use crate::unit_vector::{Component, Factor, Rewriter, half, sum_terms};

impl Rewriter<'_> {
    /// The components of a sum of squares with positive coefficients; none if it is no such sum, or cannot vanish.
    pub(crate) fn components(&mut self, square: Expr) -> Option<Vec<Component>> {
        let may_vanish = self.system.pool.directed(square) == Some(Directed::Written);
        let mut components: Vec<Component> = Vec::new();
        let mut stack = vec![(square, Vec::<Factor>::new())];
        while let Some((e, outer)) = stack.pop() {
            if matches!(self.system.pool.node(e), Node::Add(..)) {
                for term in sum_terms(self.system, e).into_iter().rev() {
                    stack.push((term, outer.clone()));
                }
                continue;
            }
            let mut factors = outer;
            self.flatten(e, &Rational::ONE, &mut factors);
            factors = self.split_squares(factors);
            let moving = |this: &Self, f: &Factor| !this.is_constant(f.base);
            let squares: Vec<Factor> =
                factors.iter().filter(|f| f.exponent == Rational::from(2u8) && moving(self, f)).cloned().collect();
            if squares.is_empty() {
                let sums: Vec<usize> = (0..factors.len())
                    .filter(|&i| factors[i].exponent == Rational::ONE && moving(self, &factors[i]))
                    .filter(|&i| matches!(self.system.pool.node(factors[i].base), Node::Add(..)))
                    .collect();
                if let [at] = sums[..] {
                    let sum = factors.remove(at).base;
                    stack.push((sum, factors));
                    continue;
                }
                // A constant term: the sum does not vanish, unless the constant does.
                if factors.iter().all(|f| self.is_constant(f.base)) && self.constant_product(&factors)? == 0.0 {
                    continue;
                }
                return None;
            }
            components.push(self.component(&factors, &squares, may_vanish)?);
        }
        Some(components)
    }

    /// Squares of products as products of squares.
    fn split_squares(&mut self, factors: Vec<Factor>) -> Vec<Factor> {
        let mut out = Vec::new();
        for f in factors {
            if f.exponent == Rational::from(2u8) && matches!(self.system.pool.node(f.base), Node::Mul(..)) {
                let mut inner = Vec::new();
                self.flatten(f.base, &Rational::ONE, &mut inner);
                for i in inner {
                    out.push(Factor { base: i.base, exponent: i.exponent * &f.exponent });
                }
            } else {
                out.push(f);
            }
        }
        out
    }

    /// One term of the sum, from its factors, of which `squares` are squares that move.
    fn component(&mut self, factors: &[Factor], squares: &[Factor], may_vanish: bool) -> Option<Component> {
        let pool = &mut self.system.pool;
        let mut base = pool.int(1);
        for f in squares {
            base = pool.mul(base, f.base);
        }
        let mut scale = self.system.pool.int(1);
        for f in factors {
            if f.exponent == Rational::from(2u8) {
                if self.is_constant(f.base) {
                    // What is written as a direction stays one where a parameter in it vanishes: a fit may start there.
                    let value = self.system.value(f.base).filter(|v| *v != 0.0 || may_vanish)?;
                    let size = if value < 0.0 { self.system.pool.neg(f.base) } else { f.base };
                    scale = self.system.pool.mul(scale, size);
                }
                continue;
            }
            let exponent = self.system.pool.rational(f.exponent.clone());
            let power = self.system.pool.pow(f.base, exponent);
            if !self.is_positive(power) {
                return None;
            }
            let root = if let Some(root) = self.system.pool.number(power).and_then(exact_root) {
                self.system.pool.rational(root)
            } else {
                let exponent = self.system.pool.rational(f.exponent.clone() * half(1));
                self.system.pool.pow(f.base, exponent)
            };
            scale = self.system.pool.mul(scale, root);
        }
        Some(Component { base, scale })
    }

    /// Whether `e` uses nothing but parameters.
    fn is_constant(&self, e: Expr) -> bool {
        let used = self.system.pool.symbols_of(&[e]);
        used.iter().all(|s| self.system.parameters.iter().any(|p| p.symbol == *s))
    }

    fn constant_product(&mut self, factors: &[Factor]) -> Option<f64> {
        let mut product = 1.0;
        for f in factors {
            product *= self.system.value(f.base)?.powf(f.exponent.to_f64().value());
        }
        Some(product)
    }

    /// Whether `e` is positive wherever it is defined, but perhaps at single points: by its value if it is constant, by
    /// its form otherwise.
    fn is_positive(&mut self, e: Expr) -> bool {
        let mut stack = vec![e];
        while let Some(e) = stack.pop() {
            if self.is_constant(e) {
                if self.system.value(e).is_none_or(|v| v <= 0.0) {
                    return false;
                }
                continue;
            }
            match self.system.pool.node(e) {
                Node::Add(a, b) | Node::Mul(a, b) => stack.extend([a, b]),
                Node::Call(Func::Exp | Func::Cosh | Func::Abs, _) => {}
                Node::Pow(base, exponent) => match self.system.pool.integer(exponent) {
                    Some(k) if k % 2 == 0 => {}
                    _ => stack.push(base),
                },
                _ => return false,
            }
        }
        true
    }
}

/// The root of a square of a rational.
fn exact_root(x: &Rational) -> Option<Rational> {
    let (p, q) = (x.numerator(), x.denominator());
    let root = |v: u64| {
        let r = v.isqrt();
        (r * r == v).then_some(r)
    };
    let p = root(u64::try_from(p).ok()?)?;
    let q = root(u64::try_from(q).ok()?)?;
    Some(Rational::from(p) / Rational::from(q))
}
