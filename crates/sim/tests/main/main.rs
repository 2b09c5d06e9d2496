//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod affine;
mod balance;
mod common;
mod contact;
mod convergence;
mod coupled_friction;
mod coupled_robustness;
mod delays;
mod discrete;
mod implicit;
mod models;
mod partly_coupled_friction;
mod robustness;
mod set_valued;
mod smoothing_splines;
mod static_level;
mod stick_slip;
mod sticking;
mod stiff;
mod stop_flag;
mod time_stepping;
