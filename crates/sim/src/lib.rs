//! Piecewise-smooth simulation: events, sliding and sticking, dense output.
//!
//! A system `x' = f(t, x, s)` with set-valued signs `s_i ∈ Sgn(σ_i(t, x))` (Filippov) is integrated by an adaptive
//! Dormand–Prince 5(4) method between events. Each switch is in one of three modes: sliding with `s = ±1`, or
//! sticking, where `s` solves `σ̇ = 0` and holds as long as `|s| ≤ 1`. Events are located to about 1e-12 s, all switching
//! functions that vanish together are settled together, and what sticks is kept on `σ = 0` so that it does not creep.
//! A switch may also be a unit vector `s = σ/|σ|`, any vector of the unit ball where `σ = 0`: dry friction on a plane.
//! Near rest, where its direction is attracted ever faster, the steps are implicit (Radau IIA).
//!
//! [`Model`] compiles a [`bracketry_system::System`] with [`Inputs`]; [`simulate`] runs it; [`Stepper`] and [`Plant`] do so
//! piece by piece, as in a control loop.

mod affine;
mod arrival;
mod balance;
mod contact;
mod drive;
mod elimination;
mod events;
mod implicit;
mod impulses;
mod inputs;
mod model;
mod modes;
mod multipliers;
mod onset;
mod outcome;
mod path;
mod plant;
mod resolve;
mod saltation;
mod settings;
mod simulate;
mod stages;
mod stepper;
mod switch_expressions;
mod switched;
mod tableau;
mod tangent;
mod trajectory;

pub use balance::{Account, Balance};
pub use contact::{ContactError, ContactStep, FrictionPoints, FrictionSolver, Slip};
pub use inputs::{Hold, InputError, Inputs, Samples};
pub use model::Model;
pub use modes::{Mode, ModeChange, ModeInterval};
pub use outcome::{Outcome, Statistics, StopReason};
pub use path::Path;
pub use plant::{Plant, PlantError};
pub use saltation::Saltation;
pub use settings::{Settings, SimError};
pub use simulate::{Simulation, simulate};
pub use stepper::Stepper;
pub use switched::{Closures, Coupled, Switched};
pub use tangent::Tangent;
pub use trajectory::Trajectory;
