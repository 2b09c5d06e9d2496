//! Every result as text, Markdown, LaTeX, HTML with MathML, JSON and figures.

mod affinization;
mod analysis;
mod analysis_pictures;
mod area_plant;
mod closed_loop_figure;
mod control;
mod diagnosis;
mod document;
pub mod html;
mod plate_move;
mod plate_run;
mod reach;
pub mod simulation;
pub mod stiffness;

pub use affinization::{AffinizationReport, InputChange};
pub use analysis::{Analysis, AnalysisError, analyze};
pub use area_plant::AreaLoopPlant;
pub use control::{ControlError, Controlled, ExactPlant, control, control_watched};
pub use diagnosis::{Diagnosis, RankChange, Ranks};
pub use html::Figure;
pub use plate_move::{Arrival, MoveError, RESOLUTION, move_with, plate_move, target_of};
pub use plate_run::{
    Comparison, Deviation, Jump, LoggedMotion, PlateExperiment, PlateLog, PlateModel, PlateOptions, PlateReport,
    PlateRow, PlateRun, PlateRunError, PlateSetup, SetupError, outline,
};
pub use reach::{Influence, ReachTable, Reached};
pub use simulation::{friction_bands, friction_colors};
