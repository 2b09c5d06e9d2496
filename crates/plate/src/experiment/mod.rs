//! The published open-loop experiments, and sweeps of them.

mod held_amplitude;
mod map;
mod protocol;
mod run;
mod sweep;
mod two_step;
mod velocity_field;

pub use map::{Limits, Map, Summary, linspace, summarize};
pub(crate) use protocol::REACHED;
pub use protocol::{AmplitudeLaw, AmplitudeStep, Coordinate, Experiment};
pub use run::Run;
pub use sweep::sweep;
pub use two_step::{Stage, TwoStep, two_step, two_step_on};
pub use velocity_field::{Establishing, MeanVelocity, mean_velocity, velocity_field};
