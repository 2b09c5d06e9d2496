//! Accessibility at a given point, where pruning by functional dependence is not allowed.

use std::cell::RefCell;
use std::cmp::Ordering;

use bracketry_symbolic::{Bindings, Evaluation, Expr, Pool, Rational, Real, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::closure::Closure;
use crate::algebra::constant_span::Words;
use crate::algebra::field::{Field, VectorFields, bracket, is_plain_zero, subtract};
use crate::answer::Answer;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::linear::taylor::reals;
use crate::options::Limits;
use crate::reason::{BracketLimit, Reason};
use crate::residues::{Echelon, Fp, OFFSET};
use crate::undecided::Undecided;

/// Dimensions at a point.
#[derive(Clone, Debug)]
pub struct LocalAccessibility {
    /// Entry k: dimension at the point of the span of all brackets of length ≤ k + 1 of {f, g_1 … g_m}.
    /// Unlike generically it can stand still and grow again; what follows the last growth is cut
    /// after one repetition.
    pub growth: Vec<usize>,
    /// Dimension of the accessibility algebra at the point.
    pub dimension: Answer<usize>,
    /// As `growth`, for brackets that contain at least one g.
    pub strong_growth: Vec<usize>,
    /// Dimension of the strong accessibility algebra at the point.
    pub strong_dimension: Answer<usize>,
}

/// A system around a point: the drift includes the constant inputs there.
pub(crate) struct Frame {
    pub(crate) fields: VectorFields,
    /// Parameters and those coordinates of the point that are rational.
    values: Bindings,
    /// Coordinates of the point that are other constants, such as π/2.
    replaced: FxHashMap<Expr, Expr>,
    /// The point, as expressions, and modulo the prime.
    point: Vec<Expr>,
    evaluation: RefCell<Option<Evaluation<OFFSET>>>,
    /// f and the g_i without the inputs at the point: the generators that words are made of.
    generators: Vec<Field>,
}

impl Frame {
    pub(crate) fn new(
        pool: &mut Pool,
        system: &VectorFields,
        states: &[Expr],
        inputs: &[Expr],
    ) -> Result<Frame, Error> {
        if states.len() != system.states.len() {
            return Err(Error::Dimension { expected: system.states.len(), found: states.len() });
        }
        if inputs.len() != system.controls.len() {
            return Err(Error::Inputs { expected: system.controls.len(), found: inputs.len() });
        }
        let mut fields = system.clone();
        for (g, &u) in system.controls.iter().zip(inputs) {
            for (f, &gi) in fields.drift.iter_mut().zip(g) {
                let p = pool.mul(u, gi);
                *f = pool.add(*f, p);
            }
        }
        let mut values = system.bindings.clone();
        let mut replaced = FxHashMap::default();
        for (&s, &v) in system.states.iter().zip(states) {
            if let Some(number) = pool.number(v) {
                values.bind(s, number.clone());
            } else {
                let x = pool.sym(s);
                replaced.insert(x, v);
            }
        }
        let (point, evaluation) = (states.to_vec(), RefCell::new(None));
        Ok(Frame { fields, values, replaced, point, evaluation, generators: system.generators() })
    }

    /// Values of the fields at the point, modulo the prime. Those of all calls belong together: transcendental constants and
    /// parameters without values are the same residues in all of them.
    pub(crate) fn evaluate(
        &self,
        pool: &mut Pool,
        fields: &[Field],
        evidence: &mut Evidence,
    ) -> Result<Vec<Vec<Fp>>, Undecided> {
        let n = self.fields.states.len();
        let at_point = |pool: &mut Pool, entries: Vec<Expr>| {
            if self.replaced.is_empty() { entries } else { pool.substitute_all(&entries, &self.replaced) }
        };
        let mut evaluation = self.evaluation.borrow_mut();
        let evaluation = evaluation.get_or_insert_with(|| {
            // All constants of the system together: e^(1/3) and e^(1/2) are powers of one generator. Where they have no
            // values together, each is met where it is needed.
            let mut new = Evaluation::new(self.values.clone());
            let all = at_point(pool, [self.fields.controls.concat(), self.fields.drift.clone()].concat());
            let _ = pool.evaluate(&mut new, &all);
            new
        });
        let roots = at_point(pool, fields.concat());
        let samples = pool.evaluate(evaluation, &roots)?;
        evidence.add_rank(&samples, n)?;
        Ok(samples.values[0].chunks(n).map(<[Fp]>::to_vec).collect())
    }

    /// A symbol for the deviation of each state from the point, and what replaces each state by point and deviation.
    pub(crate) fn deviations(&self, pool: &mut Pool) -> (Vec<Symbol>, FxHashMap<Expr, Expr>) {
        let mut symbols = Vec::new();
        let mut moved: FxHashMap<Expr, Expr> = FxHashMap::default();
        for (&s, &v) in self.fields.states.iter().zip(&self.point) {
            let deviation = pool.symbol(&format!("offset of {}", pool.name(s)));
            symbols.push(deviation);
            let deviation = pool.sym(deviation);
            let sum = pool.add(v, deviation);
            moved.insert(pool.sym(s), sum);
        }
        (symbols, moved)
    }

    pub(crate) fn rank(&self, pool: &mut Pool, fields: &[Field], evidence: &mut Evidence) -> Result<usize, Undecided> {
        Ok(Echelon::new(&self.evaluate(pool, fields, evidence)?, self.fields.states.len()).rank())
    }

    /// Values of everything in `roots` that has one: coordinates of the point and parameters.
    pub(crate) fn constants(&self, pool: &mut Pool, roots: &[Expr]) -> FxHashMap<Expr, Expr> {
        let mut at = self.replaced.clone();
        for s in pool.symbols_of(roots) {
            if let Some(v) = self.values.get(s).cloned() {
                let x = pool.sym(s);
                let v = pool.rational(v);
                at.insert(x, v);
            }
        }
        at
    }

    /// `e` with parameters and coordinates of the point replaced by their values.
    pub(crate) fn constants_in(&self, pool: &mut Pool, e: Expr) -> Expr {
        // Twice, because coordinates of the point may be expressions of parameters.
        (0..2).fold(e, |e, _| {
            let at = self.constants(pool, &[e]);
            pool.substitute(e, &at)
        })
    }

    /// The sign of `e` at the point; `None` where it has no value there or is not told from zero.
    pub(crate) fn sign(&self, pool: &mut Pool, e: Expr) -> Option<Ordering> {
        let e = self.constants_in(pool, e);
        pool.constant_sign(e, &Bindings::new())
    }

    /// Numerical values at the point, right to the last digit, whatever cancels; `None` if a symbol has no value or a value is not finite.
    pub(crate) fn numbers(&self, pool: &mut Pool, roots: &[Expr]) -> Option<Vec<f64>> {
        let mut roots = roots.to_vec();
        for _ in 0..2 {
            let at = self.constants(pool, &roots);
            roots = pool.substitute_all(&roots, &at);
        }
        roots.into_iter().map(|e| pool.constant_value(e, &Bindings::new())).collect()
    }

    /// Values at the point; `None` if one is not seen to be a rational number.
    pub(crate) fn rationals(&self, pool: &mut Pool, roots: &[Expr]) -> Option<Vec<Rational>> {
        roots
            .iter()
            .map(|&e| {
                let value = self.constants_in(pool, e);
                pool.constant_rational(value)
            })
            .collect()
    }

    /// Exact values at the point that belong together; `None` if one is not known.
    pub(crate) fn reals(&self, pool: &mut Pool, roots: &[Expr], evidence: &mut Evidence) -> Option<Vec<Real>> {
        let values: Vec<Expr> = roots.iter().map(|&e| self.constants_in(pool, e)).collect();
        reals(pool, &values, evidence)
    }

    /// `e` at the point.
    pub(crate) fn value_at_point(&self, pool: &mut Pool, e: Expr) -> Expr {
        let at: FxHashMap<Expr, Expr> =
            self.fields.states.iter().zip(&self.point).map(|(&s, &v)| (pool.sym(s), v)).collect();
        pool.substitute(e, &at)
    }

    /// The point, one expression per state.
    pub(crate) fn point(&self) -> &[Expr] {
        &self.point
    }

    /// Whether f + Σ u_i g_i vanishes at the point.
    pub(crate) fn is_equilibrium(&self, pool: &mut Pool, evidence: &mut Evidence) -> Result<bool, Undecided> {
        let drift = [self.fields.drift.clone()];
        Ok(self.rank(pool, &drift, evidence)? == 0)
    }

    /// Whether the affine subspace through the point along the values of `directions` there
    /// (and of the drift, if `moving`) is invariant under all inputs, so that the dimension
    /// found at the point is final.
    ///
    /// Without `moving`: every generator is tangent to V = x0 + span Y(x0), hence so are all
    /// brackets. With it the same in the space with time added: V = {x0 + t f(x0) + span Y(x0)},
    /// generators (f, 1) and (g, 0); then the strong algebra at the point lies in span Y(x0).
    fn is_invariant(
        &self,
        pool: &mut Pool,
        directions: &[Field],
        moving: bool,
        evidence: &mut Evidence,
    ) -> Result<bool, Undecided> {
        let at: FxHashMap<Expr, Expr> =
            self.fields.states.iter().zip(&self.point).map(|(&s, &v)| (pool.sym(s), v)).collect();
        let fixed: Vec<Field> = directions.iter().map(|y| pool.substitute_all(y, &at)).collect();
        let drift = pool.substitute_all(&self.fields.drift, &at);
        let mut along: Vec<(Symbol, Field)> = Vec::new();
        for (i, y) in fixed.iter().enumerate() {
            along.push((pool.symbol(&format!("along {i}")), y.clone()));
        }
        if moving {
            along.push((pool.symbol("along t"), drift.clone()));
        }
        let mut to: FxHashMap<Expr, Expr> = FxHashMap::default();
        for (i, &s) in self.fields.states.iter().enumerate() {
            let mut x = self.point[i];
            for (c, y) in &along {
                let c = pool.sym(*c);
                let step = pool.mul(c, y[i]);
                x = pool.add(x, step);
            }
            let s = pool.sym(s);
            to.insert(s, x);
        }
        let mut rows = fixed;
        let expected = rows.len();
        let mut generators = self.fields.controls.clone();
        generators.push(self.fields.drift.clone());
        for (i, g) in generators.iter().enumerate() {
            let mut on_v = pool.substitute_all(g, &to);
            if moving && i + 1 == generators.len() {
                on_v = subtract(pool, &on_v, &drift);
            }
            rows.push(on_v);
        }
        let rank = pool.rank(&rows, &self.fields.bindings)?;
        evidence.add(&rank.certificate);
        Ok(rank.rank == expected)
    }
}

/// Ends a list after one repetition of its last dimension, or at once where that is full.
fn end_after_last_growth(growth: &mut Vec<usize>, full: usize, proven: bool) {
    let last = growth.last().copied().unwrap_or(0);
    let reached = growth.iter().position(|&d| d == last).unwrap_or(0);
    growth.truncate(if last == full { reached + 1 } else { reached + 2 });
    if proven && last < full && growth.len() == reached + 1 {
        growth.push(last);
    }
}

impl VectorFields {
    /// Dimensions of the accessibility algebra and of its strong part at the point `states`
    /// with constant `inputs` there (expressions without symbols other than parameters).
    ///
    /// All right-normed brackets are formed, less those that are constant combinations of
    /// others. An answer is given when it is proven: the dimension is full or the generic
    /// one, the algebra is finite-dimensional and complete, or an affine subspace of that
    /// dimension through the point is invariant. Otherwise it is unknown.
    ///
    /// # Errors
    /// [`Error::Dimension`], [`Error::Inputs`] for a point of the wrong size,
    /// [`Error::Undecided`] if the fields cannot be evaluated exactly at the point.
    pub fn at_point(
        &self,
        pool: &mut Pool,
        states: &[Expr],
        inputs: &[Expr],
        limits: &Limits,
        evidence: &mut Evidence,
    ) -> Result<LocalAccessibility, Error> {
        let frame = Frame::new(pool, self, states, inputs)?;
        let generic = self.accessibility(pool, evidence)?;
        let generic_strong = self.strong_accessibility(pool, evidence)?;
        Ok(frame.accessibility(pool, &generic, &generic_strong, limits, evidence)?)
    }
}

impl Frame {
    pub(crate) fn accessibility(
        &self,
        pool: &mut Pool,
        generic: &Closure,
        generic_strong: &Closure,
        limits: &Limits,
        evidence: &mut Evidence,
    ) -> Result<LocalAccessibility, Undecided> {
        let n = self.fields.states.len();
        // No level can exceed its generic dimension. Where the generic basis stays independent,
        // every level attains it, and no other bracket needs to be formed.
        if let Some(all) = self.attained(pool, generic, generic_strong, evidence)? {
            return Ok(LocalAccessibility {
                growth: all.growth.clone(),
                dimension: Answer::Known(all.dimension()),
                strong_growth: generic_strong.growth.clone(),
                strong_dimension: Answer::Known(generic_strong.dimension()),
            });
        }
        let (generic, generic_strong) = (generic.dimension(), generic_strong.dimension());
        let first_node = pool.len();
        let bindings = &self.fields.bindings;
        let mut words = Words::default();
        words.extend(pool, bindings, self.fields.controls.clone(), evidence)?;
        let mut generators = words.kept.clone();
        if !is_plain_zero(pool, &self.fields.drift) {
            generators.push(self.fields.drift.clone());
        }
        let (mut growth, mut strong_growth) = (Vec::new(), Vec::new());
        let (mut dimension, mut strong_dimension) = (None, None);
        let mut length = 1;
        let limit = loop {
            let mut values = self.evaluate(pool, &words.kept, evidence)?;
            let strong = Echelon::new(&values, n).rank();
            values.extend(self.evaluate(pool, std::slice::from_ref(&self.fields.drift), evidence)?);
            let all = Echelon::new(&values, n).rank();
            let stalled = growth.last() == Some(&all) && strong_growth.last() == Some(&strong);
            growth.push(all);
            strong_growth.push(strong);
            let closed = words.fresh.is_empty();
            if closed || all == generic {
                dimension = Some(all);
            }
            if closed || strong == generic_strong {
                strong_dimension = Some(strong);
            }
            if (dimension.is_none() || strong_dimension.is_none()) && stalled {
                let basis = self.basis_at_point(pool, &words.kept, evidence)?;
                if dimension.is_none() {
                    let mut directions = basis.clone();
                    if all > strong {
                        directions.push(self.fields.drift.clone());
                    }
                    dimension = self.is_invariant(pool, &directions, false, evidence)?.then_some(all);
                }
                if dimension == Some(strong) || self.is_invariant(pool, &basis, true, evidence)? {
                    strong_dimension = Some(strong);
                }
            }
            if dimension.is_some() && strong_dimension.is_some() {
                break BracketLimit::Length;
            }
            if length >= limits.length {
                break BracketLimit::Length;
            }
            if words.kept.len() > limits.brackets {
                break BracketLimit::Count;
            }
            let mut candidates = Vec::new();
            for (x, i) in generators.iter().flat_map(|x| words.fresh.clone().map(move |i| (x, i))) {
                if pool.len() - first_node > limits.nodes {
                    break;
                }
                candidates.push(bracket(pool, &self.fields.states, x, &words.kept[i]));
            }
            if pool.len() - first_node > limits.nodes {
                break BracketLimit::Size;
            }
            words.extend(pool, bindings, candidates, evidence)?;
            length += 1;
        };
        let answer = |found: Option<usize>, list: &[usize]| {
            let least = list.last().copied().unwrap_or(0);
            found.map_or(Answer::Unknown(Reason::Brackets { least, length, limit }), Answer::Known)
        };
        let dimension = answer(dimension, &growth);
        let strong_dimension = answer(strong_dimension, &strong_growth);
        end_after_last_growth(&mut growth, n, dimension.known().is_some());
        end_after_last_growth(&mut strong_growth, n, strong_dimension.known().is_some());
        Ok(LocalAccessibility { growth, dimension, strong_growth, strong_dimension })
    }

    /// The closure of whose brackets all are independent at the point, if the strong ones are:
    /// the strong one itself at an equilibrium, as every bracket but the drift contains a g.
    fn attained<'a>(
        &self,
        pool: &mut Pool,
        generic: &'a Closure,
        generic_strong: &'a Closure,
        evidence: &mut Evidence,
    ) -> Result<Option<&'a Closure>, Undecided> {
        if !self.is_attained(pool, generic_strong, evidence)? {
            return Ok(None);
        }
        if self.is_equilibrium(pool, evidence)? {
            return Ok(Some(generic_strong));
        }
        Ok(self.is_attained(pool, generic, evidence)?.then_some(generic))
    }

    /// Whether the brackets behind the generic dimension are independent at the point, as far as they can be formed.
    fn is_attained(&self, pool: &mut Pool, closure: &Closure, evidence: &mut Evidence) -> Result<bool, Undecided> {
        let (states, bindings) = (&self.fields.states, &self.fields.bindings);
        match closure.brackets(pool, states, &self.generators, bindings, evidence) {
            Ok(fields) => Ok(self.rank(pool, &fields, evidence)? == closure.dimension()),
            Err(Undecided::TooLarge { .. }) => Ok(false),
            Err(why) => Err(why),
        }
    }

    /// Fields whose values at the point are a basis of the span of all values there.
    fn basis_at_point(
        &self,
        pool: &mut Pool,
        fields: &[Field],
        evidence: &mut Evidence,
    ) -> Result<Vec<Field>, Undecided> {
        let values = self.evaluate(pool, fields, evidence)?;
        let mut echelon = Echelon::empty(self.fields.states.len());
        Ok(fields.iter().zip(values).filter_map(|(f, v)| echelon.insert(v).then(|| f.clone())).collect())
    }
}
