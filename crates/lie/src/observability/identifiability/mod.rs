//! Identifiability in full: local and global, with known initial values and unknown inputs, and identifiable
//! combinations of parameters.

pub(crate) mod combinations;
pub(crate) mod global;
pub(crate) mod groebner;
pub(crate) mod jets;
pub(crate) mod local_identifiability;
pub(crate) mod monomial;
pub(crate) mod report;
