//! All questions about a system together.

pub(crate) mod analyze;
pub(crate) mod brackets;
pub(crate) mod display;
pub(crate) mod family;
pub(crate) mod report;
