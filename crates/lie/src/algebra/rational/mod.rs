//! Readable rational functions.

mod form;
pub(crate) mod parametric;
pub(crate) mod polynomial;
pub(crate) mod readable;
mod ring;
