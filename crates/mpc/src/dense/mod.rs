//! Small dense matrices without allocation.

mod lu;
mod positive_semidefinite;

pub(crate) use lu::Factors;
pub(crate) use positive_semidefinite::{clip_to_psd, components, is_positive_definite};
