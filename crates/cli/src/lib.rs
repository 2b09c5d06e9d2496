//! The demonstration behind the command `bracketry`, as a library for its tests.

pub mod demo;
