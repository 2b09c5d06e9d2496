//! The vibrating hyper-plate: published model, experiments, objects and scenarios.
//!
//! A plate translates along its x axis, `X(t)`, and rotates about the same axis, `theta(t)`. An object lies on it without
//! being grasped; its position `(x, y)` and yaw `phi` in the plate frame are moved by dry friction alone.

mod experiment;
mod friction;
mod motion;
mod published;
mod shape;
mod two_step;

pub use experiment::{AmplitudeLaw, Experiment, Run};
pub use friction::Friction;
pub use motion::{ExpressionMotion, PlateKinematics, PlateMotion};
pub use published::published;
pub use shape::Shape;
pub use two_step::{Stage, TwoStep, two_step};

/// What can be wrong with a plate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlateError {
    /// A length or coefficient without meaning.
    #[error("{name} = {value} must be a positive number")]
    BadNumber {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A coefficient without meaning.
    #[error("{name} = {value} must be a finite number, zero or positive")]
    NegativeNumber {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// Static friction below sliding friction.
    #[error("mu_static = {mu_static} is below mu = {mu}; give a static level that is at least the sliding one")]
    StaticBelowSliding {
        /// Coefficient of sliding.
        mu: f64,
        /// Coefficient of sticking.
        mu_static: f64,
    },
    /// An expression of the plate's motion cannot be used.
    #[error("the plate motion `{text}`: {reason}")]
    Motion {
        /// The expression.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A number of the plate's motion that is none.
    #[error("the number {name} = {value} of the plate motion must be finite")]
    BadMotionNumber {
        /// Which one.
        name: String,
        /// Its value.
        value: f64,
    },
    /// The model lacks a state that the experiment moves.
    #[error("the model has no state `{name}`")]
    NoState {
        /// The state.
        name: &'static str,
    },
    /// Nothing was to be done.
    #[error("no experiment was given")]
    NoExperiment,
    /// The model file cannot be read.
    #[error(transparent)]
    File(Box<bracketry_system::FileError>),
    /// The inputs do not fit the model.
    #[error(transparent)]
    Input(#[from] bracketry_sim::InputError),
    /// The state or the settings do not fit.
    #[error(transparent)]
    Sim(#[from] bracketry_sim::SimError),
}

impl From<bracketry_system::FileError> for PlateError {
    fn from(error: bracketry_system::FileError) -> Self {
        Self::File(Box::new(error))
    }
}
