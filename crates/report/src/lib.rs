//! Every result as text, Markdown, LaTeX, HTML with MathML, JSON and figures.

mod affinization;
mod analysis;
mod analysis_pictures;
mod closed_loop_figure;
mod control;
mod diagnosis;
mod document;
pub mod html;
pub mod plate;
mod reach;
pub mod simulation;
mod stiffness_run;

pub use affinization::{AffinizationReport, InputChange};
pub use analysis::{Analysis, AnalysisError, analyze};
pub use control::{ControlError, Controlled, ExactPlant, control, control_watched};
pub use diagnosis::{Diagnosis, DiagnosisJson, RankChange, Ranks, text as diagnosis_text};
pub use html::Figure;
pub use reach::{Influence, ReachTable, Reached};
pub use simulation::{friction_bands, friction_colors};
pub use stiffness_run::{
    ChosenPoses, CompensatedLog, CompensatedRow, Expectation, FaultCount, Identification, LoopGain, LostMotionSummary,
    MethodSummary, ParameterSummary, PredictedTranslation, RobotLog, StiffnessRunError, Unexplained, Weighing,
};
