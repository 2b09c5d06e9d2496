//! All questions about a system together.

pub(crate) mod affine;
pub(crate) mod analyze;
pub(crate) mod brackets;
pub(crate) mod family;
pub(crate) mod influence;
pub(crate) mod large;
pub(crate) mod rank_change;
pub(crate) mod report;
pub(crate) mod transfer;

pub use crate::dimensions::Dimensions;
pub use crate::modes::{ModeFields, Signs, mode_fields};
pub use affine::analyze_affine;
pub use analyze::{Analysis, AnalysisError, analyze};
pub use brackets::RequestedBracket;
pub use family::{Family, family_dimensions};
pub use influence::{Influence, ReachTable, Reached};
pub use rank_change::{RankChange, Ranks};
pub use report::{Effort, ModeReport, Report, SmoothedReport};
