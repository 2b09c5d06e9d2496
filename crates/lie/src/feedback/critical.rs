//! Equilibria of zero dynamics that the linearization does not decide.

use std::cmp::Ordering;

use bracketry_symbolic::{Expr, Func, Function, Node, OrderedField, Pool, Rational, Real, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::integrals::search::integrals_of_involutive;
use crate::evidence::Evidence;
use crate::feedback::center_pair::CenterPair;
use crate::feedback::logarithmic_integral::logarithmic_integrals;
use crate::feedback::lyapunov::{PolynomialField, Shown};
use crate::feedback::zero_dynamics::Set;
use crate::linear::matrix::{Matrix, semidefinite};
use crate::linear::polynomial::{MultivariatePolynomial, RealPolynomial};
use crate::linear::taylor::{Terms, reals};
use crate::reason::MinimumPhaseReason;

/// Order of the expansion on the center manifold, and most coordinates for a pair ±iω.
const ORDER: usize = 5;
const MAX_COORDINATES: usize = 6;

/// z' = F(z) on a set, with an equilibrium at its point.
pub(crate) struct Critical<'a> {
    pub(crate) set: &'a Set<'a>,
    pub(crate) states: &'a [Symbol],
    pub(crate) equations: &'a [Expr],
    /// Eigenvalues on the imaginary axis; the others have negative real parts.
    pub(crate) on_axis: usize,
}

