//! The values that a function of the inputs takes when these take all values of their intervals.

use std::fmt;

use bracketry_symbolic::{Expr, Func, Func2, Function, Node, Pool, Rational, Symbol, Tape};
use rustc_hash::FxHashSet;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use crate::images::{Domain, Images, flattened};
use crate::interval::{End, Interval};
use crate::rational_function::RationalFunction;
use crate::switching::is_switch;
use crate::trend::rises_through_all;
use crate::unknown_range::UnknownRange;

/// An end of a [`Range`].
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// As a number.
    pub value: f64,
    /// The exact value, where it is known.
    pub exact: Option<Function>,
    /// Whether the value itself is taken.
    pub closed: bool,
}

impl Bound {
    /// A closed bound.
    pub(crate) fn of_rational(value: Rational, mut pool: Pool) -> Self {
        let number = value.to_f64().value();
        let exact = pool.rational(value);
        Bound { value: number, exact: Some(Function::new(&pool, exact)), closed: true }
    }

    /// The value as a rational number, exact where it is rational.
    pub(crate) fn rational(&self) -> Option<Rational> {
        let exact = self.exact.as_ref().and_then(|e| e.pool().number(e.expr()).cloned());
        exact.or_else(|| Rational::try_from(self.value).ok())
    }

    /// Whether the other bound is the same number, or its negative; of bounds that are not exact, to six decimals.
    fn is(&self, other: &Bound, negative: bool) -> bool {
        match (&self.exact, &other.exact) {
            (Some(a), Some(b)) => {
                let mut pool = a.pool().clone();
                let b = b.copied_into(&mut pool);
                a.expr() == if negative { pool.neg(b) } else { b }
            }
            (None, None) => {
                let rounded = |value: f64| (1e6 * value).round();
                rounded(self.value) == if negative { -rounded(other.value) } else { rounded(other.value) }
            }
            _ => false,
        }
    }
}

/// The exact value, or one rounded to six decimals.
impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.exact {
            Some(exact) => f.write_str(&exact.text()),
            None => write!(f, "{:.6}", self.value),
        }
    }
}

/// With its text.
impl Serialize for Bound {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut s = serializer.serialize_struct("Bound", 4)?;
        s.serialize_field("value", &self.value)?;
        s.serialize_field("text", &self.to_string())?;
        s.serialize_field("exact", &self.exact.is_some())?;
        s.serialize_field("closed", &self.closed)?;
        s.end()
    }
}

/// The set of values of a function of the inputs on the intervals of the inputs, parameters at their values.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Range {
    /// All real numbers.
    Onto,
    /// All numbers between the bounds and no others; a missing bound is infinite.
    Interval {
        /// Lower end.
        lower: Option<Bound>,
        /// Upper end.
        upper: Option<Bound>,
    },
    /// Not established.
    Unknown {
        /// Why.
        reason: UnknownRange,
    },
}

impl Range {
    /// Whether every real number is a value; `None` where that was not established.
    pub fn is_onto(&self) -> Option<bool> {
        match self {
            Range::Onto => Some(true),
            Range::Interval { .. } => Some(false),
            Range::Unknown { .. } => None,
        }
    }

    /// The limits of a variable called `name`, such as `v1 ≥ 0`, `|v1| ≤ 1` or `-2 < v1 ≤ 3`; `None` where there are
    /// none or none were established.
    pub fn text(&self, name: &str) -> Option<String> {
        let sign = |closed: bool, strict: &'static str, weak: &'static str| if closed { weak } else { strict };
        let Range::Interval { lower, upper } = self else { return None };
        match (lower, upper) {
            (Some(a), Some(b)) if a.is(b, false) => Some(format!("{name} = {a}")),
            (Some(a), Some(b)) if a.value < 0.0 && a.closed == b.closed && a.is(b, true) => {
                Some(format!("|{name}| {} {b}", sign(a.closed, "<", "≤")))
            }
            (Some(a), Some(b)) => {
                Some(format!("{a} {} {name} {} {b}", sign(a.closed, "<", "≤"), sign(b.closed, "<", "≤")))
            }
            (Some(a), None) => Some(format!("{name} {} {a}", sign(a.closed, ">", "≥"))),
            (None, Some(b)) => Some(format!("{name} {} {b}", sign(b.closed, "<", "≤"))),
            (None, None) => None,
        }
    }

