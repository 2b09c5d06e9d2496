//! Text files whose errors name the file, line, column, offending text and remedy: TOML documents and tables of samples.

mod columns;
mod document;
mod plausible;

pub use columns::{Columns, Entries};
pub use document::{Document, FileError, Table, Value};
pub use plausible::Plausible;
