//! Unit vectors σ/|σ| in the equations: coupled dry friction, set-valued in the unit ball where σ = 0.

use bracketry_symbolic::{Expr, Node, Rational, Symbol};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::system::System;

/// Unit vectors with more components than this are left as they are written.
pub(crate) const MAX_COMPONENTS: usize = 6;

/// One component `σ_i = scale · base` of a vector σ under a root `|σ| = √(Σ σ_i²)`.
#[derive(Clone, Debug)]
pub(crate) struct Component {
    /// What numerators are written with.
    pub(crate) base: Expr,
    /// Positive factor of it.
    pub(crate) scale: Expr,
}

/// A root `√S` whose quotients are components of the unit vector σ/|σ|.
#[derive(Clone, Debug)]
pub(crate) struct Root {
    /// `S = Σ σ_i²`, as it is written.
    pub(crate) square: Expr,
    pub(crate) components: Vec<Component>,
    /// The symbols for the components of σ/|σ|.
    pub(crate) directions: Vec<Symbol>,
}

/// A factor `base ^ exponent` of a product.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    pub(crate) base: Expr,
    pub(crate) exponent: Rational,
}

/// A term `coefficient · base_i` of a numerator; the coefficient as its factors.
type Linear = Vec<(usize, Vec<Factor>)>;

/// Replaces quotients by symbols.
pub(crate) struct Rewriter<'s> {
    pub(crate) system: &'s mut System,
    /// What is known of each sum under a root; none if it is no sum of squares.
    squares: FxHashMap<Expr, Option<usize>>,
    pub(crate) roots: Vec<Root>,
    /// Which roots have been used.
    pub(crate) used: FxHashSet<usize>,
    image: FxHashMap<Expr, Expr>,
}

impl<'s> Rewriter<'s> {
    pub(crate) fn new(system: &'s mut System, refused: &[Expr]) -> Self {
        Self {
            system,
            squares: refused.iter().map(|&s| (s, None)).collect(),
            roots: Vec::new(),
            used: FxHashSet::default(),
            image: FxHashMap::default(),
        }
    }
}

