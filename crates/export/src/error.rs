//! What cannot be exported.

use bracketry_symbolic::CompileError;
use bracketry_system::ZeroDenominator;

/// A request that cannot be met.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// A parameter that the model does not have.
    #[error("the model has no parameter `{name}`\n   = {remedy}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// What to write.
        remedy: String,
    },
    /// A parameter that is named twice.
    #[error("the parameter `{name}` is named twice\n   = name it once")]
    RepeatedParameter {
        /// The name.
        name: String,
    },
    /// A name that no language takes.
    #[error(
        "`{name}` cannot be the name of a module\n   = start with a letter, and continue with letters, digits, and _ \
         (ASCII)"
    )]
    Name {
        /// The name.
        name: String,
    },
    /// A denominator that is zero with the values of the parameters that are constants.
    #[error(transparent)]
    ZeroDenominator(#[from] ZeroDenominator),
    /// An equation that uses what is neither state nor input nor parameter.
    #[error(transparent)]
    Compile(#[from] CompileError),
}
