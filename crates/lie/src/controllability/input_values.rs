//! The values that inputs take around a point.

/// The values that an input takes; an input that is not told of takes all real numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InputValues {
    /// All numbers between these, which may be infinite.
    Between(f64, f64),
    /// Not known. The input is taken to move freely from its value at the point, and nothing is
    /// concluded from values far from it.
    Unknown,
}

impl InputValues {
    /// The ends of the range where both are finite.
    pub(crate) fn finite(self) -> Option<(f64, f64)> {
        match self {
            InputValues::Between(lower, upper) if lower.is_finite() && upper.is_finite() => Some((lower, upper)),
            _ => None,
        }
    }
}

/// The side to which an input can move from its value at the point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// To greater values, as v = u² at u = 0.
    Above,
    /// To smaller values, as v = cos u at u = 0.
    Below,
}

impl Side {
    pub(crate) fn sign(self) -> i64 {
        match self {
            Side::Above => 1,
            Side::Below => -1,
        }
    }
}
