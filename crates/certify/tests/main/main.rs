//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod construction;
mod literature;
