//! The command `bracketry`, which the wheel includes.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command with arguments as a shell passes them, its name first. Returns the exit code.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| bracketry_cli::run(arguments))
}
