//! The next experiment: inputs within limits that identify parameters best, or that tell two models apart.
//!
//! [`identify`] finds the inputs after which parameters are known best, [`tell`] those under which two explanations differ most, whatever a refit
//! of their parameters takes away. Inputs, their rates, and states keep their limits. One optimal control problem holds the models, their
//! sensitivities, and the information; it is solved from several starts. What is reported comes from exact simulations, with stick and slip.

mod composed;
mod design;
mod exact;
mod identify;
mod noise;
mod options;
mod plan;
mod refit;
mod search;
mod setup;
mod signals;
mod smooth;
mod starts;
mod tell;

pub use design::Design;
pub use identify::{ExpectedParameter, IDENTIFIED, Identification, identify};
pub use noise::{ColumnNoise, NoiseSource};
pub use options::{ExperimentError, ExperimentOptions, Limit};
pub use setup::comparable;
pub use signals::Signals;
pub use tell::{CLEAR, Discrimination, RESOLVED, Separation, tell};
