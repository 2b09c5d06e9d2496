//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod calculus;
mod canonical;
mod collect;
mod common;
mod constants;
mod derivatives;
mod exact;
mod exact_random;
mod forms;
mod latex;
mod notation;
mod point;
mod primes;
mod random;
mod reals;
mod relations;
mod residues;
mod source;
mod table;
mod text;
mod traps;
mod univariate;
