//! Small dense matrices, by rows in slices and in memory that is kept: nothing here allocates twice.

mod lu;
mod semidefinite;

pub use lu::Lu;
pub use semidefinite::{clip_to_psd, components, is_positive_definite};
