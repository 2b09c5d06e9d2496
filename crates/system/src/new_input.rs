//! New inputs of an affine form.

use bracketry_symbolic::Expr;
use serde::Serialize;

use crate::range::Range;

/// Where the value of a new input at the model's point lies in its range.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AtPoint {
    /// It can be made larger and smaller.
    Interior,
    /// It can only be made larger.
    AtLower,
    /// It can only be made smaller.
    AtUpper,
    /// Not established, or the model gives no point.
    Unknown,
}

/// A new input v = w(x, u).
#[derive(Clone, Debug, PartialEq)]
pub struct NewInput {
    /// Its name.
    pub name: String,
    /// The function w of the old inputs (for [`Method::Feedback`](crate::Method::Feedback) also of the states).
    pub function: Expr,
    /// The values of w while the old inputs take all values of their ranges.
    pub values: Range,
    /// Where the value at the point lies among these.
    pub at_point: AtPoint,
}

impl NewInput {
    /// The limits of the values of w, such as `v1 ≥ 0`, where there are any and they are established.
    pub fn range(&self) -> Option<String> {
        self.values.text(&self.name)
    }
}
