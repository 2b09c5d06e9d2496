//! Readers for TOML documents and tables of samples, with errors that give file, line, column, offending text, and remedy.

mod columns;
mod document;
mod plausible;
mod unit;

pub use columns::{Columns, Entries};
pub use document::{Document, FileError, Table, Value};
pub use plausible::Plausible;
pub use unit::Unit;
