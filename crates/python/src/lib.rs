//! The native module of the Python package `bracketry`.
//!
//! It hands over what the library computes, as JSON text, plain text, arrays and figures; the Python sources beside it make
//! results of it. Every function here calls what the command line calls, so that all of them give the same numbers.

#![allow(clippy::needless_pass_by_value, reason = "arguments from Python arrive by value")]

mod analysis;
mod certificates;
mod command;
mod compensator;
mod control;
mod diagnosis;
mod error;
mod export;
mod figures;
mod forms;
mod from_rest;
mod interrupt;
mod live_controller;
mod model;
mod operating_point;
mod parameters;
mod plate;
mod plate_controller;
mod simulation;
mod steering;
mod stiffness;
mod tables;

/// The native part of the package; `bracketry` wraps it.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "what Python calls it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    use super::analysis::{affinize, analyze};
    #[pymodule_export]
    use super::certificates::{certify, check_certificate};
    #[pymodule_export]
    use super::command::run_command;
    #[pymodule_export]
    use super::compensator::{CompensationStep, Compensator};
    #[pymodule_export]
    use super::control::control;
    #[pymodule_export]
    use super::diagnosis::{Page, diagnose};
    #[pymodule_export]
    use super::error::BracketryError;
    #[pymodule_export]
    use super::export::export;
    #[pymodule_export]
    use super::figures::Figures;
    #[pymodule_export]
    use super::forms::transform;
    #[pymodule_export]
    use super::from_rest::{from_rest, from_rest_map};
    #[pymodule_export]
    use super::live_controller::{LiveController, Step};
    #[pymodule_export]
    use super::model::Model;
    #[pymodule_export]
    use super::operating_point::{linearize, trim};
    #[pymodule_export]
    use super::parameters::{identifiability, parameter_cases, parameter_map};
    #[pymodule_export]
    use super::plate::run_plate;
    #[pymodule_export]
    use super::plate_controller::{PlateController, PlateStep};
    #[pymodule_export]
    use super::simulation::simulate;
    #[pymodule_export]
    use super::steering::steer;
    #[pymodule_export]
    use super::stiffness::{choose_poses, compensate, identify, weigh};
}
