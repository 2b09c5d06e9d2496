//! Fields of two modes on the surface between them.

use bracketry_symbolic::{Bindings, Expr, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::field::{Field, bracket};
use crate::algebra::span::vanishes;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

/// A surface s = 0, solved for a coordinate in which s is affine.
pub(crate) struct Surface {
    pub(crate) function: Expr,
    /// Number of the coordinate.
    pub(crate) coordinate: usize,
    /// The coordinate as a function of the others.
    solution: FxHashMap<Expr, Expr>,
}

impl Surface {
    /// None if s is affine in no coordinate with a slope that does not vanish everywhere.
    pub(crate) fn solve(pool: &mut Pool, states: &[Symbol], s: Expr, bindings: &Bindings) -> Option<Surface> {
        let zero = pool.int(0);
        let mut best: Option<(usize, usize, Expr)> = None;
        for (i, &x) in states.iter().enumerate() {
            let slope = pool.diff(s, x);
            let slope = pool.simplify(slope);
            if pool.depends_on(slope, x) || vanishes(pool, slope, bindings) {
                continue;
            }
            if !pool.zero_test(slope, bindings).is_nonzero() {
                continue;
            }
            let symbols = pool.symbols_of(&[slope]);
            let effort = if symbols.iter().any(|y| states.contains(y)) { 2 } else { usize::from(!symbols.is_empty()) };
            if best.as_ref().is_none_or(|b| effort < b.0) {
                best = Some((effort, i, slope));
            }
        }
        let (_, coordinate, slope) = best?;
        let x = pool.sym(states[coordinate]);
        let rest = pool.substitute(s, &std::iter::once((x, zero)).collect());
        let quotient = pool.div(rest, slope);
        let value = pool.neg(quotient);
        let value = pool.simplify(value);
        Some(Surface { function: s, coordinate, solution: std::iter::once((x, value)).collect() })
    }

    /// Expressions on the surface.
    pub(crate) fn restrict(&self, pool: &mut Pool, list: &[Expr]) -> Vec<Expr> {
        pool.substitute_all(list, &self.solution)
    }

    /// L_y s on the surface.
    pub(crate) fn normal(&self, pool: &mut Pool, states: &[Symbol], y: &[Expr]) -> Expr {
        let along = pool.lie_derivative(self.function, states, y);
        self.restrict(pool, &[along])[0]
    }

    /// A field on the surface that is tangent to it, in the coordinates that are left.
    fn inner(&self, mut field: Field) -> Field {
        field.remove(self.coordinate);
        field
    }

    /// The coordinates that are left.
    pub(crate) fn states(&self, states: &[Symbol]) -> Vec<Symbol> {
        let mut left = states.to_vec();
        left.remove(self.coordinate);
        left
    }
}

/// A distribution on one side of a surface, with fields of the mode there.
pub(crate) struct Side<'a> {
    /// Independent fields that span the distribution at a generic point.
    pub(crate) basis: &'a [Field],
    /// The fields that generate the motion in the mode: drift first.
    pub(crate) generators: &'a [Field],
}

/// Rounds of brackets with the crossing field before a rank on the surface is given up.
const ROUNDS: usize = 3;

