//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod analysis;
mod common;
mod control;
mod diagnosis;
mod document;
mod page;
mod publication;
mod reproduced;
mod stiffness_text;
