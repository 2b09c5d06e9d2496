//! All questions about a system together.

pub(crate) mod affine;
pub(crate) mod analyze;
pub(crate) mod brackets;
pub(crate) mod family;
pub(crate) mod influence;
pub(crate) mod rank_change;
pub(crate) mod report;
pub(crate) mod transfer;
