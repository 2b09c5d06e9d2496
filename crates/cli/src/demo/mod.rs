//! The whole story of the vibrating plate, chapter by chapter: what the published equations let the inputs reach, a closed loop
//! on them, the same controller on the true plant, a diagnosis of what was logged there, and the extended model in control.

mod event;
mod figures;
mod logs;
mod loop_conditions;
mod on_equations;
mod on_plant;
mod page;
mod settings;
mod shortest;
mod story;
mod summary;
mod tell;
mod text;
mod truth;

pub use event::{Finding, StoryEvent};
pub use logs::{identification_runs, log_of_move};
pub use on_equations::MoveOnEquations;
pub use on_plant::MoveOnPlant;
pub use settings::{StoryError, StorySettings};
pub use story::{Story, StoryAnimation};
