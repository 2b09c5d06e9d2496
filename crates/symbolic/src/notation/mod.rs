//! Formulas as they are set: one tree, laid out from an expression or by hand, printed as LaTeX or MathML.

mod latex;
mod layout;
mod mathml;
mod name;
mod tree;

pub use tree::{Fence, Joint, Notation, Relation};
