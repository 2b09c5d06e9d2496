//! A diagnosis with what only the whole of the library can add: what the extended model changes in the analysis, figures,
//! and the report as a page.

mod figures;
mod json;
mod page;
mod ranks;
mod sentences;
mod table;
mod text;

use std::fmt;

use bracketry_diagnose::Report;
use bracketry_system::System;
use serde::{Serialize, Serializer};

pub use json::DiagnosisJson;
pub use ranks::{RankChange, Ranks};
pub use text::text;

/// A diagnosis and what follows from it.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// What was found.
    pub report: Report,
    /// What the extended model changes in what the inputs reach; absent without an extended model, or if one of the two
    /// models cannot be analyzed.
    pub ranks: Option<RankChange>,
}

impl Diagnosis {
    /// Adds to a report on `system` what the extended model changes in what the inputs reach.
    pub fn new(system: &System, report: Report) -> Self {
        let extended = report.evidence.model.as_ref();
        let ranks = extended.and_then(|extended| RankChange::of_systems(system, &extended.system));
        Self { report, ranks }
    }
}

impl Serialize for Diagnosis {
    /// The JSON object of `bracketry diagnose --json`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Whole<'a> {
            #[serde(flatten)]
            report: DiagnosisJson<'a>,
            #[serde(skip_serializing_if = "Option::is_none")]
            ranks: Option<&'a RankChange>,
        }
        Whole { report: DiagnosisJson::of(&self.report), ranks: self.ranks.as_ref() }.serialize(serializer)
    }
}

impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text(&self.report))?;
        match &self.ranks {
            Some(ranks) => write!(f, "\n{ranks}"),
            None => Ok(()),
        }
    }
}
