//! The motion that is left when inputs hold the outputs.

use bracketry_symbolic::{Bindings, Expr, Function, Node, Pool, Symbol, ZeroTest};
use rustc_hash::FxHashMap;

use crate::algebra::field::VectorFields;
use crate::algebra::matrix::{determinant, solve};
use crate::algebra::rational::readable::{tidy, vanishing_factors};
use crate::budget::check_size;
use crate::evidence::Evidence;
use crate::reason::NoZeroDynamics;
use crate::undecided::Undecided;

/// The system restricted to the largest set on which some input keeps all outputs at zero
/// (zero dynamics algorithm, Isidori 1995, sec. 6.1), near a generic point of that set.
#[derive(Clone, Debug)]
pub struct ZeroDynamics {
    /// Coordinates of the set.
    pub states: Vec<Symbol>,
    /// Their time derivatives, in these coordinates (and the inputs that stay free).
    pub equations: Vec<Expr>,
    /// The other states as functions on the set.
    pub solved: Vec<(Symbol, Expr)>,
    /// The inputs that hold the outputs; `None` for one that stays free.
    pub inputs: Vec<Option<Expr>>,
    /// Functions on the set that were divided by: what is said holds where none vanishes.
    pub nonzero: Vec<Expr>,
}

impl VectorFields {
    /// The zero dynamics of `outputs`. Where a constraint has several solutions, that through
    /// `point` (one constant expression per state) is taken. `inputs` are the names under which
    /// inputs that stay free occur in the equations.
    ///
    /// # Errors
    /// [`NoZeroDynamics`].
    pub fn zero_dynamics(
        &self,
        pool: &mut Pool,
        outputs: &[Expr],
        inputs: &[Expr],
        point: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<ZeroDynamics, NoZeroDynamics> {
        let first = pool.len();
        let mut set = Set::of(self, point, self.states.clone());
        let mut constraints = outputs.to_vec();
        // Every round takes a coordinate away.
        loop {
            for c in std::mem::take(&mut constraints) {
                check_size(pool, first)?;
                set.impose(pool, c, evidence)?;
            }
            let (held, new) = set.hold(pool, inputs, evidence)?;
            if new.is_empty() {
                return set.motion(pool, inputs, &held, evidence);
            }
            constraints = new;
        }
    }
}

/// The set on which the constraints so far hold.
pub(crate) struct Set<'a> {
    pub(crate) fields: &'a VectorFields,
    /// The coordinates of the point that selects branches.
    pub(crate) point: FxHashMap<Symbol, Expr>,
    pub(crate) free: Vec<Symbol>,
    pub(crate) solved: Vec<(Symbol, Expr)>,
    pub(crate) nonzero: Vec<Expr>,
    /// The same for the inputs of the last round.
    pub(crate) pivots: Vec<Expr>,
}

/// Inputs as functions on the set: index and value.
type Held = Vec<(usize, Expr)>;

/// a + Σ b_j u_j
fn affine(pool: &mut Pool, a: Expr, b: &[Expr], inputs: &[Expr]) -> Expr {
    let mut total = a;
    for (&b, &u) in b.iter().zip(inputs) {
        let term = pool.mul(b, u);
        total = pool.add(total, term);
    }
    total
}

impl<'a> Set<'a> {
    /// With these free coordinates and nothing solved for, at `point` (one constant expression per state of `fields`).
    pub(crate) fn of(fields: &'a VectorFields, point: &[Expr], free: Vec<Symbol>) -> Self {
        let point = fields.states.iter().copied().zip(point.iter().copied()).collect();
        Set { fields, point, free, solved: Vec::new(), nonzero: Vec::new(), pivots: Vec::new() }
    }
}

