//! The result of an analysis, as data and as text.

use serde::Serialize;

use crate::algebra::lie_algebra::LieAlgebra;
use crate::analysis::brackets::{RequestedBracket, by_name};
use crate::analysis::influence::ReachTable;
use crate::answer::Answer;
use crate::controllability::involutive::InvolutiveClosureReport;
use crate::controllability::point::{PointReport, Subject};
use crate::controllability::switched::SwitchedReport;
use crate::dimensions::Dimensions;
use crate::evidence::Evidence;
use crate::feedback::report::ControlReport;
use crate::modes::Signs;
use crate::observability::report::ObservabilityReport;
use crate::reason::Reason;
use bracketry_symbolic::Function;

/// What holds at a generic point while the signs of all switching functions stay as they are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeReport {
    /// Sign of each switching function; empty for a smooth system.
    pub signs: Signs,
    /// Generic dimensions.
    #[serde(flatten)]
    pub dimensions: Dimensions,
    /// Independent functions of the state that no input influences.
    pub autonomous: Answer<Vec<Function>>,
    /// How many more such functions exist than were found in closed form; absent if none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub autonomous_not_found: Option<usize>,
    /// Whether the input fields span an involutive distribution.
    pub involutive: Answer<bool>,
    /// Whether static state feedback makes the mode linear near a generic point.
    pub static_feedback_linearizable: Answer<bool>,
    /// The brackets that were asked for, in this mode; only of a system with switching.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "by_name")]
    pub brackets: Vec<RequestedBracket>,
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
    /// Why the point could not be analyzed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_point_reason: Option<Reason>,
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
    /// Relative degrees, linearization and flatness of a smooth system.
    #[serde(flatten)]
    pub control: ControlReport,
    /// Absent if the model has no outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observability: Option<ObservabilityReport>,
    /// The brackets that were asked for, simplified, one component per state; of the smoothed model if there is
    /// switching.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "by_name")]
    pub brackets: Vec<RequestedBracket>,
    /// In which round of brackets each state, and each function that no input influences within a mode, comes under the
    /// influence of the inputs: for the first mode and, where the system switches, for all modes together. Generic, as
    /// the ranks; empty where something cannot be decided or there are more than 40 states.
    ///
    /// ```
    /// use bracketry_lie::analysis::Influence::{Free, Moves, None};
    /// use bracketry_system::System;
    /// let text = "states = ['p', 'v']\ninputs = ['u']\ndynamics = { p = 'v', v = 'u' }";
    /// let cart = System::parse("cart", text).unwrap();
    /// let table = &bracketry_lie::analyze(&cart, &Default::default()).unwrap().report.reach[0];
    /// assert_eq!(table.rows[0].influence, [None, Free]); // p: by [f, g1]
    /// assert_eq!(table.rows[1].influence, [Free, Free]); // v: by g1 itself
    /// ```
    #[serde(skip)]
    pub reach: Vec<ReachTable>,
    /// What the exact decisions rest on.
    pub certificate: Evidence,
    /// What it has cost, the same on every machine unless a time limit ends it.
    pub effort: Effort,
    /// Wall-clock time of the analysis.
    pub seconds: f64,
}

/// What an analysis of an affine system has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Effort {
    /// Distinct expressions that were made: brackets, their derivatives, and what exact tests form of them.
    pub expressions: usize,
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
        let brackets = self.modes.iter().flat_map(|m| &m.brackets).chain(&self.brackets);
        decided && brackets.map(|b| &b.components).all(|b| b.known().is_some())
    }

    /// The same of the dimensions at the point of the model; false without one.
    pub fn point_decided(&self) -> bool {
        self.at_point.as_ref().and_then(Answer::known).is_some_and(|p| p.dimensions.decided())
    }
}
