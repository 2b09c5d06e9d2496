//! Readable rational functions.

mod form;
mod polynomial;
pub(crate) mod readable;
mod ring;
