//! Inputs that move a model from one state to another, and the motion that they give.
//!
//! [`steer`] plans by the chained form (sinusoids), by Philip Hall coordinates (piecewise constant inputs), by flat outputs
//! (polynomials), or by shooting. Whatever the plan, the inputs that it returns are simulated on the given model, and the end
//! error is that of the simulation.
//!
//! ```
//! use bracketry_steer::{SteerOptions, SteerStatus, steer};
//! use bracketry_system::System;
//! let unicycle = System::parse(
//!     "unicycle.toml",
//!     "states = ['x', 'y', 'th']\ninputs = ['s', 'w']\ndynamics = { x = 's*cos(th)', y = 's*sin(th)', th = 'w' }",
//! ).unwrap();
//! let sideways = steer(&unicycle, &SteerOptions::between(&[0.0; 3], &[0.0, 1.0, 0.0])).unwrap();
//! assert_eq!(sideways.status, SteerStatus::Reached);
//! assert!(sideways.end_error < 1e-6);
//! ```

mod chain;
mod chained;
mod correction;
mod driver;
mod flat;
pub mod from_rest;
mod hall_algebra;
mod integrators;
mod loops;
mod nilpotent;
mod options;
mod problem;
mod ranges;
mod roll_out;
mod shooting;
mod signals;
mod steering;

pub use driver::steer;
pub use integrators::own_inputs;
pub use options::{SteerError, SteerMethod, SteerOptions};
pub use signals::Signals;
pub use steering::{Attempt, Plan, SteerNote, SteerReason, SteerStatus, Steering};
