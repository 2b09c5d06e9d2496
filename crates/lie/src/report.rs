//! The result of an analysis, as data and as text.

use std::fmt;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::answer::Answer;
use crate::evidence::Evidence;
use crate::stlc::Stlc;

/// Dimensions of the accessibility algebra and of its strong part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dimensions {
    /// Entry k: dimension of the span of all brackets of length ≤ k + 1 of {f, g_1 … g_m}.
    pub growth: Vec<usize>,
    /// Dimension of the accessibility algebra.
    pub accessible_dimension: Answer<usize>,
    /// Entry k: dimension after k rounds of brackets of the g_i with f and the g_i.
    pub strong_growth: Vec<usize>,
    /// Dimension of the strong accessibility algebra.
    pub strongly_accessible_dimension: Answer<usize>,
    /// Why something is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Dimensions {
    pub(crate) fn new(
        growth: Vec<usize>,
        accessible_dimension: Answer<usize>,
        strong_growth: Vec<usize>,
        strongly_accessible_dimension: Answer<usize>,
    ) -> Self {
        let reason = accessible_dimension.reason().or(strongly_accessible_dimension.reason()).map(str::to_owned);
        Dimensions { growth, accessible_dimension, strong_growth, strongly_accessible_dimension, reason }
    }
}

/// Names with values, serialised as one object in this order.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Named<T>(pub Vec<(String, T)>);

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

/// What holds at the point of the model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointReport {
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
    /// Small-time local controllability.
    pub stlc: Stlc,
}

/// What the outputs determine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObservabilityReport {
    /// Generic rank of the observability codistribution, parameters known.
    pub rank: Answer<usize>,
    /// States whose value the outputs do not determine, parameters known.
    pub unobservable: Vec<String>,
    /// For each parameter, whether the outputs determine it while no other parameter and no state is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identifiable: Option<Named<bool>>,
    /// Rank for states and parameters together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank_with_parameters: Option<usize>,
    /// Why something is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// The Lie-algebraic analysis of a control-affine system.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// One entry per combination of signs; exactly one for a smooth system.
    pub modes: Vec<ModeReport>,
    /// All modes together; absent for a smooth system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub switched: Option<Dimensions>,
    /// Absent for a smooth system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothed: Option<SmoothedReport>,
    /// Absent if the model gives no point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_point: Option<Answer<PointReport>>,
    /// Why the point could not be analysed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_point_reason: Option<String>,
    /// Whether the input fields span an involutive distribution; of the smoothed model if there is switching.
    pub involutive: Answer<bool>,
    /// Whether static state feedback makes the system linear near a generic point; of the
    /// smoothed model if there is switching.
    pub static_feedback_linearizable: Answer<bool>,
    /// Absent if the model has no outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observability: Option<ObservabilityReport>,
    /// What the exact decisions rest on.
    pub certificate: Evidence,
    /// Wall-clock time of the analysis.
    pub seconds: f64,
}

fn yes_no(answer: &Answer<bool>) -> String {
    match answer {
        Answer::Known(true) => "yes".to_owned(),
        Answer::Known(false) => "no".to_owned(),
        Answer::Unknown(why) => format!("unknown ({why})"),
    }
}

/// A dimension among n, with the growth that leads to it.
fn dimension_line(f: &mut fmt::Formatter<'_>, label: &str, dimension: &Answer<usize>, growth: &[usize]) -> fmt::Result {
    let list: Vec<String> = growth.iter().map(ToString::to_string).collect();
    writeln!(f, "  {label:<22} {dimension}   (growth {})", list.join(", "))
}

impl fmt::Display for Dimensions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        dimension_line(f, "accessible", &self.accessible_dimension, &self.growth)?;
        dimension_line(f, "strongly accessible", &self.strongly_accessible_dimension, &self.strong_growth)
    }
}

impl fmt::Display for ModeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.signs.0.is_empty() {
            writeln!(f, "at a generic point")?;
        } else {
            let signs: Vec<String> =
                self.signs.0.iter().map(|(n, s)| format!("{n} {} 0", if *s > 0 { ">" } else { "<" })).collect();
            writeln!(f, "while {}", signs.join(", "))?;
        }
        write!(f, "{}", self.dimensions)?;
        match &self.autonomous {
            Answer::Known(list) => {
                if !list.is_empty() {
                    writeln!(f, "  no input influences    {}", list.join(",  "))?;
                }
                if let Some(k) = self.autonomous_not_found {
                    writeln!(f, "  and {k} further independent functions that were not found in closed form")?;
                }
            }
            Answer::Unknown(why) => writeln!(f, "  no input influences    unknown ({why})")?,
        }
        if !self.signs.0.is_empty() {
            writeln!(f, "  involutive inputs      {}", yes_no(&self.involutive))?;
            writeln!(f, "  feedback linearizable  {}", yes_no(&self.static_feedback_linearizable))?;
        }
        Ok(())
    }
}

impl fmt::Display for PointReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.dimensions)?;
        writeln!(f, "  equilibrium            {}", yes_no(&self.equilibrium))?;
        if let Some(rank) = self.linear_controllability_rank {
            writeln!(f, "  linear rank            {rank}")?;
        }
        if let Some(s) = &self.stabilizable {
            let why = self.stabilizable_reason.as_deref().filter(|_| s.known().is_some());
            writeln!(f, "  stabilizable           {}{}", yes_no(s), why.map_or(String::new(), |w| format!(": {w}")))?;
        }
        writeln!(f, "  small-time control     {}: {}", self.stlc.verdict, self.stlc.reason)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Modes that agree in everything but their signs are told together.
        let mut told: Vec<&ModeReport> = Vec::new();
        for mode in &self.modes {
            let same = |o: &&ModeReport| {
                o.dimensions == mode.dimensions
                    && o.autonomous == mode.autonomous
                    && o.involutive == mode.involutive
                    && o.static_feedback_linearizable == mode.static_feedback_linearizable
            };
            if told.iter().any(same) {
                continue;
            }
            told.push(mode);
            write!(f, "{mode}")?;
            let others = self.modes.iter().filter(|o| same(o)).count() - 1;
            if others > 0 {
                writeln!(f, "  the same in {others} other modes")?;
            }
        }
        if let Some(d) = &self.switched {
            write!(f, "switching between all modes\n{d}")?;
        }
        if let Some(s) = &self.smoothed {
            write!(f, "smoothed, width {}\n{}", s.epsilon, s.dimensions)?;
        }
        match &self.at_point {
            Some(Answer::Known(p)) => write!(f, "at the point of the model\n{p}")?,
            Some(Answer::Unknown(why)) => writeln!(f, "at the point of the model: unknown ({why})")?,
            None => {}
        }
        writeln!(f, "input fields involutive: {}", yes_no(&self.involutive))?;
        writeln!(f, "linearizable by static feedback: {}", yes_no(&self.static_feedback_linearizable))?;
        if let Some(o) = &self.observability {
            writeln!(f, "observability rank: {}", o.rank)?;
            if !o.unobservable.is_empty() {
                writeln!(f, "  not determined by the outputs: {}", o.unobservable.join(", "))?;
            }
            for (name, yes) in o.identifiable.iter().flat_map(|m| &m.0) {
                writeln!(f, "  parameter {name}: {}", if *yes { "identifiable" } else { "not identifiable" })?;
            }
        }
        writeln!(
            f,
            "exact modulo 2^61-1 at {} points, error probability {}; {:.3} s",
            self.certificate.points(),
            self.certificate.error_text(),
            self.seconds
        )
    }
}
