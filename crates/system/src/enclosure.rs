//! Enclosures of expressions on boxes: floating-point intervals, rounded outward (Moore 1966).

use std::f64::consts::{FRAC_PI_2, PI};

use bracketry_symbolic::{Expr, Func, Func2, Node, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

/// All numbers from `lower` to `upper`; the ends may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Enclosure {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
}

/// Relative error that library functions are trusted to keep, in units of the rounding error.
const ULPS: f64 = 8.0;

fn below(x: f64) -> f64 {
    x - (x.abs() * ULPS * f64::EPSILON + f64::MIN_POSITIVE)
}

fn above(x: f64) -> f64 {
    -below(-x)
}

impl Enclosure {
    pub(crate) const ALL: Self = Enclosure { lower: f64::NEG_INFINITY, upper: f64::INFINITY };

    pub(crate) fn point(x: f64) -> Self {
        Enclosure { lower: x, upper: x }
    }

    /// The hull of computed numbers, rounded outward; everything where one is not a number.
    fn rounded(values: &[f64]) -> Self {
        if values.iter().any(|v| v.is_nan()) {
            return Self::ALL;
        }
        let lower = values.iter().copied().fold(f64::INFINITY, f64::min);
        let upper = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let down = if lower.is_finite() { below(lower) } else { lower };
        Enclosure { lower: down, upper: if upper.is_finite() { above(upper) } else { upper } }
    }

    pub(crate) fn width(self) -> f64 {
        self.upper - self.lower
    }

    pub(crate) fn middle(self) -> f64 {
        f64::midpoint(self.lower, self.upper)
    }

    fn within(self, lower: f64, upper: f64) -> Self {
        Enclosure { lower: self.lower.clamp(lower, upper), upper: self.upper.clamp(lower, upper) }
    }

    pub(crate) fn sum(self, other: Self) -> Self {
        Self::rounded(&[self.lower + other.lower, self.upper + other.upper])
    }

    pub(crate) fn product(self, other: Self) -> Self {
        // An end 0 times an infinite end bounds products of finite numbers with 0.
        let times = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        let (a, b) = ([self.lower, self.upper], [other.lower, other.upper]);
        if a == [0.0; 2] || b == [0.0; 2] {
            return Self::point(0.0);
        }
        Self::rounded(&[times(a[0], b[0]), times(a[0], b[1]), times(a[1], b[0]), times(a[1], b[1])])
    }

    fn holds_zero(self) -> bool {
        self.lower <= 0.0 && self.upper >= 0.0
    }

    /// t^k; of negative t with a broken exponent, only what is defined.
    fn power(self, k: &Rational) -> Self {
        let exponent = k.to_f64().value();
        let integer = k.is_int();
        let even = integer && (k.clone() / Rational::from(2)).is_int();
        let on = if integer { self } else { self.within(0.0, f64::INFINITY) };
        if exponent < 0.0 && on.holds_zero() {
            let limit = |x: f64| if x == 0.0 { f64::INFINITY } else { x.powf(exponent) };
            return if on.lower == 0.0 { Self::rounded(&[limit(on.lower), limit(on.upper)]) } else { Self::ALL };
        }
        let mut values = vec![on.lower.powf(exponent), on.upper.powf(exponent)];
        if even && on.holds_zero() {
            values.push(0.0);
        }
        let all = Self::rounded(&values);
        if even || !integer { all.within(0.0, f64::INFINITY) } else { all }
    }

    /// Sine or cosine, whose value is 1 at `crest`.
    fn wave(self, f: Func, crest: f64) -> Self {
        /// Turns by which a crest may be misplaced; a value so near to it differs from 1 by less than rounding.
        const SLACK: f64 = 1e-9;
        if self.width().is_nan() || self.width() >= 2.0 * PI {
            return Enclosure { lower: -1.0, upper: 1.0 };
        }
        let mut values = vec![f.eval(self.lower), f.eval(self.upper)];
        for (value, at) in [(1.0, crest), (-1.0, crest + PI)] {
            let turns = |x: f64| (x - at) / (2.0 * PI);
            if (turns(self.lower) - SLACK).ceil() <= turns(self.upper) + SLACK {
                values.push(value);
            }
        }
        Self::rounded(&values).within(-1.0, 1.0)
    }

