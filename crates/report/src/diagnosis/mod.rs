//! A diagnosis with what only the whole of the library can add: what the extended model changes in the analysis, figures,
//! and the report as a page.

mod figures;
mod page;
mod ranks;

use std::fmt;

use bracketry_diagnose::Report;
use bracketry_system::System;
use serde::Serialize;

pub use ranks::{RankChange, Ranks};

/// A diagnosis and what follows from it.
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// What was found.
    #[serde(flatten)]
    pub report: Report,
    /// What the extended model changes in what the inputs reach; absent without an extended model, or if one of the two
    /// models cannot be analysed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ranks: Option<RankChange>,
}

impl Diagnosis {
    /// Adds to a report on `system` what the extended model changes in what the inputs reach.
    pub fn new(system: &System, report: Report) -> Self {
        let extended = report.evidence.model.as_ref();
        let ranks = extended.and_then(|extended| RankChange::between(system, &extended.system));
        Self { report, ranks }
    }
}

impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.report)?;
        match &self.ranks {
            Some(ranks) => write!(f, "\n{ranks}"),
            None => Ok(()),
        }
    }
}
