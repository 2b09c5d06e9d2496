//! What the outputs tell about states and parameters.

pub(crate) mod codistribution;
pub(crate) mod expansion;
pub(crate) mod identifiability;
pub(crate) mod report;
pub(crate) mod sensitivity;
pub(crate) mod series;
pub(crate) mod symmetry;

pub use codistribution::Observability;
pub use identifiability::global::GlobalReason;
pub use identifiability::report::{
    Identifiability, IdentifiabilityError, IdentifiabilityOptions, IdentifiabilityReport, identifiability,
};
pub use report::{Direction, ObservabilityReport, Undetermined, observe};
pub use symmetry::{Operator, Symmetry};
