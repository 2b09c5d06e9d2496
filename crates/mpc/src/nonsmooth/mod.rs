//! Dry friction as it is: the exact stick–slip flow with its derivative, and the controller that plans on it.

mod controller;
mod flow;
#[cfg(test)]
mod flow_tests;
mod switched_field;

pub use controller::{StickSlipController, StickSlipSettings};
pub use flow::{FrictionMode, ModeChange};