    fn of_interval(pool: &mut Pool, i: &Interval) -> Self {
        if i.is_all() {
            return Range::Onto;
        }
        let mut bound = |e: &End| {
            e.value.is_finite().then(|| {
                let exact = e.exact.map(|x| {
                    let x = pool.simplify(x);
                    Function::new(pool, x)
                });
                Bound { value: e.value, exact, closed: e.closed }
            })
        };
        Range::Interval { lower: bound(&i.lower), upper: bound(&i.upper) }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Range::Onto => write!(f, "all real numbers"),
            Range::Interval { .. } => f.write_str(&self.text("value").unwrap_or_default()),
            Range::Unknown { reason } => write!(f, "not established: {reason}"),
        }
    }
}

/// The range of `w` on the intervals of the inputs. Parameters must have been replaced by their values.
pub(crate) fn range(pool: &mut Pool, w: Expr, domain: &Domain) -> Range {
    match image(pool, w, domain) {
        Ok(i) => Range::of_interval(pool, &i),
        Err(reason) => Range::Unknown { reason },
    }
}

/// The same as an interval.
pub(crate) fn image(pool: &mut Pool, w: Expr, domain: &Domain) -> Result<Interval, UnknownRange> {
    Images::new(pool, domain.clone()).of(w)
}

impl Images<'_> {
    /// The exact set of values, if it is found and has no gaps.
    pub(crate) fn of(&mut self, e: Expr) -> Result<Interval, UnknownRange> {
        self.effort = self.effort.checked_sub(1).ok_or(UnknownRange::TooLarge)?;
        let inputs = self.inputs_of(e);
        if inputs.is_empty() {
            return self.constant(e);
        }
        let failed = |pool: &Pool, e: Expr| UnknownRange::NoInterval(Function::new(pool, e));
        match self.pool.node(e) {
            Node::Sym(u) => Ok(self.domain[&u].clone()),
            Node::Add(..) => self.sum(e),
            Node::Mul(..) => self.product(e),
            Node::Pow(a, k) if self.inputs_of(k).is_empty() => {
                if let Some(k) = self.pool.number(k).cloned() {
                    if k.is_int() && k < Rational::ZERO && inputs.len() == 1 {
                        // Sums in a denominator may have a numerator of the same inputs only elsewhere.
                        return match self.of(a).and_then(|i| i.power(self.pool, &k).ok_or(UnknownRange::Empty)) {
                            Ok(i) => Ok(i),
                            Err(_) => self.shared(e),
                        };
                    }
                    let base = self.of(a)?;
                    return base.power(self.pool, &k).ok_or_else(|| failed(self.pool, e));
                }
                Err(failed(self.pool, e))
            }
            Node::Pow(a, _) if !self.inputs_of(a).is_empty() => self.shared(e),
            Node::Pow(a, k) => {
                let log = self.pool.call(Func::Log, a);
                let exponent = self.pool.mul(k, log);
                let base = self.constant(a)?;
                if base.lower.value <= 0.0 {
                    return Err(failed(self.pool, e));
                }
                let i = self.of(exponent)?;
                i.image(self.pool, Func::Exp).ok_or_else(|| failed(self.pool, e))
            }
            Node::Call(f, a) => {
                let i = self.of(a)?;
                i.image(self.pool, f).ok_or_else(|| failed(self.pool, e))
            }
            Node::Call2(Func2::Min | Func2::Max, ..) => self.shared(e),
            Node::Num(_) | Node::Pi | Node::Call2(Func2::Atan2, ..) => Err(failed(self.pool, e)),
        }
    }

    /// Groups of operands that share inputs; those without inputs are a group of their own each.
    fn groups(&self, operands: &[Expr]) -> Vec<Vec<Expr>> {
        let mut groups: Vec<(FxHashSet<Symbol>, Vec<Expr>)> = Vec::new();
        for &e in operands {
            let mut uses: FxHashSet<Symbol> = self.inputs_of(e).into_iter().collect();
            let mut members = vec![e];
            groups.retain_mut(|g| {
                let joined = !g.0.is_disjoint(&uses);
                if joined {
                    uses.extend(g.0.iter());
                    members.append(&mut g.1);
                }
                !joined
            });
            groups.push((uses, members));
        }
        groups.into_iter().map(|g| g.1).collect()
    }

    fn sum(&mut self, e: Expr) -> Result<Interval, UnknownRange> {
        let terms = flattened(self.pool, e, true);
        let mut total: Option<Interval> = None;
        let mut missing = None;
        for group in self.groups(&terms) {
            let image = if let [only] = group[..] {
                self.of(only)
            } else {
                let part = self.pool.sum(group);
                self.shared(part)
            };
            match image {
                // Whatever finite value the other terms have.
                Ok(i) if i.is_all() => return Ok(i),
                Ok(i) => {
                    total = Some(match total {
                        Some(t) => t.sum(self.pool, &i),
                        None => i,
                    });
                }
                Err(why) => missing = Some(why),
            }
        }
        match (missing, total) {
            (None, Some(t)) => Ok(t),
            (why, _) => Err(why.unwrap_or(UnknownRange::Empty)),
        }
    }

    fn product(&mut self, e: Expr) -> Result<Interval, UnknownRange> {
        let factors = flattened(self.pool, e, false);
        let mut total: Option<Interval> = None;
        for group in self.groups(&factors) {
            let image = if let [only] = group[..] {
                self.of(only)?
            } else {
                let mut part = self.pool.int(1);
                for f in group {
                    part = self.pool.mul(part, f);
                }
                self.shared(part)?
            };
            total = Some(match total {
                Some(t) => t.product(self.pool, &image).ok_or(UnknownRange::Product)?,
                None => image,
            });
        }
        total.ok_or(UnknownRange::Empty)
    }

    /// An expression whose operands share inputs.
    fn shared(&mut self, e: Expr) -> Result<Interval, UnknownRange> {
        let inputs = self.inputs_of(e);
        if let [u] = inputs[..] {
            if let Some(switch) = innermost_switch(self.pool, e, u) {
                return self.piecewise(e, u, switch).or_else(|why| self.on_box(e).ok_or(why));
            }
            if let Some(f) = RationalFunction::of(self.pool, e, u)
                && let Some(on) = f.domain(self)
                && let Some(i) = f.image(self.pool, &on)
            {
                return Ok(i);
            }
            if self.domain[&u].is_all() && rises_through_all(self, e, u) {
                return Ok(Interval::all());
            }
        }
        for u in inputs {
            if self.domain[&u].is_all() && self.odd_polynomial(e, u) {
                return Ok(Interval::all());
            }
        }
        if let [u, w] = self.inputs_of(e)[..]
            && let Some(i) = self.of_separable(e, [u, w])
        {
            return Ok(i);
        }
        self.on_box(e).ok_or_else(|| UnknownRange::Shared(Function::new(self.pool, e)))
    }

    /// Whether `e` is, for some values of the other inputs and every state, a polynomial of odd degree in `u`.
    fn odd_polynomial(&mut self, e: Expr, u: Symbol) -> bool {
        let e = self.pool.expand(e);
        let mut leading: (i64, Vec<Expr>) = (0, Vec::new());
        for term in flattened(self.pool, e, true) {
            let mut degree = 0;
            let mut coefficient = self.pool.int(1);
            for factor in flattened(self.pool, term, false) {
                let power = match self.pool.node(factor) {
                    Node::Sym(s) if s == u => Some(1),
                    Node::Pow(a, k) if self.pool.sym(u) == a => self.pool.integer(k).filter(|k| *k > 0),
                    _ if !self.pool.depends_on(factor, u) => {
                        coefficient = self.pool.mul(coefficient, factor);
                        Some(0)
                    }
                    _ => None,
                };
                match power {
                    Some(k) => degree += k,
                    None => return false,
                }
            }
            if degree > leading.0 {
                leading = (degree, Vec::new());
            }
            if degree == leading.0 {
                leading.1.push(coefficient);
            }
        }
        let coefficient = self.pool.sum(leading.1);
        let uses = self.pool.symbols_of(&[coefficient]);
        let of_inputs = uses.iter().all(|s| self.domain.get(s).is_some_and(Interval::is_all));
        leading.0 % 2 == 1
            && of_inputs
            && self.pool.zero_test(coefficient, &bracketry_symbolic::Bindings::default()).is_nonzero()
    }

    /// A function with `sign`, `abs`, `min` or `max`: the union of its values where their arguments keep their signs.
    fn piecewise(&mut self, e: Expr, u: Symbol, switch: Expr) -> Result<Interval, UnknownRange> {
        let unknown = |pool: &Pool| UnknownRange::Switch(Function::new(pool, switch));
        let (surface, above, below) = match self.pool.node(switch) {
            Node::Call(Func::Abs, a) => (a, a, self.pool.neg(a)),
            Node::Call(_, a) => (a, self.pool.int(1), self.pool.int(-1)),
            Node::Call2(f, a, b) => {
                let gap = self.pool.sub(a, b);
                if f == Func2::Max { (gap, a, b) } else { (gap, b, a) }
            }
            _ => return Err(unknown(self.pool)),
        };
        let f = RationalFunction::of(self.pool, surface, u).filter(RationalFunction::is_polynomial_of_input);
        let roots = f.ok_or_else(|| unknown(self.pool))?.zeros();
        let on = self.domain[&u].clone();
        let mut parts = Vec::new();
        let mut lower = on.lower.clone();
        let mut ends: Vec<End> = Vec::new();
        for r in roots.iter().filter(|r| on.holds_inside(r.value)) {
            let exact = r.exact.as_ref().ok_or_else(|| unknown(self.pool))?;
            ends.push(End::rational(self.pool, exact, false));
        }
        ends.push(on.upper.clone());
        let x = self.pool.sym(u);
        for end in ends {
            let inside = match (lower.value.is_finite(), end.value.is_finite()) {
                (true, true) => f64::midpoint(lower.value, end.value),
                (true, false) => lower.value + 1.0,
                (false, true) => end.value - 1.0,
                (false, false) => 0.0,
            };
            let Ok(tape) = Tape::compile(self.pool, &[u], &[surface]) else { return Err(unknown(self.pool)) };
            let mut sign = [0.0];
            tape.eval(&[inside], &mut Vec::new(), &mut sign);
            let value = if sign[0] > 0.0 { above } else { below };
            let piece = self.pool.substitute(e, &std::iter::once((switch, value)).collect());
            let on_piece = Interval { lower: lower.clone(), upper: end.clone() };
            let image = {
                let old = self.domain.insert(u, on_piece);
                let image = if self.inputs_of(piece).is_empty() { self.constant(piece) } else { self.of(piece) };
                if let Some(old) = old {
                    self.domain.insert(u, old);
                }
                image?
            };
            parts.push(image);
            if let Some(at) = end.exact.filter(|_| end.value < on.upper.value) {
                let here = self.pool.substitute(e, &std::iter::once((x, at)).collect());
                parts.push(self.constant(here)?);
            }
            lower = End { closed: false, ..end };
        }
        Interval::union(parts).ok_or_else(|| UnknownRange::Gap(Function::new(self.pool, e)))
    }
}

/// A `sign`, `abs`, `min` or `max` of `u` whose argument holds no other.
fn innermost_switch(pool: &Pool, e: Expr, u: Symbol) -> Option<Expr> {
    pool.reachable(&[e]).into_iter().find(|n| is_switch(pool.node(*n)) && pool.depends_on(*n, u))
}
