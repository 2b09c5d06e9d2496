//! What an extension of a model changes in what the inputs reach.

use bracketry_system::System;
use serde::Serialize;

use crate::analysis::analyze::{Analysis, analyze};
use crate::answer::Answer;
use crate::dimensions::Dimensions;
use crate::options::AnalysisOptions;

/// Dimensions of what the inputs of a model reach.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranks {
    /// Number of states of the affine model.
    pub states: usize,
    /// Generic dimension of the accessible set; of all modes together where the model switches.
    pub accessible_dimension: Answer<usize>,
    /// Generic dimension of the strongly accessible set; of all modes together where the model switches.
    pub strongly_accessible_dimension: Answer<usize>,
    /// The smallest strongly accessible dimension of a single mode.
    pub least_in_a_mode: Answer<usize>,
}

/// Ranks of the given and of the extended model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RankChange {
    /// The given model.
    pub before: Ranks,
    /// The extended one.
    pub after: Ranks,
}

impl Ranks {
    /// Those of an analysis; none where no dimension was found.
    fn of(analysis: &Analysis) -> Option<Self> {
        let report = &analysis.report;
        let all: &Dimensions =
            report.switched.as_ref().map(|s| &s.dimensions).or_else(|| report.modes.first().map(|m| &m.dimensions))?;
        let modes = report.modes.iter().map(|m| &m.dimensions.strongly_accessible_dimension);
        // An undecided mode leaves the smallest undecided.
        let least = modes.min_by_key(|d| d.known().copied().unwrap_or(0))?;
        Some(Self {
            states: analysis.states,
            accessible_dimension: all.accessible_dimension.clone(),
            strongly_accessible_dimension: all.strongly_accessible_dimension.clone(),
            least_in_a_mode: least.clone(),
        })
    }
}

impl RankChange {
    /// What the analyses of both models say; none where one of them found no dimension.
    pub fn between(given: &Analysis, extended: &Analysis) -> Option<Self> {
        Some(Self { before: Ranks::of(given)?, after: Ranks::of(extended)? })
    }

    /// Analyzes both models; none if one of them cannot be analyzed.
    pub fn of_systems(given: &System, extended: &System) -> Option<Self> {
        // The dimensions alone are compared.
        let analyzed =
            |system| analyze(system, &AnalysisOptions { flatness: false, ..AnalysisOptions::default() }).ok();
        Self::between(&analyzed(given)?, &analyzed(extended)?)
    }
}
