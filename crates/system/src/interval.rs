//! Intervals with open or closed, possibly infinite ends, and the images of elementary functions on them.

use std::f64::consts::{FRAC_PI_2, PI};

use bracketry_symbolic::{Expr, Func, Pool, Rational};

/// One end of an interval.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct End {
    /// As a number; infinite where the interval has no such end.
    pub(crate) value: f64,
    /// Exactly, where it is known and finite.
    pub(crate) exact: Option<Expr>,
    /// Whether it belongs to the interval.
    pub(crate) closed: bool,
}

/// A set of real numbers without gaps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Interval {
    pub(crate) lower: End,
    pub(crate) upper: End,
}

/// Numbers closer than this, relative to their size, are taken for equal.
const CLOSE: f64 = 1e-12;

pub(crate) fn close(a: f64, b: f64) -> bool {
    a == b || (a.is_finite() && b.is_finite() && (a - b).abs() <= CLOSE * (1.0 + a.abs().max(b.abs())))
}

impl End {
    pub(crate) fn infinite(value: f64) -> Self {
        End { value, exact: None, closed: false }
    }

    pub(crate) fn rational(pool: &mut Pool, value: &Rational, closed: bool) -> Self {
        End { value: value.to_f64().value(), exact: Some(pool.rational(value.clone())), closed }
    }

    fn integer(pool: &mut Pool, value: i64, closed: bool) -> Self {
        Self::rational(pool, &Rational::from(value), closed)
    }

    fn sum(pool: &mut Pool, a: &End, b: &End) -> Self {
        let exact = a.exact.zip(b.exact).map(|(x, y)| pool.add(x, y));
        End { value: a.value + b.value, exact, closed: a.closed && b.closed }
    }

    /// Product of values that are taken by two functions independently of each other.
    fn product(pool: &mut Pool, a: &End, b: &End) -> Self {
        if a.value == 0.0 || b.value == 0.0 {
            let attained = |e: &End| e.value == 0.0 && e.closed;
            return Self::integer(pool, 0, attained(a) || attained(b) || (a.closed && b.closed));
        }
        let exact = a.exact.zip(b.exact).map(|(x, y)| pool.mul(x, y));
        End { value: a.value * b.value, exact, closed: a.closed && b.closed }
    }

    fn power(&self, pool: &mut Pool, k: &Rational) -> Self {
        let exponent = k.to_f64().value();
        let value = if self.value == 0.0 && exponent < 0.0 { f64::INFINITY } else { self.value.powf(exponent) };
        if value.is_infinite() {
            return Self::infinite(value);
        }
        let k = pool.rational(k.clone());
        let exact = if self.value.is_infinite() { Some(pool.int(0)) } else { self.exact.map(|e| pool.pow(e, k)) };
        End { value, exact, closed: self.closed && self.value.is_finite() }
    }

    /// The value of an increasing or decreasing function, or its limit.
    fn image(&self, pool: &mut Pool, f: Func) -> Self {
        let half_turns = |pool: &mut Pool, value: f64| {
            let (half, pi) = (pool.ratio(if value > 0.0 { 1 } else { -1 }, 2), pool.pi());
            End { value: FRAC_PI_2.copysign(value), exact: Some(pool.mul(half, pi)), closed: false }
        };
        match (f, self.value) {
            (Func::Atan, v) if v.is_infinite() => half_turns(pool, v),
            (Func::Tanh, v) if v.is_infinite() => Self::integer(pool, if v > 0.0 { 1 } else { -1 }, false),
            (Func::Exp, f64::NEG_INFINITY) => Self::integer(pool, 0, false),
            (_, v) => {
                let value = f.eval(v);
                if value.is_infinite() {
                    return Self::infinite(value);
                }
                let exact = self.exact.map(|e| pool.call(f, e));
                End { value, exact, closed: self.closed }
            }
        }
    }
}

fn least(ends: &[End]) -> Option<End> {
    let best = ends.iter().min_by(|a, b| a.value.total_cmp(&b.value))?.clone();
    Some(attained(best, ends))
}