impl Rewriter<'_> {
    pub(crate) fn run(&mut self, expressions: &[Expr], wanted: impl Fn(&System, Expr) -> bool) -> Vec<Expr> {
        let nodes = self.system.pool.reachable(expressions);
        // Only an odd power of a root makes a unit vector; x y/(x² + y²) alone is no friction.
        let odd: Vec<Expr> =
            nodes.iter().filter_map(|&e| self.odd_root(e)).filter(|&s| wanted(self.system, s)).collect();
        for square in odd {
            self.register(square);
        }
        if self.roots.is_empty() {
            return expressions.to_vec();
        }
        for e in nodes {
            let new = match self.system.pool.node(e) {
                Node::Mul(..) => {
                    let mut factors = Vec::new();
                    self.flatten(e, &Rational::ONE, &mut factors);
                    match self.product(&factors) {
                        Some(product) => product,
                        None => self.rebuilt(e),
                    }
                }
                _ => self.rebuilt(e),
            };
            self.image.insert(e, new);
        }
        expressions.iter().map(|e| self.image[e]).collect()
    }

    fn rebuilt(&mut self, e: Expr) -> Expr {
        let image = &self.image;
        self.system.pool.rebuild(e, |o| image[&o])
    }

    /// `S` of a node `S^(-1/2)`.
    fn odd_root(&self, e: Expr) -> Option<Expr> {
        let pool = &self.system.pool;
        let Node::Pow(base, exponent) = pool.node(e) else { return None };
        match pool.number(exponent) {
            Some(k) if *k == half(-1) || *k == half(1) => Some(base),
            _ => None,
        }
    }

    /// The root with this square, made on first use.
    fn register(&mut self, square: Expr) -> Option<usize> {
        if let Some(known) = self.squares.get(&square) {
            return *known;
        }
        let components = self.components(square).filter(|c| (2..=MAX_COMPONENTS).contains(&c.len()));
        let found = components.map(|components| {
            let names: Vec<String> = components.iter().map(|c| self.system.pool.text(c.base)).collect();
            let all = self.system.pool.text(square);
            let directions = names.iter().map(|n| self.system.pool.symbol(&format!("({n})/|{all}|"))).collect();
            self.roots.push(Root { square, components, directions });
            self.roots.len() - 1
        });
        self.squares.insert(square, found);
        found
    }

    /// The factors of `e^power`; products in denominators are taken apart, those in positive powers are not.
    pub(crate) fn flatten(&mut self, e: Expr, power: &Rational, out: &mut Vec<Factor>) {
        let mut stack = vec![(e, power.clone())];
        while let Some((e, power)) = stack.pop() {
            let pool = &self.system.pool;
            match pool.node(e) {
                Node::Mul(a, b) if power.is_int() => {
                    stack.push((b, power.clone()));
                    stack.push((a, power));
                }
                Node::Pow(base, exponent) => match pool.number(exponent) {
                    Some(k) if power.is_int() && (!k.is_int() || *k < Rational::ZERO) => {
                        stack.push((base, k * &power));
                    }
                    Some(k) if power == Rational::ONE => out.push(Factor { base, exponent: k.clone() }),
                    _ => out.push(Factor { base: e, exponent: power }),
                },
                _ => out.push(Factor { base: e, exponent: power }),
            }
        }
    }

    /// The product of factors with the unit vectors in it replaced; none if there is nothing to replace.
    fn product(&mut self, factors: &[Factor]) -> Option<Expr> {
        for (at, factor) in factors.iter().enumerate() {
            let Some(&Some(root)) = self.squares.get(&factor.base) else { continue };
            let Some(copies) = half_powers(&factor.exponent) else { continue };
            if let Some(product) = self.pair(factors, at, root, copies) {
                return Some(product);
            }
        }
        self.distribute(factors)
    }

    /// Pairs the root at `at`, of exponent `-copies/2`, with as many numerators.
    fn pair(&mut self, factors: &[Factor], at: usize, root: usize, copies: usize) -> Option<Expr> {
        let mut rest: Vec<Factor> = Vec::new();
        let mut taken: Vec<(Linear, usize)> = Vec::new();
        let mut missing = copies;
        for (i, factor) in factors.iter().enumerate() {
            if i == at {
                continue;
            }
            let power = whole(&factor.exponent);
            let linear = if missing > 0 && power > 0 { self.linear(factor.base, root) } else { None };
            let Some(linear) = linear else {
                rest.push(factor.clone());
                continue;
            };
            let used = missing.min(power);
            missing -= used;
            taken.push((linear, used));
            if power > used {
                let exponent = Rational::from(power - used);
                rest.push(Factor { base: factor.base, exponent });
            }
        }
        if missing > 0 {
            return None;
        }
        self.used.insert(root);
        let mut product = match self.product(&rest) {
            Some(product) => product,
            None => self.plain(&rest),
        };
        for (linear, power) in taken {
            let direction = self.direction(&linear, root);
            let direction = self.system.pool.powi(direction, power as i64);
            product = self.system.pool.mul(product, direction);
        }
        Some(product)
    }

    /// Σ coefficient_i s_i/scale_i.
    fn direction(&mut self, linear: &Linear, root: usize) -> Expr {
        let mut terms = Vec::new();
        for (component, coefficient) in linear {
            let coefficient = match self.product(coefficient) {
                Some(product) => product,
                None => self.plain(coefficient),
            };
            let root = &self.roots[root];
            let (scale, symbol) = (root.components[*component].scale, root.directions[*component]);
            let s = self.system.pool.sym(symbol);
            let unscaled = self.system.pool.div(s, scale);
            terms.push(self.system.pool.mul(coefficient, unscaled));
        }
        self.system.pool.sum(terms)
    }

    /// The product of the images of factors.
    fn plain(&mut self, factors: &[Factor]) -> Expr {
        let mut product = self.system.pool.int(1);
        for factor in factors {
            let base = self.image[&factor.base];
            let exponent = self.system.pool.rational(factor.exponent.clone());
            let power = self.system.pool.pow(base, exponent);
            product = self.system.pool.mul(product, power);
        }
        product
    }

    /// Multiplies out a sum that holds `1/√S` where the numerator that vanishes stands outside of it.
    fn distribute(&mut self, factors: &[Factor]) -> Option<Expr> {
        for (at, factor) in factors.iter().enumerate() {
            if factor.exponent != Rational::ONE || !matches!(self.system.pool.node(factor.base), Node::Add(..)) {
                continue;
            }
            let terms: Vec<Vec<Factor>> = sum_terms(self.system, factor.base)
                .into_iter()
                .map(|term| {
                    let mut list = Vec::new();
                    self.flatten(term, &Rational::ONE, &mut list);
                    list
                })
                .collect();
            let open: FxHashSet<usize> = terms
                .iter()
                .flatten()
                .filter(|f| half_powers(&f.exponent).is_some_and(|copies| copies % 2 == 1))
                .filter_map(|f| self.squares.get(&f.base).copied().flatten())
                .collect();
            let others: Vec<Factor> =
                factors.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, f)| f.clone()).collect();
            let wanted = open
                .into_iter()
                .any(|root| others.iter().any(|f| whole(&f.exponent) > 0 && self.linear(f.base, root).is_some()));
            if !wanted {
                continue;
            }
            let mut sum = Vec::new();
            for mut term in terms {
                term.extend(others.iter().cloned());
                sum.push(match self.product(&term) {
                    Some(product) => product,
                    None => self.plain(&term),
                });
            }
            return Some(self.system.pool.sum(sum));
        }
        None
    }

    /// `e` as Σ coefficient · base_i over the components of a root, if it is one.
    fn linear(&mut self, e: Expr, root: usize) -> Option<Linear> {
        let bases: Vec<Expr> = self.roots[root].components.iter().map(|c| c.base).collect();
        if let Some(i) = bases.iter().position(|&b| b == e) {
            return Some(vec![(i, Vec::new())]);
        }
        match self.system.pool.node(e) {
            Node::Mul(..) => {
                let mut factors = Vec::new();
                self.flatten(e, &Rational::ONE, &mut factors);
                // A component that is itself a product.
                for (i, &base) in bases.iter().enumerate() {
                    if !matches!(self.system.pool.node(base), Node::Mul(..)) {
                        continue;
                    }
                    let mut wanted = Vec::new();
                    self.flatten(base, &Rational::ONE, &mut wanted);
                    let mut rest = factors.clone();
                    let all = wanted.iter().all(|w| {
                        let found = rest.iter().position(|f| f.base == w.base && f.exponent == w.exponent);
                        found.map(|at| rest.remove(at)).is_some()
                    });
                    if all {
                        return Some(vec![(i, rest)]);
                    }
                }
                for at in 0..factors.len() {
                    if whole(&factors[at].exponent) == 0 {
                        continue;
                    }
                    if let Some(mut linear) = self.linear(factors[at].base, root) {
                        let mut others = factors.clone();
                        let one_less = &factors[at].exponent - Rational::ONE;
                        others[at].exponent = one_less;
                        others.retain(|f| f.exponent != Rational::ZERO);
                        for (_, coefficient) in &mut linear {
                            coefficient.extend(others.iter().cloned());
                        }
                        return Some(linear);
                    }
                }
                None
            }
            Node::Add(..) => {
                let mut all = Linear::new();
                for term in sum_terms(self.system, e) {
                    match self.linear(term, root) {
                        Some(linear) => all.extend(linear),
                        None => return self.same_as_component(e, &bases),
                    }
                }
                Some(all)
            }
            _ => None,
        }
    }

    /// A sum that equals a component, or its negative, though it is written otherwise.
    fn same_as_component(&mut self, e: Expr, bases: &[Expr]) -> Option<Linear> {
        let pool = &mut self.system.pool;
        for (i, &base) in bases.iter().enumerate() {
            if !matches!(pool.node(base), Node::Add(..)) {
                continue;
            }
            let (difference, sum) = (pool.sub(e, base), pool.add(e, base));
            let (difference, sum) = (pool.simplify(difference), pool.simplify(sum));
            if pool.is_zero(difference) {
                return Some(vec![(i, Vec::new())]);
            }
            if pool.is_zero(sum) {
                let minus = pool.int(-1);
                self.image.insert(minus, minus);
                return Some(vec![(i, vec![Factor { base: minus, exponent: Rational::ONE }])]);
            }
        }
        None
    }
}

/// The terms of a sum.
pub(crate) fn sum_terms(system: &System, e: Expr) -> Vec<Expr> {
    let mut terms = Vec::new();
    let mut stack = vec![e];
    while let Some(e) = stack.pop() {
        match system.pool.node(e) {
            Node::Add(a, b) => stack.extend([b, a]),
            _ => terms.push(e),
        }
    }
    terms
}

pub(crate) fn half(numerator: i8) -> Rational {
    Rational::from(numerator) / Rational::from(2u8)
}

/// `q` if the exponent is `-q/2` with a positive integer q.
fn half_powers(exponent: &Rational) -> Option<usize> {
    let doubled = exponent * Rational::from(-2i8);
    if doubled.is_int() { usize::try_from(doubled.numerator()).ok().filter(|q| *q > 0) } else { None }
}

/// The exponent if it is a positive integer, else 0.
fn whole(exponent: &Rational) -> usize {
    if exponent.is_int() { usize::try_from(exponent.numerator()).unwrap_or(0) } else { 0 }
}
