//! Feedback control of the object's pose by the plate's motion: what controllers see, what they command, within what bounds.

mod friction_bank;
mod interface;
mod limits;
mod move_problem;
mod oscillation;
mod planner;
mod pose_controller;
mod replay;
mod rounded_contact;
mod settings;

pub use interface::{Command, Measurement, PlateController};
pub use limits::PlateLimits;
pub use pose_controller::PoseController;
pub use rounded_contact::RoundedContact;
pub use settings::{MoveReport, PoseReport, PoseSettings, PoseStatus};
