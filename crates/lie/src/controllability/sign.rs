//! The sign that an expression keeps near a point.

use std::cmp::Ordering;

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Rational, Symbol, ZeroTest};
use nalgebra::DMatrix;
use rustc_hash::FxHashMap;

use crate::controllability::local_accessibility::Frame;
use crate::linear::form::signs;
use crate::linear::matrix::RationalMatrix;
use crate::linear::taylor::Terms;
use bracketry_numerics::eigen::symmetric_eigen;

/// The sign of a function in a neighborhood of a point, or everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sign {
    Zero,
    Positive,
    Negative,
    NonNegative,
    NonPositive,
    Unknown,
}

impl Sign {
    pub(crate) fn opposite(self) -> Sign {
        match self {
            Sign::Positive => Sign::Negative,
            Sign::Negative => Sign::Positive,
            Sign::NonNegative => Sign::NonPositive,
            Sign::NonPositive => Sign::NonNegative,
            same => same,
        }
    }

    pub(crate) fn at_least_zero(self) -> bool {
        matches!(self, Sign::Zero | Sign::Positive | Sign::NonNegative)
    }

    fn plus(self, other: Sign) -> Sign {
        if self == Sign::Zero {
            other
        } else if other == Sign::Zero {
            self
        } else if self.at_least_zero() && other.at_least_zero() {
            if self == Sign::Positive || other == Sign::Positive { Sign::Positive } else { Sign::NonNegative }
        } else if self.opposite().at_least_zero() && other.opposite().at_least_zero() {
            self.opposite().plus(other.opposite()).opposite()
        } else {
            Sign::Unknown
        }
    }

    pub(crate) fn times(self, other: Sign) -> Sign {
        match (self, other) {
            (Sign::Zero, _) | (_, Sign::Zero) => Sign::Zero,
            (Sign::Unknown, _) | (_, Sign::Unknown) => Sign::Unknown,
            (Sign::Positive, s) | (s, Sign::Positive) => s,
            (Sign::Negative, s) | (s, Sign::Negative) => s.opposite(),
            (a, b) if a == b => Sign::NonNegative,
            _ => Sign::NonPositive,
        }
    }
}

/// Larger expressions, written out as trees, are not looked at.
const MAX_TREE: f64 = 2_000.0;
/// Degree of the Taylor polynomials of functions that are no polynomials.
const DEGREE: u32 = 6;
/// Deeper expressions are not looked into.
const MAX_DEPTH: usize = 60;

/// Signs near the origin of the `variables`, or for all their values; other symbols are parameters.
pub(crate) struct NearOrigin<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) variables: Vec<Symbol>,
    /// Whether the signs hold for all values of the variables for which the functions are defined.
    pub(crate) everywhere: bool,
}

