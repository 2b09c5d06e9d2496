//! The library of causes: effects instantiated on a model from its structure alone.

mod apply;

pub use apply::TIME_INPUT;
