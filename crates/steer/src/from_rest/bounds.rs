//! Bounds of inputs, of their derivatives, and of coordinates.

use bracketry_symbolic::Rational;
use bracketry_system::{Constants, System};
use serde::Serialize;

use super::error::FromRestError;

/// A closed interval, with its ends as exact numbers where they are rational.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Span {
    pub(crate) ends: [f64; 2],
    pub(crate) exact: [Option<Rational>; 2],
}

impl Span {
    pub(crate) const FREE: Self = Span { ends: [f64::NEG_INFINITY, f64::INFINITY], exact: [None, None] };

    pub(crate) fn between(low: f64, high: f64) -> Self {
        Span { ends: [low, high], exact: [low, high].map(|v| Rational::try_from(v).ok()) }
    }

    pub(crate) fn point(value: &End) -> Self {
        Span { ends: [value.value; 2], exact: [value.exact.clone(), value.exact.clone()] }
    }

    /// The ends as floating-point numbers that enclose them.
    pub(crate) fn outward(&self) -> [f64; 2] {
        let [low, high] = &self.exact;
        let is_float = |v: f64, exact: &Option<Rational>| {
            exact.as_ref().is_some_and(|r| Rational::try_from(v).is_ok_and(|f| f == *r)) || v.is_infinite()
        };
        [
            if is_float(self.ends[0], low) { self.ends[0] } else { self.ends[0].next_down() },
            if is_float(self.ends[1], high) { self.ends[1] } else { self.ends[1].next_up() },
        ]
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.ends.iter().all(|v| v.is_finite())
    }

    pub(crate) fn width(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }
}

/// A number, exact if it is rational.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct End {
    pub(crate) value: f64,
    pub(crate) exact: Option<Rational>,
}

/// The least and the greatest value of an input, of a derivative of an input, or of a coordinate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// `X`, `der(X)`, or `der(X,2)`; or the name of a state.
    pub name: String,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    #[serde(skip)]
    span: Option<Span>,
}

impl Bound {
    /// The interval from `low` to `high`.
    pub fn new(name: &str, low: f64, high: f64) -> Self {
        Bound { name: plain(name), low, high, span: None }
    }

    /// The same with exact ends.
    pub fn exact(name: &str, low: Rational, high: Rational) -> Self {
        let ends = [&low, &high].map(|r| r.to_f64().value());
        let span = Span { ends, exact: [Some(low), Some(high)] };
        Bound { name: plain(name), low: ends[0], high: ends[1], span: Some(span) }
    }

    /// Reads bounds such as `der(X,2)=-4..4, theta=-pi/12..pi/12`.
    ///
    /// # Errors
    /// [`FromRestError::Bound`] for an entry that gives no interval.
    ///
    /// ```
    /// use bracketry_steer::from_rest::Bound;
    /// let bounds = Bound::list("der(X,2)=-4..4, theta=-pi/12..0.25").unwrap();
    /// assert_eq!((bounds[0].name.as_str(), bounds[1].high), ("der(X,2)", 0.25));
    /// assert!(Bound::list("theta=1..0").is_err());
    /// ```
    pub fn list(text: &str) -> Result<Vec<Self>, FromRestError> {
        entries(text).into_iter().map(Self::entry).collect()
    }

    fn entry(text: &str) -> Result<Self, FromRestError> {
        let read = || {
            let (name, ends) = text.split_once('=')?;
            let (low, high) = ends.split_once("..")?;
            let (low, high) = (number(low)?, number(high)?);
            let is_interval = low.value.is_finite() && high.value.is_finite() && low.value <= high.value;
            let span = Span { ends: [low.value, high.value], exact: [low.exact, high.exact] };
            is_interval.then(|| Bound { name: plain(name), low: low.value, high: high.value, span: Some(span) })
        };
        read().ok_or_else(|| FromRestError::Bound { text: text.trim().to_owned() })
    }

    pub(crate) fn span(&self) -> Span {
        self.span.clone().unwrap_or_else(|| Span::between(self.low, self.high))
    }
}

/// Without spaces; `der(u)` for `der(u,1)`.
fn plain(name: &str) -> String {
    let name: String = name.chars().filter(|c| !c.is_whitespace()).collect();
    name.strip_suffix(",1)").filter(|n| n.starts_with("der(")).map_or(name.clone(), |n| format!("{n})"))
}

/// What a derivative of an input is called.
pub(crate) fn derivative_name(input: &str, order: usize) -> String {
    match order {
        0 => input.to_owned(),
        1 => format!("der({input})"),
        k => format!("der({input},{k})"),
    }
}

/// The parts between commas that stand in no parentheses.
fn entries(text: &str) -> Vec<&str> {
    let mut depth = 0i32;
    text.split(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == ',' && depth == 0
    })
    .collect()
}

/// A constant.
fn number(text: &str) -> Option<End> {
    let mut scratch = System::default();
    let e = scratch.pool.parse_with(text.trim(), &mut Constants).ok()?;
    let e = scratch.pool.simplify(e);
    Some(End { value: scratch.value(e)?, exact: scratch.pool.number(e).cloned() })
}
