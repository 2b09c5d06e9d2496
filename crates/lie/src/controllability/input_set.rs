//! The inputs of a system with the values that they take.

use bracketry_symbolic::{Expr, Pool, Rational};

use crate::controllability::input_values::{InputValues, Side};
use crate::controllability::local_accessibility::Frame;

/// The inputs in their order, with their names, the values that they take and the sides to which
/// they are said to move from their values at the point.
pub(crate) struct InputSet<'a> {
    pub(crate) names: &'a [String],
    pub(crate) values: Vec<Option<InputValues>>,
    pub(crate) one_sided: Vec<Option<Side>>,
}

/// Nearer than this, relative to its size, a value counts as the end of its range.
const AT_END: f64 = 1e-9;

impl InputSet<'_> {
    /// Whether the input takes all real numbers.
    pub(crate) fn unbounded(&self, i: usize) -> bool {
        match self.values[i] {
            None => self.one_sided[i].is_none(),
            Some(InputValues::Between(lower, upper)) => lower == f64::NEG_INFINITY && upper == f64::INFINITY,
            Some(InputValues::Unknown) => false,
        }
    }

    /// Whether the input takes all real numbers to one side of some value, or to both.
    pub(crate) fn reaches_infinity(&self, i: usize) -> bool {
        match self.values[i] {
            Some(InputValues::Between(lower, upper)) => lower == f64::NEG_INFINITY || upper == f64::INFINITY,
            _ => self.unbounded(i),
        }
    }

    /// Whether inputs with known ranges lie strictly inside of them, and the others may take both signs of any deviation.
    pub(crate) fn inside(&self, pool: &mut Pool, frame: &Frame, inputs: &[Expr]) -> bool {
        // What is said of an input at the point says nothing of it at other values.
        let known = self.values.iter().zip(&self.one_sided).all(|(values, said)| match values {
            Some(InputValues::Between(..)) => true,
            Some(InputValues::Unknown) => false,
            None => said.is_none(),
        });
        known && self.sides(pool, frame, inputs).is_some_and(|sides| sides.iter().all(Option::is_none))
    }

    /// The inputs that do not lie in their ranges.
    pub(crate) fn outside(&self, pool: &mut Pool, frame: &Frame, inputs: &[Expr]) -> Vec<String> {
        let Some(numbers) = frame.numbers(pool, inputs) else { return Vec::new() };
        let mut list = Vec::new();
        for ((name, values), u) in self.names.iter().zip(&self.values).zip(numbers) {
            if let Some(InputValues::Between(lower, upper)) = *values {
                let close = AT_END * (1.0 + u.abs());
                if u < lower - close || u > upper + close {
                    list.push(name.clone());
                }
            }
        }
        list
    }

    /// How far the inputs have to move to lie in their ranges; `None` where they do already or it is not known.
    pub(crate) fn within_ranges(&self, pool: &mut Pool, frame: &Frame, inputs: &[Expr]) -> Option<Vec<Expr>> {
        let numbers = frame.numbers(pool, inputs)?;
        let mut moves = Vec::new();
        for ((values, &u), number) in self.values.iter().zip(inputs).zip(numbers) {
            let end = match *values {
                Some(InputValues::Between(lower, _)) if number < lower => Some(lower),
                Some(InputValues::Between(_, upper)) if number > upper => Some(upper),
                _ => None,
            };
            moves.push(match end {
                Some(end) => {
                    let end = pool.rational(Rational::simplest_from_f64(end)?);
                    pool.sub(end, u)
                }
                None => pool.int(0),
            });
        }
        moves.iter().any(|&e| !pool.is_zero(e)).then_some(moves)
    }

    /// The sides to which the inputs can move from `inputs`; `None` where these are outside of
    /// the ranges or have no numerical values.
    pub(crate) fn sides(&self, pool: &mut Pool, frame: &Frame, inputs: &[Expr]) -> Option<Vec<Option<Side>>> {
        if self.values.iter().all(|v| !matches!(v, Some(InputValues::Between(..)))) {
            return Some(self.one_sided.clone());
        }
        let numbers = frame.numbers(pool, inputs)?;
        let mut sides = Vec::new();
        for ((values, said), u) in self.values.iter().zip(&self.one_sided).zip(numbers) {
            let side = match *values {
                Some(InputValues::Between(lower, upper)) => {
                    let close = AT_END * (1.0 + u.abs());
                    match ((u - lower).abs() <= close, (u - upper).abs() <= close) {
                        (true, false) => Some(Side::Above),
                        (false, true) => Some(Side::Below),
                        (false, false) if lower < u && u < upper => None,
                        _ => return None,
                    }
                }
                Some(InputValues::Unknown) | None => *said,
            };
            sides.push(side);
        }
        Some(sides)
    }
}
