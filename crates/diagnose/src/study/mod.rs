//! Fits of a model and of effects to records, over windows with initial states of their own.

mod linearization;

pub use linearization::{Column, Linearization, Normal};
