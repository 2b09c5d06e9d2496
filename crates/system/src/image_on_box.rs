//! Images of continuous functions on closed boxes of inputs: everything from the least to the greatest value.

use bracketry_symbolic::{Expr, Func, Func2, Node, Rational, Symbol};
use rustc_hash::FxHashMap;

use crate::enclosure::{Enclosed, Enclosure};
use crate::extrema::{Least, least};
use crate::images::{Images, number};
use crate::interval::{End, Interval, close};

/// Most inputs of a function.
const MAX_INPUTS: usize = 4;

/// What a search counts of the images of one question.
const EFFORT: usize = 200;

impl Images<'_> {
    /// The image of a function of inputs that all have closed intervals. `None` where one has not, where the function is
    /// not seen to be continuous, or where its extreme values were not found.
    pub(crate) fn on_box(&mut self, e: Expr) -> Option<Interval> {
        self.effort = self.effort.checked_sub(EFFORT)?;
        let inputs = self.inputs_of(e);
        let closed = |end: &End| end.closed && end.value.is_finite();
        let known = inputs.iter().all(|u| closed(&self.domain[u].lower) && closed(&self.domain[u].upper));
        if !known || inputs.len() > MAX_INPUTS || self.pool.symbols_of(&[e]).len() > inputs.len() {
            return None;
        }
        for n in self.pool.reachable(&[e]) {
            if !self.inputs_of(n).is_empty() && !self.is_continuous(n) {
                return None;
            }
        }
        let mut all = vec![e];
        all.extend(self.pool.gradient(e, &inputs));
        let mut enclosed = Enclosed::new(self.pool, &inputs, &all)?;
        let region: Vec<Enclosure> = inputs
            .iter()
            .map(|u| Enclosure { lower: self.domain[u].lower.value, upper: self.domain[u].upper.value })
            .collect();
        let low = least(&mut enclosed, 1.0, &region)?;
        let high = least(&mut enclosed, -1.0, &region)?;
        Some(Interval { lower: self.end(e, &inputs, &low, 1.0), upper: self.end(e, &inputs, &high, -1.0) })
    }

    /// An end of the image, exact where it is taken at a corner.
    fn end(&mut self, e: Expr, inputs: &[Symbol], least: &Least, sign: f64) -> End {
        let value = sign * least.value;
        if let Some(corner) = &least.corner {
            let mut at: FxHashMap<Expr, Expr> = FxHashMap::default();
            for (&u, &upper) in inputs.iter().zip(corner) {
                let on = &self.domain[&u];
                if let Some(exact) = if upper { on.upper.exact } else { on.lower.exact } {
                    at.insert(self.pool.sym(u), exact);
                }
            }
            let here = self.pool.substitute(e, &at);
            if let Some(exact) = number(self.pool, here).filter(|v| close(*v, value)) {
                return End { value: exact, exact: Some(here), closed: true };
            }
        }
        End { value, exact: None, closed: true }
    }

    /// Whether an operation is defined and continuous on the image of its operands.
    fn is_continuous(&mut self, n: Expr) -> bool {
        let inside = |images: &mut Self, e: Expr, least: f64, greatest: f64, closed: bool| {
            images.of(e).is_ok_and(|i| {
                let (a, b) = (i.lower.value, i.upper.value);
                if closed { least <= a && b <= greatest } else { least < a && b < greatest }
            })
        };
        match self.pool.node(n) {
            Node::Pow(a, k) => match self.pool.number(k).cloned() {
                Some(k) if k.is_int() && k > Rational::ZERO => true,
                Some(k) if k.is_int() => self.of(a).is_ok_and(|i| !i.holds(0.0) && !i.holds_inside(0.0)),
                Some(k) if k > Rational::ZERO => inside(self, a, 0.0, f64::INFINITY, true),
                _ => inside(self, a, 0.0, f64::INFINITY, false),
            },
            Node::Call(Func::Log, a) => inside(self, a, 0.0, f64::INFINITY, false),
            Node::Call(Func::Asin | Func::Acos, a) => inside(self, a, -1.0, 1.0, true),
            Node::Call(Func::Tan, a) => {
                self.of(a).is_ok_and(|i| i.image(self.pool, Func::Tan).is_some_and(|i| !i.is_all()))
            }
            Node::Call(Func::Sign, _) | Node::Call2(Func2::Atan2, ..) => false,
            _ => true,
        }
    }
}
