//! One-step methods that advance a state over an interval, with exact sensitivities.

mod collocation;
mod explicit;
mod interval;
mod map;
mod method;
mod one_step;
mod stages;
#[cfg(test)]
mod tests;

pub(crate) use collocation::Collocation;
pub(crate) use explicit::ExplicitRungeKutta;
pub(crate) use interval::Interval;
pub(crate) use map::MapIteration;
pub use method::Integrator;
pub(crate) use one_step::{Differentiated, OneStepMethod};
pub(crate) use stages::Stages;
