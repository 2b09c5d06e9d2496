//! What an effect changes, for the reader.

use std::fmt;

use bracketry_symbolic::Notation;
use serde::{Serialize, Serializer};

/// A formula for the reader: a line of text, and the same laid out for LaTeX and MathML.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formula {
    text: String,
    notation: Notation,
}

impl Formula {
    /// A line of text with its layout.
    pub fn new(text: impl Into<String>, notation: Notation) -> Self {
        Formula { text: text.into(), notation }
    }

    /// The line of text, as `-c*v`.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The layout.
    pub fn notation(&self) -> &Notation {
        &self.notation
    }
}

/// Words that are set as they are.
impl From<&str> for Formula {
    fn from(words: &str) -> Self {
        Formula::new(words, Notation::text(words))
    }
}

impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.text)
    }
}

impl Serialize for Formula {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.text)
    }
}
