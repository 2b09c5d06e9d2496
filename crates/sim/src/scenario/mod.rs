//! Simulations by files: what a scenario or a table of inputs says, its run, and what sensors would give of it.

mod discrete;
mod file;
mod implicit;
mod run;
mod sensors;
mod setup;
mod table;

pub use run::{ScenarioError, ScenarioRun};
pub use sensors::SensorError;
pub use setup::{SampledScenario, Scenario};
