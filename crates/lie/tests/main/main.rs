//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod cases;
mod chained;
mod common;
mod critical_modes;
mod critical_zero_dynamics;
mod edges;
mod family;
mod flat_chains;
mod flatness;
mod full_identifiability;
mod hall;
mod identifiability;
mod identities;
mod input_output;
mod integrals;
mod invariance;
mod irrational;
mod large_coefficients;
mod linearize;
mod numerical;
mod observability;
mod parameter_cases;
mod plate;
mod ranges;
mod ruled_manifold;
mod semidefinite_pencils;
mod simulated;
mod stabilizable;
mod stlc;
mod stop_flag;
mod switching;
mod transform;
mod transform_parts;
mod trim;
mod uncontrollable_modes;
