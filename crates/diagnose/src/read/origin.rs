//! Where a table comes from, for messages.

use bracketry_system::{Columns, Document, FileError};

/// Where columns come from, for messages.
pub(super) struct Origin<'a> {
    pub(super) name: &'a str,
    /// The text, its header and the line of each row, in a text file.
    pub(super) table: Option<(&'a Document, &'a [String], &'a [u64])>,
}

impl Origin<'_> {
    fn row(&self, row: usize) -> String {
        match self.table.and_then(|(_, _, lines)| lines.get(row)) {
            Some(line) => format!("line {line}"),
            None => format!("sample {row}"),
        }
    }

    pub(super) fn whole(&self, message: impl Into<String>, remedy: impl Into<String>) -> FileError {
        Document::new(self.name, "").missing(message, remedy)
    }

    pub(super) fn at(&self, row: usize, column: &str, problem: &str, remedy: &str) -> FileError {
        let message = format!("{}, column `{column}`: {problem}", self.row(row));
        match self.table.and_then(|(doc, header, lines)| Some((doc, header, *lines.get(row)?))) {
            Some((doc, header, line)) => doc.error(Columns::place(doc, header, line, column), message, remedy),
            None => self.whole(message, remedy),
        }
    }
}