fn greatest(ends: &[End]) -> Option<End> {
    let best = ends.iter().max_by(|a, b| a.value.total_cmp(&b.value))?.clone();
    Some(attained(best, ends))
}

/// The end, closed where any equal one is.
fn attained(mut best: End, ends: &[End]) -> End {
    for e in ends.iter().filter(|e| close(e.value, best.value)) {
        best.closed |= e.closed;
        if best.exact.is_none() {
            best.exact = e.exact;
        }
    }
    best
}

impl Interval {
    /// All real numbers.
    pub(crate) fn all() -> Self {
        Interval { lower: End::infinite(f64::NEG_INFINITY), upper: End::infinite(f64::INFINITY) }
    }

    pub(crate) fn is_all(&self) -> bool {
        self.lower.value == f64::NEG_INFINITY && self.upper.value == f64::INFINITY
    }

    pub(crate) fn point(value: f64, exact: Expr) -> Self {
        let end = End { value, exact: Some(exact), closed: true };
        Interval { lower: end.clone(), upper: end }
    }

    /// The smallest interval that holds all of `ends`; `None` without any or where one is not a number.
    pub(crate) fn hull(ends: &[End]) -> Option<Self> {
        if ends.iter().any(|e| e.value.is_nan()) {
            return None;
        }
        Some(Interval { lower: least(ends)?, upper: greatest(ends)? })
    }

    /// Whether the number lies inside, not at an end.
    pub(crate) fn holds_inside(&self, x: f64) -> bool {
        self.lower.value < x && x < self.upper.value && !close(x, self.lower.value) && !close(x, self.upper.value)
    }

    /// Whether it ends at zero without holding it.
    pub(crate) fn excludes_zero_at_end(&self) -> bool {
        (self.lower.value == 0.0 && !self.lower.closed) || (self.upper.value == 0.0 && !self.upper.closed)
    }

    /// Whether the number belongs to it.
    pub(crate) fn holds(&self, x: f64) -> bool {
        self.holds_inside(x)
            || (close(self.lower.value, x) && self.lower.closed)
            || (close(self.upper.value, x) && self.upper.closed)
    }

    pub(crate) fn sum(&self, pool: &mut Pool, other: &Self) -> Self {
        let lower = End::sum(pool, &self.lower, &other.lower);
        Interval { lower, upper: End::sum(pool, &self.upper, &other.upper) }
    }

    pub(crate) fn product(&self, pool: &mut Pool, other: &Self) -> Option<Self> {
        let mut corners = Vec::new();
        for a in [&self.lower, &self.upper] {
            for b in [&other.lower, &other.upper] {
                corners.push(End::product(pool, a, b));
            }
        }
        Self::hull(&corners)
    }

    /// The part that is not below zero; `None` if there is none.
    fn not_negative(&self, pool: &mut Pool) -> Option<Self> {
        if self.upper.value < 0.0 {
            return None;
        }
        let lower = if self.lower.value < 0.0 { End::integer(pool, 0, true) } else { self.lower.clone() };
        Some(Interval { lower, upper: self.upper.clone() })
    }

    /// Values of t^k; `None` where it has a pole inside or no value.
    pub(crate) fn power(&self, pool: &mut Pool, k: &Rational) -> Option<Self> {
        let (zero, even) = (0.0, k.is_int() && k.clone() / Rational::from(2) == half_floor(k));
        let negative = *k < Rational::ZERO;
        if negative && (self.holds(zero) || self.holds_inside(zero)) {
            return None;
        }
        let on = if k.is_int() { self.clone() } else { self.not_negative(pool)? };
        let mut ends = Vec::new();
        for e in [&on.lower, &on.upper] {
            let mut p = e.power(pool, k);
            // The limit of an odd negative power comes from the side on which the interval lies.
            if p.value == f64::INFINITY && negative && !even && on.upper.value <= 0.0 {
                p.value = f64::NEG_INFINITY;
            }
            ends.push(p);
        }
        if even && self.holds_inside(zero) {
            ends.push(End::integer(pool, 0, true));
        }
        Self::hull(&ends)
    }

