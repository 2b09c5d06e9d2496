//! What is to be written.

use std::fmt;
use std::str::FromStr;

use bracketry_symbolic::{Language, closest_name};
use serde::{Serialize, Serializer};

/// A language in which a model can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// C99 with `math.h`: a header and a source file, also for C++.
    C,
    /// A module without allocation that needs only the functions of `f64`.
    Rust,
    /// A module that needs NumPy.
    Python,
    /// A Python module whose functions return `casadi.Function` objects.
    Casadi,
    /// A module for any type of number.
    Julia,
}

impl Target {
    /// Every language.
    pub const ALL: [Target; 5] = [Target::C, Target::Rust, Target::Python, Target::Casadi, Target::Julia];

    /// The name by which it is chosen.
    pub fn name(self) -> &'static str {
        match self {
            Target::C => "c",
            Target::Rust => "rust",
            Target::Python => "python",
            Target::Casadi => "casadi",
            Target::Julia => "julia",
        }
    }

    /// The name as its users write it.
    pub fn title(self) -> &'static str {
        match self {
            Target::C => "C",
            Target::Rust => "Rust",
            Target::Python => "Python",
            Target::Casadi => "CasADi",
            Target::Julia => "Julia",
        }
    }

    /// The language of its statements.
    pub(crate) fn language(self) -> Language {
        match self {
            Target::C => Language::C,
            Target::Rust => Language::Rust,
            Target::Python => Language::NumPy,
            Target::Casadi => Language::Casadi,
            Target::Julia => Language::Julia,
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for Target {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// A name of no language.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{name}` is not a language of the export\n   = {remedy}")]
pub struct UnknownTarget {
    /// The name.
    pub name: String,
    /// What to write.
    pub remedy: String,
}

impl FromStr for Target {
    type Err = UnknownTarget;

    fn from_str(name: &str) -> Result<Self, UnknownTarget> {
        let wanted = name.to_lowercase();
        Target::ALL.into_iter().find(|t| t.name() == wanted).ok_or_else(|| {
            let known = Target::ALL.map(Target::name);
            let remedy = match closest_name(&wanted, known.into_iter()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("write one of {}", known.join(", ")),
            };
            UnknownTarget { name: name.to_owned(), remedy }
        })
    }
}

/// Which parameters are arguments of the functions; the others are constants with the values of the model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum KeptParameters {
    /// None.
    #[default]
    None,
    /// All of them.
    All,
    /// Those named, in the order in which they are named.
    Named(Vec<String>),
}

impl KeptParameters {
    /// Those named; `all` alone means all of them.
    pub fn from_names(names: Vec<String>) -> Self {
        match &names[..] {
            [] => KeptParameters::None,
            [one] if one == "all" => KeptParameters::All,
            _ => KeptParameters::Named(names),
        }
    }
}

/// What [`export`](crate::export) writes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportOptions {
    /// The language.
    pub target: Target,
    /// Which parameters are arguments.
    pub parameters: KeptParameters,
    /// What module, files, and the prefix of functions in C are called; the name of the model where this is absent.
    pub name: Option<String>,
}

impl ExportOptions {
    /// All parameters are constants; the name is that of the model.
    pub fn new(target: Target) -> Self {
        Self { target, parameters: KeptParameters::None, name: None }
    }
}