impl NearOrigin<'_> {
    /// The sign of `e` near the origin (or everywhere), where it can be seen from its factors and terms, also of its
    /// expanded form, or from its second derivatives.
    pub(crate) fn sign(&self, pool: &mut Pool, e: Expr) -> Sign {
        if pool.tree_size(e) > MAX_TREE {
            return Sign::Unknown;
        }
        match self.look(pool, e, 0) {
            Sign::Unknown => {
                let expanded = pool.expand(e);
                let seen = if expanded == e || pool.tree_size(expanded) > MAX_TREE {
                    Sign::Unknown
                } else {
                    self.look(pool, expanded, 0)
                };
                if seen == Sign::Unknown { self.by_leading_terms(pool, expanded) } else { seen }
            }
            seen => seen,
        }
    }

    /// The sign near the origin that the leading terms of a polynomial, or of a Taylor polynomial, decide.
    fn by_leading_terms(&self, pool: &mut Pool, e: Expr) -> Sign {
        if self.everywhere {
            return Sign::Unknown;
        }
        let e = self.frame.constants_in(pool, e);
        let (terms, remainder) = match Terms::of(pool, e, &self.variables) {
            Some(terms) => (Some(terms), None),
            None => (Terms::taylor(pool, e, &self.variables, DEGREE as usize), Some(DEGREE)),
        };
        let Some(p) = terms.and_then(|terms| terms.alone(pool)) else { return Sign::Unknown };
        let opposite = p.negative();
        match (p.is_nonnegative_near_origin(remainder), opposite.is_nonnegative_near_origin(remainder)) {
            (true, false) => Sign::NonNegative,
            (false, true) => Sign::NonPositive,
            (true, true) => Sign::Zero,
            (false, false) => Sign::Unknown,
        }
    }

    /// What stands for the variables at the origin.
    fn origin(&self, pool: &mut Pool) -> FxHashMap<Expr, Expr> {
        let zero = pool.int(0);
        self.variables.iter().map(|&s| (pool.sym(s), zero)).collect()
    }

    fn at_origin(&self, pool: &mut Pool, e: Expr) -> Expr {
        let origin = self.origin(pool);
        pool.substitute(e, &origin)
    }

    fn look(&self, pool: &mut Pool, e: Expr, depth: usize) -> Sign {
        if pool.is_zero(e) {
            return Sign::Zero;
        }
        if depth > MAX_DEPTH {
            return Sign::Unknown;
        }
        let fixed = !self.everywhere || !pool.symbols_of(&[e]).iter().any(|s| self.variables.contains(s));
        if fixed {
            let here = self.at_origin(pool, e);
            match self.frame.sign(pool, here) {
                Some(Ordering::Greater) => return Sign::Positive,
                Some(Ordering::Less) => return Sign::Negative,
                Some(Ordering::Equal) if here == e => return Sign::Zero,
                None if self.frame.numbers(pool, &[here]).is_none() => return Sign::Unknown,
                Some(Ordering::Equal) | None => {}
            }
        }
        let seen = match pool.node(e) {
            Node::Add(..) => {
                let mut terms = Vec::new();
                flatten(pool, e, &mut terms, |n| if let Node::Add(a, b) = n { Some((a, b)) } else { None });
                let mut total = Sign::Zero;
                for t in terms {
                    let s = self.look(pool, t, depth + 1);
                    total = total.plus(s);
                    if total == Sign::Unknown {
                        break;
                    }
                }
                if total == Sign::Unknown {
                    total = self.around_a_wave(pool, e);
                }
                if total == Sign::Unknown { form_in_factors(pool, e) } else { total }
            }
            Node::Mul(..) => self.product(pool, e, depth),
            Node::Pow(base, exponent) => self.power(pool, base, exponent, depth),
            Node::Call(f, a) => match f {
                Func::Abs | Func::Cosh => Sign::NonNegative,
                Func::Exp => Sign::Positive,
                // Increasing through the origin.
                Func::Sin | Func::Tan if self.everywhere => Sign::Unknown,
                Func::Sin | Func::Tan | Func::Asin | Func::Atan | Func::Sinh | Func::Tanh => {
                    if self.vanishes_at_origin(pool, a) { self.look(pool, a, depth + 1) } else { Sign::Unknown }
                }
                _ => Sign::Unknown,
            },
            Node::Num(_) | Node::Pi | Node::Sym(_) | Node::Call2(..) => Sign::Unknown,
        };
        if seen == Sign::Unknown && depth == 0 { self.extremum(pool, e) } else { seen }
    }

    fn vanishes_at_origin(&self, pool: &mut Pool, e: Expr) -> bool {
        let at = self.at_origin(pool, e);
        let at = self.frame.constants_in(pool, at);
        matches!(pool.zero_test(at, &Bindings::new()), ZeroTest::Zero(_))
    }

    fn product(&self, pool: &mut Pool, e: Expr, depth: usize) -> Sign {
        let mut factors = Vec::new();
        flatten(pool, e, &mut factors, |n| if let Node::Mul(a, b) = n { Some((a, b)) } else { None });
        // Equal bases with integer powers are counted together, odd increasing functions by their arguments.
        let mut bases: Vec<(Expr, i64)> = Vec::new();
        let mut sign = Sign::Positive;
        let mut next = 0;
        while let Some(&factor) = factors.get(next) {
            next += 1;
            if let Node::Call(Func::Tanh | Func::Atan | Func::Sinh, a) = pool.node(factor) {
                flatten(pool, a, &mut factors, |n| if let Node::Mul(a, b) = n { Some((a, b)) } else { None });
                continue;
            }
            let (base, k) = match pool.node(factor) {
                Node::Pow(b, k) => match pool.integer(k) {
                    Some(k) if k > 0 => (b, k),
                    _ => (factor, 1),
                },
                _ => (factor, 1),
            };
            match bases.iter_mut().find(|(b, _)| *b == base) {
                Some((_, n)) => *n += k,
                None => bases.push((base, k)),
            }
        }
        for (base, k) in bases {
            let of_factor = if k % 2 == 0 { self.even(pool, base) } else { self.look(pool, base, depth + 1) };
            sign = sign.times(of_factor);
        }
        sign
    }

    fn even(&self, pool: &mut Pool, base: Expr) -> Sign {
        let here = self.at_origin(pool, base);
        match self.frame.sign(pool, here) {
            Some(Ordering::Less | Ordering::Greater) if !self.everywhere => Sign::Positive,
            _ => Sign::NonNegative,
        }
    }

    /// c + Σ a_i sin(…) + Σ b_j cos(…) with constants of which |c| is no less than the sum of the others.
    fn around_a_wave(&self, pool: &mut Pool, e: Expr) -> Sign {
        if !self.everywhere {
            return Sign::Unknown;
        }
        let mut terms = Vec::new();
        flatten(pool, e, &mut terms, |n| if let Node::Add(a, b) = n { Some((a, b)) } else { None });
        let (mut constant, mut amplitudes) = (Rational::ZERO, Rational::ZERO);
        for term in terms {
            let mut factors = Vec::new();
            flatten(pool, term, &mut factors, |n| if let Node::Mul(a, b) = n { Some((a, b)) } else { None });
            let (waves, others): (Vec<Expr>, Vec<Expr>) =
                factors.into_iter().partition(|&f| matches!(pool.node(f), Node::Call(Func::Sin | Func::Cos, _)));
            let one = pool.int(1);
            let factor = others.into_iter().fold(one, |product, f| pool.mul(product, f));
            let Some(value) = self.frame.rationals(pool, &[factor]).map(|v| v[0].clone()) else {
                return Sign::Unknown;
            };
            if waves.is_empty() {
                constant += value;
            } else {
                amplitudes += if value < Rational::ZERO { -value } else { value };
            }
        }
        match (constant >= amplitudes, -constant >= amplitudes) {
            (true, false) => Sign::NonNegative,
            (false, true) => Sign::NonPositive,
            _ => Sign::Unknown,
        }
    }

    fn power(&self, pool: &mut Pool, base: Expr, exponent: Expr, depth: usize) -> Sign {
        match pool.integer(exponent) {
            Some(k) if k > 0 && k % 2 == 0 => Sign::NonNegative,
            Some(k) if k > 0 => self.look(pool, base, depth + 1),
            // A root is defined where its base is not negative, and not negative there.
            None if pool.number(exponent).is_some_and(|k| *k > Rational::ZERO) => Sign::NonNegative,
            _ => Sign::Unknown,
        }
    }

    /// An extremum with value 0: the gradient vanishes and the second derivatives by the
    /// variables that occur are definite, or constant and semidefinite.
    fn extremum(&self, pool: &mut Pool, e: Expr) -> Sign {
        let smooth = |n: Node| !matches!(n, Node::Call(Func::Abs | Func::Sign, _) | Node::Call2(..));
        if !pool.reachable(&[e]).into_iter().all(|n| smooth(pool.node(n))) {
            return Sign::Unknown;
        }
        let used: Vec<Symbol> = pool.symbols_of(&[e]).into_iter().filter(|s| self.variables.contains(s)).collect();
        let gradient = pool.gradient(e, &used);
        if used.is_empty()
            || used.len() > 8
            || !std::iter::once(&e).chain(&gradient).all(|&d| self.vanishes_at_origin(pool, d))
        {
            return Sign::Unknown;
        }
        let origin = self.origin(pool);
        let second = pool.jacobian(&gradient, &used).concat();
        let constant = !second.iter().any(|&e| used.iter().any(|&s| pool.depends_on(e, s)));
        let second = pool.substitute_all(&second, &origin);
        let Some(values) = self.frame.numbers(pool, &second) else { return Sign::Unknown };
        let matrix = DMatrix::from_row_slice(used.len(), used.len(), &values);
        if self.everywhere && !constant {
            return Sign::Unknown;
        }
        // As many clear eigenvalues as the exact rank: what is zero would be definite by rounding. A quadratic function may also
        // be semidefinite.
        let at: Vec<Expr> = second.into_iter().map(|e| self.frame.constants_in(pool, e)).collect();
        let rows: Vec<Vec<Expr>> = at.chunks(used.len()).map(<[Expr]>::to_vec).collect();
        let Ok(rank) = pool.rank(&rows, &Bindings::new()) else { return Sign::Unknown };
        if !constant && rank.rank < used.len() {
            return Sign::Unknown;
        }
        let Some(eigenvalues) = symmetric_eigen(matrix).map(|e| e.eigenvalues) else { return Sign::Unknown };
        let clear = CONDITION * eigenvalues.amax();
        let rising = eigenvalues.iter().filter(|l| **l > clear).count();
        let falling = eigenvalues.iter().filter(|l| **l < -clear).count();
        match (rising == rank.rank, falling == rank.rank) {
            (true, false) => Sign::NonNegative,
            (false, true) => Sign::NonPositive,
            _ => Sign::Unknown,
        }
    }
}

