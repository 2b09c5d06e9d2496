//! Dimensions of accessibility algebras.

use serde::Serialize;

use crate::algebra::word::Bracket;
use crate::answer::Answer;
use crate::reason::Reason;

/// Dimensions of the accessibility algebra and of its strong part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dimensions {
    /// Entry k: dimension of the span of all brackets of length ≤ k + 1 of {f, g_1 … g_m}.
    pub growth: Vec<usize>,
    /// Dimension of the accessibility algebra.
    pub accessible_dimension: Answer<usize>,
    /// Brackets that span it, the first `growth[k]` of them with at most k + 1 letters; none at a point.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub basis: Vec<Bracket>,
    /// Entry k: dimension after k rounds of brackets of the g_i with f and the g_i.
    pub strong_growth: Vec<usize>,
    /// Dimension of the strong accessibility algebra.
    pub strongly_accessible_dimension: Answer<usize>,
    /// Brackets that span it, the first `strong_growth[k]` of them after k rounds; none at a point.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub strong_basis: Vec<Bracket>,
    /// Why the brackets were not closed, so that no growth is listed: the dimensions are those of a controllable linearization at the point
    /// (the origin, of a model without one), and hence full.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth_reason: Option<Reason>,
    /// Why something is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<Reason>,
}

impl Dimensions {
    /// Whether both are known.
    pub(crate) fn decided(&self) -> bool {
        self.accessible_dimension.known().is_some() && self.strongly_accessible_dimension.known().is_some()
    }

    pub(crate) fn new(
        growth: Vec<usize>,
        accessible_dimension: Answer<usize>,
        strong_growth: Vec<usize>,
        strongly_accessible_dimension: Answer<usize>,
    ) -> Self {
        let reason = accessible_dimension.reason().or(strongly_accessible_dimension.reason()).cloned();
        let (basis, strong_basis) = (Vec::new(), Vec::new());
        Dimensions {
            growth,
            accessible_dimension,
            basis,
            strong_growth,
            strongly_accessible_dimension,
            strong_basis,
            growth_reason: None,
            reason,
        }
    }
}
