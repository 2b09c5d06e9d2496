//! Records cut into windows, and the model fitted to them by simulation.
//!
//! Every window has an initial state of its own, which is fitted with the unknowns that all windows share (multiple shooting
//! without continuity: Bock, "Recent advances in parameter identification techniques for ODE", 1983, where the windows are
//! joined). The equations are simulated with exact sticking and sliding, never differentiated data.

mod column_path;
mod compiled;
mod fit;
mod initial;
mod linearization;
mod linearize;
mod multiple_shooting;
mod normal;
mod predictor;
mod runner;
mod sensitivity;
mod shown_columns;
mod signal_path;
mod slot;
mod step;
mod time_scale;
mod tracked;
mod trajectory;
mod unknown;
mod window;
mod window_length;

pub use fit::{Estimate, Fit, FitStatus};
pub use linearization::{Column, Linearization, Normal};
pub use multiple_shooting::Study;
pub use predictor::Predictor;
pub use slot::WindowFit;
pub use window::{Window, WindowLength, Windows};

pub(crate) use signal_path::lagged;
pub(crate) use window::{shorter_windows, stretches};