/// The sign of a sum Σ c_ij a_i a_j with rational c_ij, as that of a quadratic form in the factors a_i, whatever they are.
fn form_in_factors(pool: &mut Pool, e: Expr) -> Sign {
    let mut terms = Vec::new();
    flatten(pool, e, &mut terms, |n| if let Node::Add(a, b) = n { Some((a, b)) } else { None });
    let mut atoms: Vec<Expr> = Vec::new();
    let mut entries: Vec<(usize, usize, Rational)> = Vec::new();
    for term in terms {
        let mut factors = Vec::new();
        flatten(pool, term, &mut factors, |n| if let Node::Mul(a, b) = n { Some((a, b)) } else { None });
        let (mut coefficient, mut places) = (Rational::ONE, Vec::new());
        for factor in factors {
            if let Some(c) = pool.number(factor) {
                coefficient *= c;
                continue;
            }
            let (base, count) = match pool.node(factor) {
                Node::Pow(base, k) if pool.integer(k) == Some(2) => (base, 2),
                _ => (factor, 1),
            };
            let place = atoms.iter().position(|a| *a == base).unwrap_or(atoms.len());
            if place == atoms.len() {
                atoms.push(base);
            }
            places.extend(std::iter::repeat_n(place, count));
        }
        let [i, j] = places[..] else { return Sign::Unknown };
        entries.push((i, j, coefficient));
    }
    let mut rows = vec![vec![Rational::ZERO; atoms.len()]; atoms.len()];
    for (i, j, c) in entries {
        let half = c / Rational::from(2);
        rows[i][j] += &half;
        rows[j][i] += &half;
    }
    let columns = rows.len();
    match signs(&RationalMatrix::new(rows, columns)) {
        Some((false, false)) => Sign::Zero,
        Some((true, false)) => Sign::NonNegative,
        Some((false, true)) => Sign::NonPositive,
        Some((true, true)) | None => Sign::Unknown,
    }
}

/// Smallest quotient of eigenvalues of a matrix that counts as definite.
const CONDITION: f64 = 1e-7;

/// Whether a symmetric matrix is positive (true) or negative (false) definite.
pub(crate) fn definite(q: &DMatrix<f64>) -> Option<bool> {
    let values = symmetric_eigen((q + q.transpose()) * 0.5)?.eigenvalues;
    let (least, most) = (values.min(), values.max());
    let clear = CONDITION * least.abs().max(most.abs());
    if least > clear {
        Some(true)
    } else if most < -clear {
        Some(false)
    } else {
        None
    }
}

fn flatten(pool: &Pool, e: Expr, out: &mut Vec<Expr>, split: fn(Node) -> Option<(Expr, Expr)>) {
    match split(pool.node(e)) {
        Some((a, b)) => {
            flatten(pool, a, out, split);
            flatten(pool, b, out, split);
        }
        None => out.push(e),
    }
}
