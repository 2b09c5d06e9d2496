//! A published result beside ours.

use serde::Serialize;
use std::fmt;

/// The test that compares the lines of [`Ours::Printed`] with what the commands print.
pub(super) const PRINTED: &str = "crates/cli/tests/main/reproduced.rs::commands_print_what_the_rows_say";

/// What a result is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Field {
    /// Controllability, stabilization, and static feedback.
    Controllability,
    /// Flatness, chained forms, and steering.
    Flatness,
    /// Identifiability and observability.
    Identifiability,
    /// Optimal control.
    OptimalControl,
    /// Dynamics, friction, contact, stiffness, and stability.
    Dynamics,
}

impl Field {
    /// All fields, in the order of the rows.
    pub const ALL: [Self; 5] =
        [Self::Controllability, Self::Flatness, Self::Identifiability, Self::OptimalControl, Self::Dynamics];
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Controllability => "Controllability and feedback",
            Self::Flatness => "Flatness and steering",
            Self::Identifiability => "Identifiability and observability",
            Self::OptimalControl => "Optimal control",
            Self::Dynamics => "Dynamics, friction, and stability",
        })
    }
}

/// How our result compares with the published one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The statement holds, or the number agrees to its published digits, within 0.1 %, within its stated error, or within the tolerance that is
    /// stated with the test.
    Same,
    /// It does not; the remark says what is known about the reason.
    Differs,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Same => "same",
            Self::Differs => "differs",
        })
    }
}

/// Our figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ours {
    /// Parts of what a command prints from a clone, with single spaces; "…" ends a number that is cut off.
    Printed {
        /// The command.
        command: &'static str,
        /// The parts.
        lines: &'static [&'static str],
    },
    /// What the first test of the row asserts.
    Asserted(&'static str),
}

/// A published result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Row {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it is about.
    pub field: Field,
    /// The system or method.
    pub subject: &'static str,
    /// Authors and year, as in `docs/references.md`.
    pub reference: &'static str,
    /// What is published, in our words.
    pub claim: &'static str,
    /// What we find.
    pub ours: Ours,
    /// Tests, as `file::name`.
    pub tests: &'static [&'static str],
    /// How the two compare.
    pub verdict: Verdict,
    /// Why they differ, or what limits the comparison; may be empty.
    pub remark: &'static str,
}

impl Row {
    /// Name and subject.
    pub fn heading(&self) -> String {
        format!("{}: {}", self.name, self.subject)
    }

    /// The command that shows our figure, from a clone: that of the toolkit, or the first test.
    pub fn command(&self) -> String {
        match self.ours {
            Ours::Printed { command, .. } => command.to_owned(),
            Ours::Asserted(_) => self.tests.first().and_then(|test| test_command(test)).unwrap_or_default(),
        }
    }

    /// What we find, a part for each line.
    pub fn figure(&self) -> Vec<&'static str> {
        match self.ours {
            Ours::Printed { lines, .. } => lines.to_vec(),
            Ours::Asserted(text) => vec![text],
        }
    }
}

/// The command that runs a test `crates/NAME/tests/main/MODULE.rs::TEST`, or one of the workspace's own, `tests/main/…`.
fn test_command(test: &str) -> Option<String> {
    let (folder, rest) = test.split_once("tests/main/")?;
    let package =
        folder.strip_prefix("crates/").map_or(String::new(), |name| format!("-{}", name.trim_end_matches('/')));
    Some(format!("cargo test -p bracketry{package} --test main -- {}", rest.replacen(".rs::", "::", 1)))
}
