//! Every result as text, Markdown, LaTeX, HTML with MathML, JSON and figures.

pub mod analysis;
mod area_plant;
mod closed_loop_figure;
mod control;
mod diagnosis;
mod document;
pub mod html;
mod plate_move;
mod plate_run;
pub mod simulation;
mod stiffness_run;

pub use area_plant::AreaLoopPlant;
pub use control::{ControlError, Controlled, ExactPlant, control, control_watched};
pub use diagnosis::{Diagnosis, RankChange, Ranks};
pub use html::Figure;
pub use plate_move::{Arrival, MoveError, RESOLUTION, move_with, plate_move, target_of};
pub use plate_run::{
    Comparison, Deviation, Jump, LoggedMotion, PlateExperiment, PlateLog, PlateModel, PlateOptions, PlateReport,
    PlateRow, PlateRun, PlateRunError, PlateSetup, SetupError, outline,
};
pub use simulation::{friction_bands, friction_colors};
pub use stiffness_run::{
    ChosenPoses, CompensatedLog, CompensatedRow, Expectation, FaultCount, Identification, LoopGain, LostMotionSummary,
    MethodSummary, ParameterSummary, PredictedTranslation, RobotLog, StiffnessRunError, Unexplained, Weighing,
};
