//! Normal forms with their coordinate changes.

pub(crate) mod chained;
pub(crate) mod inversion;