impl Critical<'_> {
    /// Whether the equilibrium is asymptotically stable, by a polynomial Lyapunov function, a center manifold of dimension 1, a
    /// pair ±iω, or a first integral; `None` if none of them decides.
    pub(crate) fn decide(&self, pool: &mut Pool, evidence: &mut Evidence) -> Option<(bool, MinimumPhaseReason)> {
        let (symbols, components) = self.about_the_point(pool)?;
        let terms: Option<Vec<Terms>> = components.iter().map(|&e| Terms::of(pool, e, &symbols)).collect();
        let polynomials = terms.and_then(|terms| Terms::with_values(pool, &terms, evidence));
        if let Some(found) = polynomials.as_ref().and_then(|p| PolynomialField(p).shown())
            && let Some(reason) = self.reason(pool, &symbols, &found)
        {
            return Some(reason);
        }
        let expanded = polynomials.or_else(|| {
            let terms: Option<Vec<Terms>> =
                components.iter().map(|&e| Terms::taylor(pool, e, &symbols, ORDER)).collect();
            Terms::with_values(pool, &terms?, evidence)
        });
        expanded.and_then(|field| self.on_center_manifold(&field)).or_else(|| self.first_integral(pool, evidence))
    }

    /// By a center manifold of dimension 1, or that of a pair ±iω.
    fn on_center_manifold(&self, field: &[RealPolynomial]) -> Option<(bool, MinimumPhaseReason)> {
        if self.on_axis == 1 {
            let (order, c) = PolynomialField(field).on_center_manifold(ORDER)?;
            let falls = c.sign()? == Ordering::Less;
            return Some((order % 2 == 1 && falls, MinimumPhaseReason::CenterManifold { order, falls }));
        }
        if self.on_axis == 2 && field.len() <= MAX_COORDINATES {
            let (order, l) = CenterPair::of(field, 0)?.focal_value(ORDER as u32)?;
            let falls = l.sign()? == Ordering::Less;
            return Some((falls, MinimumPhaseReason::FocalValue { order, falls }));
        }
        None
    }

    /// The equations in deviations from the point, parameters at their values, with a symbol for each deviation.
    fn about_the_point(&self, pool: &mut Pool) -> Option<(Vec<Symbol>, Vec<Expr>)> {
        let mut symbols = Vec::new();
        let mut moved: FxHashMap<Expr, Expr> = FxHashMap::default();
        for &z in self.states {
            let deviation = pool.symbol(&format!("offset of {}", pool.name(z)));
            symbols.push(deviation);
            let deviation = pool.sym(deviation);
            let value = *self.set.point.get(&z)?;
            let sum = pool.add(value, deviation);
            moved.insert(pool.sym(z), sum);
        }
        let equations = pool.substitute_all(self.equations, &moved);
        let equations = self.with_values(pool, &equations);
        Some((symbols, equations))
    }

    /// Expressions with parameters at their values.
    fn with_values(&self, pool: &mut Pool, list: &[Expr]) -> Vec<Expr> {
        let mut values: FxHashMap<Expr, Expr> = FxHashMap::default();
        for s in pool.symbols_of(list) {
            if let Some(value) = self.set.fields.bindings.get(s).cloned() {
                let x = pool.sym(s);
                values.insert(x, pool.rational(value));
            }
        }
        pool.substitute_all(list, &values)
    }

    /// `None` where a coefficient is too long to be shown.
    fn reason(&self, pool: &mut Pool, symbols: &[Symbol], shown: &Shown) -> Option<(bool, MinimumPhaseReason)> {
        let (Shown::Attracts(v) | Shown::Conserved(v) | Shown::Repels(v)) = shown;
        let mut sum = pool.int(0);
        for (m, c) in v.terms() {
            let mut term = c.expression(pool)?;
            for (&s, &k) in symbols.iter().zip(m) {
                let x = pool.sym(s);
                let power = pool.powi(x, i64::from(k));
                term = pool.mul(term, power);
            }
            sum = pool.add(sum, term);
        }
        let mut back: FxHashMap<Expr, Expr> = FxHashMap::default();
        for (&s, &z) in symbols.iter().zip(self.states) {
            let x = pool.sym(z);
            if let Some(&value) = self.set.point.get(&z) {
                let deviation = pool.sub(x, value);
                back.insert(pool.sym(s), deviation);
            }
        }
        let v = pool.substitute(sum, &back);
        let function = Function::new(pool, v);
        Some(match shown {
            Shown::Attracts(_) => (true, MinimumPhaseReason::Lyapunov { function }),
            Shown::Conserved(_) => (false, MinimumPhaseReason::Conserved { function, stable: true }),
            Shown::Repels(_) => (false, MinimumPhaseReason::Repels { function }),
        })
    }

    /// A function that is smooth at the point and constant along the motion: where all motions from a neighborhood reached the
    /// equilibrium, it would have one value there, and analytic functions that are constant nearby are constant.
    fn first_integral(&self, pool: &mut Pool, evidence: &mut Evidence) -> Option<(bool, MinimumPhaseReason)> {
        let bindings = &self.set.fields.bindings;
        let basis = [self.equations.to_vec()];
        let found = integrals_of_involutive(pool, self.states, &basis, &[], bindings, evidence).ok()?;
        let mut smooth: Vec<Expr> =
            found.functions.into_iter().filter(|&h| self.analytic_at_point(pool, h, evidence)).collect();
        smooth.extend(self.with_logarithms(pool));
        let extremum = smooth.iter().copied().find(|&h| self.has_strict_extremum(pool, h, evidence));
        let function = extremum.or_else(|| smooth.first().copied())?;
        let function = Function::new(pool, function);
        Some((false, MinimumPhaseReason::Conserved { function, stable: extremum.is_some() }))
    }

    /// Integrals with logarithms of states that are not zero at the point, such as those of predator and prey.
    fn with_logarithms(&self, pool: &mut Pool) -> Vec<Expr> {
        let states: Vec<Expr> = self.states.iter().map(|&z| pool.sym(z)).collect();
        let Some(values) = self.set.rationals(pool, &states) else { return Vec::new() };
        let signs: Vec<Option<bool>> =
            values.iter().map(|v| (*v != Rational::ZERO).then_some(*v > Rational::ZERO)).collect();
        let equations = self.with_values(pool, self.equations);
        let field: Option<Vec<MultivariatePolynomial>> =
            equations.into_iter().map(|e| MultivariatePolynomial::of(pool, e, self.states)).collect();
        field.map_or_else(Vec::new, |field| logarithmic_integrals(pool, self.states, &signs, &field))
    }

    /// Whether nothing in the function is seen to fail at the point: denominators do not vanish there, and other powers and
    /// functions than those analytic everywhere do not occur.
    fn analytic_at_point(&self, pool: &mut Pool, h: Expr, evidence: &mut Evidence) -> bool {
        pool.reachable(&[h]).into_iter().all(|e| match pool.node(e) {
            Node::Pow(base, k) => match pool.integer(k) {
                Some(k) if k >= 0 => true,
                Some(_) => self.set.vanishes_at_point(pool, base, evidence) == Some(false),
                None => false,
            },
            Node::Num(_)
            | Node::Pi
            | Node::Sym(_)
            | Node::Add(..)
            | Node::Mul(..)
            | Node::Call(Func::Sin | Func::Cos | Func::Exp | Func::Sinh | Func::Cosh | Func::Tanh | Func::Atan, _) => {
                true
            }
            Node::Call(..) | Node::Call2(..) => false,
        })
    }

    /// Whether the gradient vanishes at the point and the second derivatives are definite there.
    fn has_strict_extremum(&self, pool: &mut Pool, h: Expr, evidence: &mut Evidence) -> bool {
        let gradient = pool.gradient(h, self.states);
        if !gradient.iter().all(|&d| self.set.vanishes_at_point(pool, d, evidence) == Some(true)) {
            return false;
        }
        let second = pool.jacobian(&gradient, self.states).concat();
        let second = self.set.values_at_point(pool, &second);
        let Some(values) = reals(pool, &second, evidence) else { return false };
        let k = self.states.len();
        let rows: Vec<Vec<Real>> = values.chunks(k).map(<[Real]>::to_vec).collect();
        let opposite = rows.iter().map(|r| r.iter().map(|x| -x).collect()).collect();
        Matrix::new(rows.clone(), k).null_space().is_empty()
            && (semidefinite(rows) == Some(true) || semidefinite(opposite) == Some(true))
    }
}
