//! The one exception of the package.

use std::error::Error;

use pyo3::exceptions::PyValueError;
use pyo3::{PyErr, create_exception};

create_exception!(
    bracketry,
    BracketryError,
    PyValueError,
    "Invalid input. The message says where, why, and what to change."
);

/// A message for the user.
#[derive(Debug)]
pub(crate) struct Failure(String);

impl Failure {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }

    /// The same with what it is about in front.
    pub(crate) fn about(self, what: &str) -> Self {
        Self(format!("{what}: {}", self.0))
    }

    /// The same with `mu` in place of `--mu`: options of the command line are arguments here.
    pub(crate) fn without_dashes(self) -> Self {
        Self(self.0.replace(" --", " ").trim_start_matches("--").to_owned())
    }
}

impl<E: Error> From<E> for Failure {
    /// The error's message and those of its causes, as the command line writes them.
    fn from(error: E) -> Self {
        let mut message = error.to_string();
        let mut source = error.source();
        while let Some(cause) = source {
            let text = cause.to_string();
            if !message.ends_with(&text) {
                message = format!("{message}: {text}");
            }
            source = cause.source();
        }
        Self(message)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        BracketryError::new_err(failure.0)
    }
}
