//! Dry friction as it is: the exact stick–slip flow with its derivative, and the controller that plans on it.

mod controller;
mod events;
mod flow;
#[cfg(test)]
mod flow_tests;
mod roll_out;
mod settings;
mod switched_field;

pub use controller::StickSlipController;
pub(crate) use flow::StickSlipFlow;
pub(crate) use roll_out::ExactProblem;
pub use settings::StickSlipSettings;
pub(crate) use switched_field::SwitchedField;
