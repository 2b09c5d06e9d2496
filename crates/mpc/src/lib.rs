//! Optimal control: multiple shooting, sequential quadratic programming, and real-time iteration, on a stagewise interior-point method and Clarabel.
//!
//! An [`Ocp`] states the problem
//!
//! ```text
//! min  Σ_k dt·l(x_k, u_k, t_k, r_k) + e(x_N, t_N, r_N) + penalties
//! s.t. x_{k+1} = F(x_k, u_k),   x_0 given,   u in its bounds (hard),   x in its bounds (soft by default),
//!      optionally x_N = target (soft, with an exact linear penalty)
//! ```
//!
//! over a [`Dynamics`], whose flow F is that of an [`Integrator`] (Runge–Kutta or collocation) with exact sensitivities; path,
//! norm and terminal constraints, move blocks and live parameters are fields of [`Ocp`] too. [`Sqp`] solves it to convergence
//! from any guess, globalized by a filter, and where the dynamics contain `sign` (dry friction) by continuation in the smoothing
//! width. [`Rti`] is the real-time iteration: one quadratic program per sample. [`StickSlipController`] solves on the exact
//! stick–slip flow. [`run_closed_loop`] puts a [`Controller`] and a [`Plant`] together, with delay ([`DelayCompensated`](closed_loop::DelayCompensated)),
//! noise, [`Fault`](closed_loop::Fault)s and a [`FailurePolicy`](controller::FailurePolicy); [`ControlProblem`] reads all of it from a file.
//!
//! Where not all states are measured, an [`Estimator`](estimation::Estimator) ([`ExtendedKalman`](estimation::ExtendedKalman) or
//! [`MovingHorizon`](estimation::MovingHorizon)) finds states, parameters and
//! disturbances from an [`EstimationProblem`](estimation::EstimationProblem);
//! [`OffsetFree`](estimation::OffsetFree) makes a controller of them that leaves no offset.
//!
//! A pendulum moves by 1 rad from rest to rest in 2 s, with the least ∫ u² dt:
//!
//! ```
//! use bracketry_mpc::{CostFunction, CostKind, Ocp, SolveStatus, Sqp, SqpSettings, SymbolicDynamics, TerminalTarget};
//! use bracketry_system::System;
//! let system = System::parse("pendulum.toml", r#"
//!     states = ["th", "w"]
//!     inputs = ["u"]
//!     dynamics = { th = "w", w = "-9.81*sin(th) + u" }
//! "#).unwrap();
//! let mut ocp = Ocp::new(2, 1, 40, 0.05);
//! ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], "u^2").unwrap());
//! ocp.input_bounds = vec![(-8.0, 8.0)];
//! let target = |state, value| TerminalTarget { state, value, linear: 1e3, quadratic: 1e3 };
//! ocp.targets = vec![target(0, 1.0), target(1, 0.0)];
//! let dynamics = SymbolicDynamics::new(&system).unwrap();
//! let mut sqp = Sqp::new(Box::new(dynamics), ocp, SqpSettings::default()).unwrap();
//! let guess = sqp.guess(&[0.0, 0.0], &vec![vec![0.0]; 40]).unwrap();
//! let solution = sqp.solve(&[0.0, 0.0], &guess).unwrap();
//! assert_eq!(solution.status, SolveStatus::Converged);
//! assert!(solution.miss.iter().all(|e| e.abs() < 1e-6));
//! ```
//!
//! Results are values: an infeasible problem, an iteration limit or a measurement that is not a number is a status with its
//! reason; an error is misuse.

pub mod closed_loop;
pub mod controller;
mod deviations;
pub mod dynamics;
mod error;
pub mod estimation;
pub mod exact_friction;
mod integrator;
pub mod live;
pub mod ocp;
pub mod problem;
mod problem_file;
pub mod qp;
pub mod riccati;
pub mod rti;
pub mod sqp;
mod trajectory;
mod transcription;

pub use closed_loop::{Plant, run_closed_loop};
pub use controller::Controller;
pub use dynamics::{Dynamics, SymbolicDynamics};
pub use error::{MpcError, PlantFailure};
pub use exact_friction::StickSlipController;
pub use integrator::Integrator;
pub use live::LiveController;
pub use ocp::{CostFunction, CostKind, Ocp, TerminalTarget};
pub use problem::{ControlError, ControlProblem, Controlled, control, control_watched};
pub use rti::{Rti, RtiSettings};
pub use sqp::{SolveStatus, Sqp, SqpSettings};
pub use trajectory::PlannedTrajectory;
pub use transcription::ShootingLinearization;