impl Set<'_> {
    /// An expression on the set, in the free coordinates.
    fn restrict(&self, pool: &mut Pool, e: Expr) -> Expr {
        let map: FxHashMap<Expr, Expr> = self.solved.iter().map(|&(s, v)| (pool.sym(s), v)).collect();
        let e = pool.substitute(e, &map);
        tidy(pool, e)
    }

    /// Solves `constraint = 0` on the set for a coordinate.
    fn impose(&mut self, pool: &mut Pool, constraint: Expr, evidence: &mut Evidence) -> Result<(), NoZeroDynamics> {
        let c = self.restrict(pool, constraint);
        if self.fields.vanishes(pool, c, evidence)? {
            return Ok(());
        }
        let factors = vanishing_factors(pool, c, &self.free, &self.fields.bindings)
            .ok_or_else(|| NoZeroDynamics::Unsolved { constraint: Function::new(pool, c) })?;
        let factor = match factors.as_slice() {
            [] => return Err(NoZeroDynamics::Empty { derivative: Function::new(pool, c) }),
            [one] => *one,
            several => {
                let mut here = Vec::new();
                for &f in several {
                    if self.vanishes_at_point(pool, f, evidence) == Some(true) {
                        here.push(f);
                    }
                }
                match here.as_slice() {
                    [one] => *one,
                    _ => return Err(NoZeroDynamics::Branches { constraint: Function::new(pool, c) }),
                }
            }
        };
        let (s, value) = self
            .solve(pool, factor, evidence)
            .ok_or_else(|| NoZeroDynamics::Unsolved { constraint: Function::new(pool, factor) })?;
        let x = pool.sym(s);
        let map: FxHashMap<Expr, Expr> = std::iter::once((x, value)).collect();
        for i in 0..self.solved.len() {
            let old = pool.substitute(self.solved[i].1, &map);
            self.solved[i].1 = tidy(pool, old);
        }
        self.solved.push((s, value));
        self.free.retain(|&t| t != s);
        Ok(())
    }

    /// Value of `e` at the point; coordinates of the set only.
    pub(crate) fn vanishes_at_point(&self, pool: &mut Pool, e: Expr, evidence: &mut Evidence) -> Option<bool> {
        let (bindings, map) = self.at_point(pool);
        let e = pool.substitute(e, &map);
        match pool.zero_test(e, &bindings) {
            ZeroTest::Zero(certificate) => {
                evidence.add(&certificate);
                Some(true)
            }
            ZeroTest::NonZero => Some(false),
            ZeroTest::Unknown(_) => None,
        }
    }

    pub(crate) fn at_point(&self, pool: &mut Pool) -> (Bindings, FxHashMap<Expr, Expr>) {
        let mut bindings = self.fields.bindings.clone();
        let mut map = FxHashMap::default();
        for &s in &self.fields.states {
            let Some(&v) = self.point.get(&s) else { continue };
            if let Some(number) = pool.number(v).cloned() {
                bindings.bind(s, number);
            } else {
                map.insert(pool.sym(s), v);
            }
        }
        (bindings, map)
    }

    /// A coordinate and its value where `factor` vanishes.
    fn solve(&mut self, pool: &mut Pool, factor: Expr, evidence: &mut Evidence) -> Option<(Symbol, Expr)> {
        let mut candidates: Vec<(usize, Symbol, Expr)> = Vec::new();
        for &s in self.free.iter().rev() {
            if !pool.depends_on(factor, s) {
                continue;
            }
            let slope = pool.diff(factor, s);
            let slope = tidy(pool, slope);
            if pool.depends_on(slope, s) {
                continue;
            }
            let zeros = vanishing_factors(pool, slope, &self.free, &self.fields.bindings);
            // Constant slopes first, then those that vanish nowhere, then those that do not at the point.
            let moves = self.free.iter().any(|&t| pool.depends_on(slope, t));
            let rank = match zeros {
                _ if !moves => 0,
                Some(list) if list.is_empty() => 1,
                _ if self.vanishes_at_point(pool, slope, evidence) == Some(false) => 2,
                _ => 3,
            };
            candidates.push((rank, s, slope));
        }
        candidates.sort_by_key(|c| c.0);
        if let Some(&(rank, s, slope)) = candidates.first() {
            if rank >= 2 {
                let zeros = self.zeros(pool, slope);
                self.nonzero.extend(zeros);
            }
            let zero = pool.int(0);
            let x = pool.sym(s);
            let rest = pool.substitute(factor, &std::iter::once((x, zero)).collect());
            let value = pool.div(rest, slope);
            let value = pool.neg(value);
            return Some((s, tidy(pool, value)));
        }
        // A function of one coordinate that vanishes at the point is held there.
        let mut inside = self.free.iter().copied().filter(|&s| pool.depends_on(factor, s));
        if let (Some(s), None) = (inside.next(), inside.next())
            && let Some(&value) = self.point.get(&s)
            && self.vanishes_at_point(pool, factor, evidence) == Some(true)
        {
            return Some((s, value));
        }
        None
    }

    /// The inputs for which the motion is tangent to the set, and what else must vanish for that.
    fn hold(
        &mut self,
        pool: &mut Pool,
        inputs: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<(Held, Vec<Expr>), NoZeroDynamics> {
        self.pivots.clear();
        // x_s' − Σ ∂ψ/∂z z' = a + Σ b_j u_j = 0 for every x_s = ψ(z).
        let (mut drift, mut slopes) = (Vec::new(), Vec::new());
        for (s, value) in self.solved.clone() {
            let mut row = Vec::with_capacity(inputs.len() + 1);
            for field in std::iter::once(&self.fields.drift).chain(&self.fields.controls) {
                let along = pool.lie_derivative(value, &self.fields.states, field);
                let own = self.fields.states.iter().position(|&t| t == s).map_or(along, |i| field[i]);
                let difference = pool.sub(own, along);
                row.push(self.restrict(pool, difference));
            }
            slopes.push(row.split_off(1));
            drift.push(row[0]);
        }
        let independent = if slopes.is_empty() || inputs.is_empty() {
            Vec::new()
        } else {
            let rank = pool.rank(&slopes, &self.fields.bindings)?;
            evidence.add(&rank.certificate);
            rank.independent
        };
        let a: Vec<Vec<Expr>> = independent.iter().map(|&i| slopes[i].clone()).collect();
        let held = if independent.len() == inputs.len() {
            let b: Vec<Expr> = independent.iter().map(|&i| pool.neg(drift[i])).collect();
            let values = determinant(pool, &a).and_then(|d| {
                self.pivots = self.zeros(pool, d);
                solve(pool, &a, &b)
            });
            values.ok_or(Undecided::TooLarge { nodes: pool.len() })?.into_iter().enumerate().collect()
        } else {
            self.eliminate(pool, inputs, &independent, &drift, &slopes, evidence)?
        };
        let map: FxHashMap<Expr, Expr> = held.iter().map(|&(j, v)| (inputs[j], v)).collect();
        let mut constraints = Vec::new();
        for i in (0..drift.len()).filter(|i| !independent.contains(i)) {
            // The inputs that stay free drop out of the other rows.
            let rest = affine(pool, drift[i], &slopes[i], inputs);
            let rest = pool.substitute(rest, &map);
            let zero = pool.int(0);
            let none: FxHashMap<Expr, Expr> = inputs.iter().map(|&u| (u, zero)).collect();
            let rest = pool.substitute(rest, &none);
            let rest = tidy(pool, rest);
            if !self.fields.vanishes(pool, rest, evidence)? {
                // Where a pivot vanishes the inputs are not what they were solved for.
                let constraint = self.pivots.iter().fold(rest, |product, &b| pool.mul(product, b));
                constraints.push(constraint);
            }
        }
        Ok((held, constraints))
    }

    /// Solves the independent rows for as many inputs, one after the other.
    fn eliminate(
        &mut self,
        pool: &mut Pool,
        inputs: &[Expr],
        rows: &[usize],
        drift: &[Expr],
        slopes: &[Vec<Expr>],
        evidence: &mut Evidence,
    ) -> Result<Held, NoZeroDynamics> {
        let zero = pool.int(0);
        let mut held: Held = Vec::new();
        for &i in rows {
            let total = affine(pool, drift[i], &slopes[i], inputs);
            let map: FxHashMap<Expr, Expr> = held.iter().map(|&(j, v)| (inputs[j], v)).collect();
            let total = pool.substitute(total, &map);
            // The pivot: one that does not vanish at the point, and of those the shortest.
            let mut pivot: Option<(bool, u64, usize, Expr)> = None;
            for (j, &u) in inputs.iter().enumerate() {
                let Node::Sym(symbol) = pool.node(u) else { continue };
                let b = pool.diff(total, symbol);
                let b = tidy(pool, b);
                if held.iter().any(|h| h.0 == j) || self.fields.vanishes(pool, b, evidence)? {
                    continue;
                }
                let here = self.vanishes_at_point(pool, b, evidence) != Some(false);
                let length = pool.text_size(b).length;
                if pivot.is_none_or(|p| (here, length) < (p.0, p.1)) {
                    pivot = Some((here, length, j, b));
                }
            }
            let Some((_, _, j, b)) = pivot else { continue };
            for factor in self.zeros(pool, b) {
                if !self.pivots.contains(&factor) {
                    self.pivots.push(factor);
                }
            }
            let rest = pool.substitute(total, &std::iter::once((inputs[j], zero)).collect());
            let value = pool.div(rest, b);
            let value = pool.neg(value);
            let value = tidy(pool, value);
            let map: FxHashMap<Expr, Expr> = std::iter::once((inputs[j], value)).collect();
            for h in &mut held {
                let old = pool.substitute(h.1, &map);
                h.1 = tidy(pool, old);
            }
            held.push((j, value));
        }
        Ok(held)
    }

    /// The factors of `e` that vanish somewhere on the set.
    fn zeros(&self, pool: &mut Pool, e: Expr) -> Vec<Expr> {
        vanishing_factors(pool, e, &self.free, &self.fields.bindings).unwrap_or_else(|| vec![e])
    }

    fn motion(
        self,
        pool: &mut Pool,
        inputs: &[Expr],
        held: &Held,
        evidence: &mut Evidence,
    ) -> Result<ZeroDynamics, NoZeroDynamics> {
        let map: FxHashMap<Expr, Expr> = held.iter().map(|&(j, v)| (inputs[j], v)).collect();
        let mut equations = Vec::new();
        for s in &self.free {
            let Some(i) = self.fields.states.iter().position(|t| t == s) else { continue };
            let mut e = self.fields.drift[i];
            for (g, &u) in self.fields.controls.iter().zip(inputs) {
                let term = pool.mul(g[i], u);
                e = pool.add(e, term);
            }
            let e = self.restrict(pool, e);
            let e = pool.substitute(e, &map);
            // A division by zero has no value.
            self.fields.vanishes(pool, e, evidence)?;
            equations.push(tidy(pool, e));
        }
        let mut nonzero: Vec<Expr> = Vec::new();
        for b in self.nonzero.iter().chain(&self.pivots) {
            let b = self.restrict(pool, *b);
            for factor in vanishing_factors(pool, b, &self.free, &self.fields.bindings).unwrap_or_default() {
                if !nonzero.contains(&factor) {
                    nonzero.push(factor);
                }
            }
        }
        let inputs = (0..inputs.len()).map(|j| held.iter().find(|h| h.0 == j).map(|h| h.1)).collect();
        Ok(ZeroDynamics { states: self.free, equations, solved: self.solved, inputs, nonzero })
    }
}