    fn image(self, f: Func) -> Self {
        let monotone = |on: Enclosure| Self::rounded(&[f.eval(on.lower), f.eval(on.upper)]);
        match f {
            Func::Exp => monotone(self).within(0.0, f64::INFINITY),
            Func::Tanh => monotone(self).within(-1.0, 1.0),
            Func::Sinh | Func::Atan => monotone(self),
            Func::Log => monotone(self.within(0.0, f64::INFINITY)),
            Func::Asin | Func::Acos => monotone(self.within(-1.0, 1.0)),
            Func::Cosh | Func::Abs => {
                let mut values = vec![f.eval(self.lower), f.eval(self.upper)];
                if self.holds_zero() {
                    values.push(f.eval(0.0));
                }
                Self::rounded(&values).within(f.eval(0.0), f64::INFINITY)
            }
            Func::Sin => self.wave(f, FRAC_PI_2),
            Func::Cos => self.wave(f, 0.0),
            Func::Tan => {
                let branch = |x: f64| (x / PI + 0.5).floor();
                let near = |x: f64| (x / PI + 0.5 - (x / PI + 0.5).round()).abs() < 1e-9;
                let regular = branch(self.lower) == branch(self.upper) && !near(self.lower) && !near(self.upper);
                if self.width() < PI && regular { monotone(self) } else { Self::ALL }
            }
            // The set-valued sign: with it, the derivatives of |x|, min and max are their generalized gradients.
            Func::Sign if self.lower > 0.0 => Self::point(1.0),
            Func::Sign if self.upper < 0.0 => Self::point(-1.0),
            Func::Sign => Enclosure { lower: -1.0, upper: 1.0 },
        }
    }
}

/// One step of the evaluation.
#[derive(Clone, Debug)]
enum Step {
    Value(Enclosure),
    Variable(usize),
    Sum(usize, usize),
    Product(usize, usize),
    Power(usize, Rational),
    /// exp(k log a)
    Exponential(usize, usize),
    Image(Func, usize),
    Least(usize, usize),
    Greatest(usize, usize),
}

/// Expressions of some variables, ready to be enclosed on boxes.
pub(crate) struct Enclosed {
    steps: Vec<Step>,
    outputs: Vec<usize>,
    scratch: Vec<Enclosure>,
}

impl Enclosed {
    /// `None` for a function without enclosure, or a name that is no variable.
    pub(crate) fn new(pool: &Pool, variables: &[Symbol], expressions: &[Expr]) -> Option<Self> {
        let mut place: FxHashMap<Expr, usize> = FxHashMap::default();
        let mut steps = Vec::new();
        for e in pool.reachable(expressions) {
            let at = |e: Expr| place.get(&e).copied();
            let step = match pool.node(e) {
                Node::Num(_) => {
                    let value = pool.number(e)?.to_f64().value();
                    Step::Value(if value == value.trunc() && value.abs() < 1e15 {
                        Enclosure::point(value)
                    } else {
                        Enclosure::rounded(&[value])
                    })
                }
                Node::Pi => Step::Value(Enclosure::rounded(&[PI])),
                Node::Sym(s) => Step::Variable(variables.iter().position(|v| *v == s)?),
                Node::Add(a, b) => Step::Sum(at(a)?, at(b)?),
                Node::Mul(a, b) => Step::Product(at(a)?, at(b)?),
                Node::Pow(a, k) => match pool.number(k) {
                    Some(k) => Step::Power(at(a)?, k.clone()),
                    None => Step::Exponential(at(a)?, at(k)?),
                },
                Node::Call(f, a) => Step::Image(f, at(a)?),
                Node::Call2(Func2::Min, a, b) => Step::Least(at(a)?, at(b)?),
                Node::Call2(Func2::Max, a, b) => Step::Greatest(at(a)?, at(b)?),
                Node::Call2(Func2::Atan2, ..) => return None,
            };
            place.insert(e, steps.len());
            steps.push(step);
        }
        let outputs = expressions.iter().map(|e| place.get(e).copied()).collect::<Option<_>>()?;
        Some(Enclosed { scratch: Vec::with_capacity(steps.len()), steps, outputs })
    }

    /// Sets that hold the values of the expressions on the box, in order.
    pub(crate) fn on(&mut self, region: &[Enclosure], out: &mut Vec<Enclosure>) {
        let v = &mut self.scratch;
        v.clear();
        for step in &self.steps {
            let value = match *step {
                Step::Value(value) => value,
                Step::Variable(k) => region[k],
                Step::Sum(a, b) => v[a].sum(v[b]),
                Step::Product(a, b) if a == b => v[a].power(&Rational::from(2)),
                Step::Product(a, b) => v[a].product(v[b]),
                Step::Power(a, ref k) => v[a].power(k),
                Step::Exponential(a, k) => v[a].image(Func::Log).product(v[k]).image(Func::Exp),
                Step::Image(f, a) => v[a].image(f),
                Step::Least(a, b) => Enclosure { lower: v[a].lower.min(v[b].lower), upper: v[a].upper.min(v[b].upper) },
                Step::Greatest(a, b) => {
                    Enclosure { lower: v[a].lower.max(v[b].lower), upper: v[a].upper.max(v[b].upper) }
                }
            };
            v.push(value);
        }
        out.clear();
        out.extend(self.outputs.iter().map(|&k| v[k]));
    }
}
