//! Where something holds.

use std::fmt;

use bracketry_symbolic::{Expr, Function, Pool};

use crate::as_text::serialized_as_text;

/// A condition on states and parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Condition {
    /// The function is zero.
    Vanishes(Function),
    /// The function is not zero.
    Differs(Function),
    /// The function is positive.
    Positive(Function),
    /// The function is negative.
    Negative(Function),
    /// All hold; without any, everywhere.
    All(Vec<Condition>),
    /// At least one holds; without any, nowhere.
    Any(Vec<Condition>),
}

impl Condition {
    /// At least one of the functions vanishes, shortest first.
    pub(crate) fn any_vanishes(pool: &Pool, functions: &[Expr]) -> Self {
        let mut list: Vec<(u64, Expr)> = functions.iter().map(|&e| (pool.text_size(e).length, e)).collect();
        list.sort_by(|&(a, x), &(b, y)| a.cmp(&b).then_with(|| pool.compare(x, y)));
        Condition::Any(list.into_iter().map(|(_, e)| Condition::Vanishes(Function::new(pool, e))).collect())
    }

    /// Whether it is seen to hold nowhere.
    pub fn is_nowhere(&self) -> bool {
        matches!(self, Condition::Any(list) if list.is_empty())
    }

    /// Where it does not hold (of `Positive` and `Negative`: where the function has the other sign).
    #[must_use]
    pub fn negated(self) -> Self {
        match self {
            Condition::Vanishes(f) => Condition::Differs(f),
            Condition::Differs(f) => Condition::Vanishes(f),
            Condition::Positive(f) => Condition::Negative(f),
            Condition::Negative(f) => Condition::Positive(f),
            Condition::All(list) => Condition::Any(list.into_iter().map(Self::negated).collect()),
            Condition::Any(list) => Condition::All(list.into_iter().map(Self::negated).collect()),
        }
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joined =
            |list: &[Condition], between: &str| list.iter().map(ToString::to_string).collect::<Vec<_>>().join(between);
        match self {
            Condition::Vanishes(e) => write!(f, "{e} = 0"),
            Condition::Differs(e) => write!(f, "{e} ≠ 0"),
            Condition::Positive(e) => write!(f, "{e} > 0"),
            Condition::Negative(e) => write!(f, "{e} < 0"),
            Condition::All(list) => f.write_str(&joined(list, ", ")),
            Condition::Any(list) if list.is_empty() => f.write_str("none"),
            Condition::Any(list) => f.write_str(&joined(list, " or ")),
        }
    }
}

serialized_as_text!(Condition);
