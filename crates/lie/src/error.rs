//! Misuse and bad input.

use crate::undecided::Undecided;

/// Why an analysis could not be made at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// There is nothing to analyze.
    #[error("the system has no states")]
    NoStates,
    /// A vector field or point of the wrong size.
    #[error("a vector field or point has {found} components, but the system has {expected} states")]
    Dimension {
        /// Number of states.
        expected: usize,
        /// Components found.
        found: usize,
    },
    /// A point with the wrong number of inputs.
    #[error("the point gives {found} inputs, but the system has {expected}")]
    Inputs {
        /// Number of inputs.
        expected: usize,
        /// Inputs found.
        found: usize,
    },
    /// The range of an input is told that does not exist.
    #[error("there is no input {name} for this range")]
    UnknownInput {
        /// The name.
        name: String,
    },
    /// The system is not affine in its inputs.
    #[error("{equation} is not affine in the inputs; make the system affine first")]
    NotAffine {
        /// Where.
        equation: String,
    },
    /// More switching functions than are expanded into modes.
    #[error("{switches} switching functions give too many modes")]
    Modes {
        /// Number of switching functions.
        switches: usize,
    },
    /// A constant that has no numerical value.
    #[error("{what} has no value at the point")]
    NoValue {
        /// What.
        what: String,
    },
    /// A function that jumps, other than those that switch modes.
    #[error("{what} jumps at the point: choose a point beside the jump")]
    Jumps {
        /// What.
        what: String,
    },
    /// Text that should be a bracket of the system's fields.
    #[error(transparent)]
    Bracket(#[from] WordError),
    /// A function that was asked for cannot be read.
    #[error("`{text}`: {problem}")]
    Function {
        /// The text.
        text: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A question that must be answered first stays open.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}

/// Text that is no bracket of the generators.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not a bracket: at character {column}, {problem}")]
pub struct WordError {
    /// The whole text.
    pub text: String,
    /// Where, counted in characters from 1.
    pub column: usize,
    /// What is wrong there.
    pub problem: WordProblem,
}

/// What is wrong with a text that should be a bracket.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WordProblem {
    /// Something else was expected.
    #[error("expected {expected}, found {found}")]
    Expected {
        /// What may stand here.
        expected: &'static str,
        /// What stands here.
        found: String,
    },
    /// A name that is no generator.
    #[error("`{name}` is neither a generator nor an input{remedy}")]
    UnknownName {
        /// The name.
        name: String,
        /// What may have been meant.
        remedy: String,
    },
    /// A name of an input that is also the name of another generator.
    #[error("`{name}` names both an input and another input field")]
    Ambiguous {
        /// The name.
        name: String,
    },
    /// More letters than can be evaluated.
    #[error("more than {limit} letters")]
    TooLong {
        /// Letters that are allowed.
        limit: usize,
    },
}