    /// Values of an elementary function; `None` where it has a pole inside or no value.
    pub(crate) fn image(&self, pool: &mut Pool, f: Func) -> Option<Self> {
        let monotone = |pool: &mut Pool, on: &Interval| {
            let ends = vec![on.lower.image(pool, f), on.upper.image(pool, f)];
            Self::hull(&ends)
        };
        match f {
            Func::Exp | Func::Tanh | Func::Sinh | Func::Atan => monotone(pool, self),
            Func::Log => {
                let mut on = self.not_negative(pool)?;
                if on.lower.value == 0.0 {
                    on.lower.closed = false;
                }
                let upper = on.upper.image(pool, f);
                let lower =
                    if on.lower.value == 0.0 { End::infinite(f64::NEG_INFINITY) } else { on.lower.image(pool, f) };
                Self::hull(&[lower, upper])
            }
            Func::Asin | Func::Acos => {
                let unit = Interval { lower: End::integer(pool, -1, true), upper: End::integer(pool, 1, true) };
                let on = Interval {
                    lower: if self.lower.value <= -1.0 { unit.lower } else { self.lower.clone() },
                    upper: if self.upper.value >= 1.0 { unit.upper } else { self.upper.clone() },
                };
                if on.lower.value > on.upper.value { None } else { monotone(pool, &on) }
            }
            Func::Cosh => {
                let mut ends = vec![self.lower.image(pool, f), self.upper.image(pool, f)];
                if self.holds_inside(0.0) {
                    ends.push(End::integer(pool, 1, true));
                }
                Self::hull(&ends)
            }
            Func::Abs => {
                let mut ends = vec![self.lower.image(pool, f), self.upper.image(pool, f)];
                if self.holds_inside(0.0) {
                    ends.push(End::integer(pool, 0, true));
                }
                Self::hull(&ends)
            }
            Func::Sin => self.wave(pool, f, FRAC_PI_2),
            Func::Cos => self.wave(pool, f, 0.0),
            Func::Tan => {
                let (a, b) = (self.lower.value, self.upper.value);
                let turns = |x: f64| (x / PI - 0.5).floor();
                if b - a > PI && !close(b - a, PI) {
                    return Some(Self::all());
                }
                // Between two neighboring poles only.
                if turns(a) != turns(b) || close(a / PI - 0.5, (a / PI - 0.5).round()) {
                    return None;
                }
                if close(b / PI - 0.5, (b / PI - 0.5).round()) { None } else { monotone(pool, self) }
            }
            Func::Sign => None,
        }
    }

    /// Sine or cosine; `crest` is an angle at which it is 1.
    fn wave(&self, pool: &mut Pool, f: Func, crest: f64) -> Option<Self> {
        let mut ends = Vec::new();
        for e in [&self.lower, &self.upper] {
            if e.value.is_finite() {
                ends.push(e.image(pool, f));
            }
        }
        for (value, at) in [(1, crest), (-1, crest + PI)] {
            let next = at + 2.0 * PI * ((self.lower.value - at) / (2.0 * PI)).ceil();
            let infinite = self.lower.value.is_infinite() || self.upper.value.is_infinite();
            if infinite || self.holds_inside(next) || self.holds_inside(next + 2.0 * PI) {
                ends.push(End::integer(pool, value, true));
            }
        }
        Self::hull(&ends)
    }

    /// The union, if it has no gap.
    pub(crate) fn union(mut parts: Vec<Interval>) -> Option<Self> {
        parts.sort_by(|a, b| a.lower.value.total_cmp(&b.lower.value).then(b.lower.closed.cmp(&a.lower.closed)));
        let mut parts = parts.into_iter();
        let mut all = parts.next()?;
        for p in parts {
            let meets = if close(p.lower.value, all.upper.value) {
                p.lower.closed || all.upper.closed
            } else {
                p.lower.value < all.upper.value
            };
            if !meets {
                return None;
            }
            let ends = [all.lower, all.upper, p.lower, p.upper].to_vec();
            all = Self::hull(&ends)?;
        }
        Some(all)
    }
}

/// ⌊k/2⌋ for an integer k.
fn half_floor(k: &Rational) -> Rational {
    let half = k.clone() / Rational::from(2);
    half.floor().into()
}
