//! First integrals of a distribution.

pub(crate) mod ansatz;
pub(crate) mod blocks;
pub(crate) mod fraction;
pub(crate) mod search;
