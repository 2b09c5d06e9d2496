//! A diagnosis with what the extended model changes in the analysis, as text, JSON, figures, and a page.

mod figures;
mod json;
mod page;
mod ranks;
mod sentences;
mod table;
mod text;

use std::fmt;
use std::path::PathBuf;

use bracketry_diagnose::{Cause, Report};
use bracketry_lie::analysis::RankChange;
use serde::{Serialize, Serializer};

pub use json::DiagnosisJson;
pub use ranks::rank_change_text;
pub use text::text;

/// A diagnosis and what follows from it.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// What was found.
    pub report: Report,
    /// What the extended model changes in what the inputs reach; absent without an extended model, or if one of the two
    /// models cannot be analyzed.
    pub ranks: Option<RankChange>,
    /// The file of the extended model, if it was written.
    pub extended_model: Option<PathBuf>,
    /// Commands that design the next experiment, where causes are confusable and the models were written.
    pub next_experiments: Vec<NextExperiment>,
}

/// The command that designs an experiment which distinguishes a cause from a rival.
#[derive(Clone, Debug, Serialize)]
pub struct NextExperiment {
    /// The cause.
    pub cause: Cause,
    /// The rival.
    pub rival: Cause,
    /// The command line.
    pub command: String,
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
            #[serde(skip_serializing_if = "<[_]>::is_empty")]
            next_experiments: &'a [NextExperiment],
        }
        let report = DiagnosisJson::of(&self.report, self.extended_model.as_deref());
        Whole { report, ranks: self.ranks.as_ref(), next_experiments: &self.next_experiments }.serialize(serializer)
    }
}

impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text(&self.report, self.extended_model.as_deref()))?;
        if let Some(ranks) = &self.ranks {
            write!(f, "\n{}", rank_change_text(ranks))?;
        }
        for next in &self.next_experiments {
            writeln!(f, "\nNext experiment, to distinguish {} from {}:\n  {}", next.cause, next.rival, next.command)?;
        }
        Ok(())
    }
}