impl Side<'_> {
    /// A generator that crosses the surface at a generic point of it.
    pub(crate) fn crossing(
        &self,
        pool: &mut Pool,
        states: &[Symbol],
        surface: &Surface,
        bindings: &Bindings,
    ) -> Option<Field> {
        // Input fields first: they are simpler.
        let found = self.generators.iter().rev().find(|y| {
            let normal = surface.normal(pool, states, y);
            !pool.is_zero(normal) && pool.zero_test(normal, bindings).is_nonzero()
        });
        found.cloned()
    }

    /// Fields on the surface that span the part of the distribution that is tangent to it; none if no generator crosses it.
    ///
    /// Where the generator h crosses the surface, the flow of h keeps the rank of the distribution constant, so that it has
    /// its generic rank d at a generic point of the surface. A basis over the functions may lose rank there; with
    /// y(exp(τh)) = Σ τ^k/k! ad_h^k y the brackets with h make up for that. A field y of the distribution becomes
    /// tangent as y − (L_y s/L_h s) h.
    pub(crate) fn tangent(
        &self,
        pool: &mut Pool,
        states: &[Symbol],
        surface: &Surface,
        bindings: &Bindings,
        evidence: &mut Evidence,
    ) -> Result<Option<Vec<Field>>, Undecided> {
        let Some(h) = self.crossing(pool, states, surface, bindings) else { return Ok(None) };
        let mut fields = self.basis.to_vec();
        let mut first = 0;
        for round in 0.. {
            let on_surface: Vec<Field> = fields.iter().map(|y| surface.restrict(pool, y)).collect();
            evidence.allow_elimination(on_surface.len(), states.len())?;
            let rank = pool.rank(&on_surface, bindings)?;
            evidence.add(&rank.certificate);
            if rank.rank == self.basis.len() {
                fields = rank.independent.iter().map(|&i| fields[i].clone()).collect();
                break;
            }
            if round == ROUNDS {
                return Err(Undecided::Exact(bracketry_symbolic::Undecided::TooComplex));
            }
            let last = fields.len();
            for k in first..last {
                let z = bracket(pool, states, &h, &fields[k]);
                fields.push(z);
            }
            first = last;
        }
        let across = surface.normal(pool, states, &h);
        let h = surface.restrict(pool, &h);
        let mut tangent = Vec::new();
        for y in fields {
            let normal = surface.normal(pool, states, &y);
            let mut y = surface.restrict(pool, &y);
            if !pool.is_zero(normal) {
                let factor = pool.div(normal, across);
                for (e, &c) in y.iter_mut().zip(&h) {
                    let part = pool.mul(factor, c);
                    *e = pool.sub(*e, part);
                }
            }
            tangent.push(surface.inner(y));
        }
        Ok(Some(tangent))
    }

    /// The generators on a surface that none of them crosses.
    pub(crate) fn within(&self, pool: &mut Pool, surface: &Surface) -> Vec<Field> {
        self.generators.iter().map(|y| surface.restrict(pool, y)).map(|y| surface.inner(y)).collect()
    }
}

/// Whether and how motion along the surface itself (Filippov 1988) adds to that of the modes on its sides.
pub(crate) enum Sliding {
    /// Both modes cross the surface at the same rate up to a positive constant factor, whatever the inputs: a mixture of them
    /// is tangent only where both are.
    None,
    /// These fields, for rates that no input changes.
    Fields(Vec<Field>),
    /// The inputs change the rates.
    Open,
}

impl Sliding {
    /// For generators of the two modes in the same order, drift first.
    pub(crate) fn of(
        pool: &mut Pool,
        states: &[Symbol],
        surface: &Surface,
        sides: [&[Field]; 2],
        bindings: &Bindings,
    ) -> Sliding {
        let mut rates: [Vec<Expr>; 2] = [Vec::new(), Vec::new()];
        for (list, side) in rates.iter_mut().zip(sides) {
            for y in side {
                let rate = surface.normal(pool, states, y);
                list.push(if vanishes(pool, rate, bindings) { pool.int(0) } else { rate });
            }
        }
        let [plus, minus] = &rates;
        // One constant factor for all.
        let mut factor = None;
        let mut equal = true;
        for (&a, &b) in plus.iter().zip(minus) {
            if pool.is_zero(a) && pool.is_zero(b) {
                continue;
            }
            if pool.is_zero(a) || pool.is_zero(b) {
                equal = false;
                break;
            }
            let factor = *factor.get_or_insert_with(|| {
                let quotient = pool.div(a, b);
                pool.simplify(quotient)
            });
            let scaled = pool.mul(factor, b);
            let gap = pool.sub(a, scaled);
            equal &= vanishes(pool, gap, bindings);
        }
        let positive = |pool: &Pool, e: Expr| pool.number(e).is_some_and(|c| *c > bracketry_symbolic::Rational::ZERO);
        if equal && factor.is_none_or(|f| positive(pool, f)) {
            return Sliding::None;
        }
        if plus[1..].iter().chain(&minus[1..]).any(|&e| !pool.is_zero(e)) {
            return Sliding::Open;
        }
        // (b f₊ − a f₋) and, for the inputs, (b g₊ − a g₋), up to the factor 1/(b − a).
        let (a, b) = (plus[0], minus[0]);
        let mut fields = Vec::new();
        for (p, m) in sides[0].iter().zip(sides[1]) {
            let (p, m) = (surface.restrict(pool, p), surface.restrict(pool, m));
            let mut field = Field::new();
            for (&x, &y) in p.iter().zip(&m) {
                let (x, y) = (pool.mul(b, x), pool.mul(a, y));
                field.push(pool.sub(x, y));
            }
            fields.push(surface.inner(field));
        }
        Sliding::Fields(fields)
    }
}
