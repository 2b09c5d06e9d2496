//! What is wrong with a text.

/// A text that is not an expression.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message} (at column {}, near `{found}`): {remedy}", .offset + 1)]
pub struct ParseError {
    /// Character offset into the text, from 0.
    pub offset: usize,
    /// The offending text.
    pub found: String,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

pub(crate) fn error<T>(
    offset: usize,
    found: impl Into<String>,
    message: impl Into<String>,
    remedy: impl Into<String>,
) -> Result<T, ParseError> {
    let found: String = found.into();
    Err(ParseError { offset, found, message: message.into(), remedy: remedy.into() })
}
