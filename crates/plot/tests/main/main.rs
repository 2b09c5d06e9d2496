//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod animation;
mod figures;
mod legends;
mod maps;
mod readings;
