//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod example;
mod header;
mod misuse;
