//! The result of an analysis, as data and as text.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::answer::Answer;
use crate::control_report::ControlReport;
use crate::evidence::Evidence;
use crate::involutive::InvolutiveClosureReport;
use crate::modes::Mode;
use crate::nilpotent::LieAlgebra;
use crate::observe::ObservabilityReport;
use crate::stlc::Stlc;
use crate::switching::SwitchedReport;

/// Dimensions of the accessibility algebra and of its strong part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dimensions {
    /// Entry k: dimension of the span of all brackets of length ≤ k + 1 of {f, g_1 … g_m}.
    pub growth: Vec<usize>,
    /// Dimension of the accessibility algebra.
    pub accessible_dimension: Answer<usize>,
    /// Names of brackets that span it, the first `growth[k]` of them with at most k + 1 letters; none at a point.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub basis: Vec<String>,
    /// Entry k: dimension after k rounds of brackets of the g_i with f and the g_i.
    pub strong_growth: Vec<usize>,
    /// Dimension of the strong accessibility algebra.
    pub strongly_accessible_dimension: Answer<usize>,
    /// Names of brackets that span it, the first `strong_growth[k]` of them after k rounds; none at a point.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub strong_basis: Vec<String>,
    /// Why something is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Dimensions {
    /// Whether both are known.
    fn decided(&self) -> bool {
        self.accessible_dimension.known().is_some() && self.strongly_accessible_dimension.known().is_some()
    }

    pub(crate) fn new(
        growth: Vec<usize>,
        accessible_dimension: Answer<usize>,
        strong_growth: Vec<usize>,
        strongly_accessible_dimension: Answer<usize>,
    ) -> Self {
        let reason = accessible_dimension.reason().or(strongly_accessible_dimension.reason()).map(str::to_owned);
        let (basis, strong_basis) = (Vec::new(), Vec::new());
        Dimensions {
            growth,
            accessible_dimension,
            basis,
            strong_growth,
            strongly_accessible_dimension,
            strong_basis,
            reason,
        }
    }
}

/// Names with values, serialised as one object in this order.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Named<T>(pub Vec<(String, T)>);

impl<T> Named<T> {
    /// True without entries.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (k, v) in &self.0 {
            map.serialize_entry(k, v)?;
        }
        map.end()
    }
}

/// What holds at a generic point while the signs of all switching functions stay as they are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeReport {
    /// Sign of each switching function; empty for a smooth system.
    pub signs: Named<i8>,
    /// Generic dimensions.
    #[serde(flatten)]
    pub dimensions: Dimensions,
    /// Independent functions of the state that no input influences.
    pub autonomous: Answer<Vec<String>>,
    /// How many more such functions exist than were found in closed form; absent if none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub autonomous_not_found: Option<usize>,
    /// Whether the input fields span an involutive distribution.
    pub involutive: Answer<bool>,
    /// Whether static state feedback makes the mode linear near a generic point.
    pub static_feedback_linearizable: Answer<bool>,
    /// The brackets that were asked for, in this mode; only of a system with switching.
    #[serde(skip_serializing_if = "Named::is_empty")]
    pub brackets: Named<Answer<Vec<String>>>,
}

/// The model with every switching function replaced by a smooth one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SmoothedReport {
    /// Width of the smoothing.
    pub epsilon: f64,
    /// Generic dimensions.
    #[serde(flatten)]
    pub dimensions: Dimensions,
}

/// Which equations a statement speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Subject {
    /// The model as it stands.
    Model,
    /// The model with every switching function replaced by a smooth one.
    Smoothed,
}

