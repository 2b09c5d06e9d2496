//! Piecewise-smooth simulation: events, sliding and sticking, dense output.
//!
//! A system `x' = f(t, x, s)` with set-valued signs `s_i ∈ Sgn(σ_i(t, x))` (Filippov) is integrated by an adaptive
//! Dormand–Prince 5(4) method between events. Each switch is in one of three modes: sliding with `s = ±1`, or
//! sticking, where `s` solves `σ̇ = 0` and holds as long as `|s| ≤ 1`. Events are located to about 1e-12 s, all switching
//! functions that vanish together get their next modes together, and what sticks is kept on `σ = 0` so that it does not creep.
//! A switch may also be a unit vector `s = σ/|σ|`, any vector of the unit ball where `σ = 0`: dry friction on a plane.
//! Near rest, where its direction is attracted ever faster, the steps are implicit (Radau IIA). So they are where a smooth field is
//! stiff, which is found out during the simulation.
//!
//! [`Model`] compiles a [`bracketry_system::System`] with [`Inputs`]; [`simulate`] runs it; [`Stepper`] and [`ExactPlant`] do so
//! piece by piece, as in a control loop.
//!
//! ```
//! use bracketry_sim::{Inputs, Model, SimulationSettings, simulate};
//! use bracketry_system::System;
//! let text = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u - sign(v)' }";
//! let block = System::parse("block.toml", text).unwrap();
//! // Pushed with 3 against dry friction of 1 for one second, then left alone: it slides for two seconds more, and stops.
//! let push = Inputs::new().expression("u", "1.5 + 1.5*sign(1 - t)");
//! let run = simulate(Model::new(&block, &push).unwrap(), 0.0, &[0.0, 0.0], 5.0, &SimulationSettings::default()).unwrap();
//! assert!(run.outcome.is_finished());
//! assert!((run.trajectory.final_state()[0] - 3.0).abs() < 1e-9);
//! assert!(run.trajectory.final_state()[1].abs() < 1e-12);
//! ```

mod algebraic_root;
mod balance;
mod breakdown;
mod contact;
mod discrete;
mod events;
mod friction;
mod implicit_model;
mod integrate;
mod model;
mod outcome;
mod plant;
mod scenario;
mod sensitivity;
mod settings;
mod simulate;
mod stepper;
mod switched;
mod trajectory;

pub use algebraic_root::{AlgebraicRoot, NoRoot, NoRootReason};
pub use balance::{Account, Balance};
pub use bracketry_numerics::spline::{Bandwidth, SmoothingSpline, smooth};
pub use breakdown::{Breakdown, Undefined, UndefinedPart};
pub use contact::{ContactError, ContactStep, FrictionPoints, FrictionSolver, Slip};
pub use discrete::DiscreteModel;
pub use friction::{FrictionMode, ModeChange, ModeInterval};
pub use implicit_model::ImplicitModel;
pub use model::{Hold, InputError, Inputs, Model, Samples};
pub use outcome::{Outcome, Statistics, StopReason};
pub use plant::{ExactPlant, PlantError};
pub use scenario::{SampledScenario, Scenario, ScenarioError, ScenarioRun, SensorError};
pub use sensitivity::{Path, Saltation, Tangent};
pub use settings::{SimError, SimulationSettings};
pub use simulate::{Simulation, simulate};
pub use stepper::Stepper;
pub use switched::{Closures, Coupled, Switched};
pub use trajectory::Trajectory;
