//! The result of a diagnosis: what was found, how sure it is, and what it is worth.

mod columns;
mod complete;
mod diagnosis;
mod note;
mod reason;
mod regime;

pub use columns::{ColumnFault, OtherUnit, Rescaling, ScaledColumn, TemperatureScale};
pub(crate) use complete::{Fits, intervals};
pub use diagnosis::{
    Candidate, Combination, Evidence, Excess, NamedCause, Place, RefittedParameter, Report, ResidualAcceleration,
    Rival, RivalModel, Value, Verdict,
};
pub use note::{Closeness, Flag, Note, Repetition};
pub use reason::{Caveat, Doubt, Mispredicted, NoMotion, OtherHold, Outcome, SmallGain, VerdictReason};
pub use regime::Regime;
