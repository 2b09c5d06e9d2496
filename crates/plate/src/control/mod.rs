//! Feedback control of the object's pose by the plate's motion: what controllers see, what they command, within what bounds.

mod area_loop_plant;
mod displacement;
mod interface;
mod learned;
mod leveling;
mod limits;
mod model_family;
mod motion_estimator;
mod move_planner;
mod move_problem;
mod oscillation;
mod planned_commands;
mod planner;
mod pose_controller;
mod pose_filter;
mod reference_move;
mod replay;
mod rounded_contact;
mod servo_lag;
mod settings;
mod shortest;

pub use area_loop_plant::{AreaLoopPlant, RESOLUTION};
pub use interface::{Command, Measurement, PlateController};
pub use learned::{Estimate, Learned, Uncertainty};
pub use limits::PlateLimits;
pub use move_planner::{MovePlanner, PlannedMove};
pub use pose_controller::PoseController;
pub use reference_move::{Arrival, MoveError, move_with, plate_move, target_of, with_duration};
pub use rounded_contact::RoundedContact;
pub use settings::{MoveReport, PoseReport, PoseSettings, PoseStatus};
pub use shortest::PlanningBudget;
