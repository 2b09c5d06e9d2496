//! An entry on the publication.

use serde::Serialize;
use std::fmt;

/// What an entry is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A numbered equation.
    Equation,
    /// A numbered figure.
    Figure,
    /// A point of what section 3.2.3 leaves open.
    Question,
}

/// What the check of an entry gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It holds as stated.
    Right,
    /// It can be read in several ways; the remark says how it is read here.
    Ambiguous,
    /// It does not hold; the remark says why, with a number.
    Wrong,
    /// The open point has an answer.
    Answered,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Right => "right",
            Self::Ambiguous => "ambiguous",
            Self::Wrong => "wrong",
            Self::Answered => "answered",
        })
    }
}

/// Where something of the publication is here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Place {
    /// Path of the function or type, or what the file is.
    pub name: &'static str,
    /// Its file in the repository.
    pub file: &'static str,
}

/// An equation, a figure, or an open point of the publication.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// What it is about.
    pub kind: Kind,
    /// Its number in the publication.
    pub number: &'static str,
    /// What it is called here.
    pub title: &'static str,
    /// What it states.
    pub statement: &'static str,
    /// Where it is here.
    pub places: &'static [Place],
    /// Tests, as `file::name`.
    pub tests: &'static [&'static str],
    /// Commands that show it, from a clone.
    pub commands: &'static [&'static str],
    /// What the check gave.
    pub verdict: Verdict,
    /// Why, with numbers from the tests and commands.
    pub remark: &'static str,
}

impl Entry {
    /// Kind, number, and title, such as `Equation 3.16: motion of the object`.
    pub fn heading(&self) -> String {
        format!("{}: {}", self.label(), self.title)
    }

    /// Kind and number, such as `Equation 3.16`.
    pub fn label(&self) -> String {
        let kind = match self.kind {
            Kind::Equation => "Equation",
            Kind::Figure => "Figure",
            Kind::Question => "Question",
        };
        format!("{kind} {}", self.number)
    }
}
