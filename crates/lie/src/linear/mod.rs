//! Exact linear algebra over the rational numbers, for linearizations whose entries are rational.

pub(crate) mod matrix;
pub(crate) mod numerical;
pub(crate) mod program;
pub(crate) mod polynomial;
pub(crate) mod spectrum;