/// What holds at the point of the model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointReport {
    /// Whether the statements are of the model or, where switching functions vanish at the
    /// point, of the smoothed model. Exact dry friction may hold a state that smoothed friction lets go.
    pub of: Subject,
    /// Width of the smoothing; absent if the statements are of the model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epsilon: Option<f64>,
    /// Switching functions that vanish at the point; absent if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub vanishing: Vec<String>,
    /// Whether the state rests there under the inputs given with the point.
    pub equilibrium: Answer<bool>,
    /// Dimensions at the point.
    #[serde(flatten)]
    pub dimensions: Dimensions,
    /// Rank of the Kalman matrix; absent if the point is no equilibrium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linear_controllability_rank: Option<usize>,
    /// Whether feedback can make the equilibrium asymptotically stable; absent if the point is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stabilizable: Option<Answer<bool>>,
    /// What `stabilizable` rests on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stabilizable_reason: Option<String>,
    /// Eigenvalues of the linearisation that no input reaches; absent if the point is no equilibrium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncontrollable_modes: Option<Answer<Vec<Mode>>>,
    /// Brockett's necessary condition for stabilisation by continuous state feedback; absent if
    /// the point is no equilibrium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub brockett_condition: Option<Answer<bool>>,
    /// Small-time local controllability.
    pub stlc: Stlc,
    /// Whether the outputs have a vector relative degree at the point; absent for a model without inputs or outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_degree_defined: Option<Answer<bool>>,
}

/// The Lie-algebraic analysis of a control-affine system.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// One entry per combination of signs; exactly one for a smooth system.
    pub modes: Vec<ModeReport>,
    /// All modes together; absent for a smooth system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub switched: Option<SwitchedReport>,
    /// Absent for a smooth system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothed: Option<SmoothedReport>,
    /// Absent if the model gives no point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_point: Option<Answer<PointReport>>,
    /// Why the point could not be analysed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_point_reason: Option<String>,
    /// Of which model `involutive`, `static_feedback_linearizable` and `observability` are: the
    /// smoothed one if there is switching, absent for a smooth system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub global_statements_of: Option<Subject>,
    /// The Lie algebra over the constants; absent if it is infinite-dimensional or too large, and if there is switching.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lie_algebra: Option<LieAlgebra>,
    /// Whether the input fields span an involutive distribution; of the smoothed model if there is switching.
    pub involutive: Answer<bool>,
    /// The smallest involutive distribution that contains the input fields; of the smoothed model if there is
    /// switching.
    pub involutive_closure: Answer<InvolutiveClosureReport>,
    /// Whether static state feedback makes the system linear near a generic point; of the
    /// smoothed model if there is switching.
    pub static_feedback_linearizable: Answer<bool>,
    /// Relative degrees, linearisation and flatness of a smooth system.
    #[serde(flatten)]
    pub control: ControlReport,
    /// Absent if the model has no outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observability: Option<ObservabilityReport>,
    /// The brackets that were asked for, simplified, one component per state; of the smoothed model if there is
    /// switching.
    #[serde(skip_serializing_if = "Named::is_empty")]
    pub brackets: Named<Answer<Vec<String>>>,
    /// What the exact decisions rest on.
    pub certificate: Evidence,
    /// Wall-clock time of the analysis.
    pub seconds: f64,
}

impl Report {
    /// False if not a single dimension could be decided.
    pub fn decided(&self) -> bool {
        let generic = self.modes.iter().map(|m| &m.dimensions);
        let point = self.at_point.as_ref().and_then(Answer::known).map(|p| &p.dimensions);
        generic
            .chain(self.switched.as_ref().map(|s| &s.dimensions))
            .chain(self.smoothed.as_ref().map(|s| &s.dimensions))
            .chain(point)
            .any(|d| d.accessible_dimension.known().is_some() || d.strongly_accessible_dimension.known().is_some())
    }

    /// Whether every generic dimension is decided, in every mode and over all of them, and every bracket that was asked for is
    /// formed. Other questions, as that for flat outputs, may be open.
    pub fn dimensions_decided(&self) -> bool {
        let generic = self.modes.iter().map(|m| &m.dimensions);
        let decided = generic
            .chain(self.switched.as_ref().map(|s| &s.dimensions))
            .chain(self.smoothed.as_ref().map(|s| &s.dimensions))
            .all(Dimensions::decided);
        let brackets = self.modes.iter().flat_map(|m| &m.brackets.0).chain(&self.brackets.0);
        decided && brackets.map(|(_, b)| b).all(|b| b.known().is_some())
    }

    /// The same of the dimensions at the point of the model; false without one.
    pub fn point_decided(&self) -> bool {
        self.at_point.as_ref().and_then(Answer::known).is_some_and(|p| p.dimensions.decided())
    }
}
