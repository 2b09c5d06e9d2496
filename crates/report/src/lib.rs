//! Every result as text, Markdown, LaTeX, HTML with MathML, JSON and figures.

mod affinization;
mod analysis;
mod analysis_pictures;
mod breakdown;
mod closed_loop_figure;
mod control;
mod diagnosis;
mod document;
mod friction_bands;
pub mod html;
mod input_table;
mod measurement;
pub mod plate;
mod point;
mod reach;
mod scenario;
mod simulation_report;
mod stiffness_run;

pub use affinization::{AffinizationReport, InputChange};
pub use analysis::{Analysis, AnalysisError, analyze};
pub use breakdown::Breakdown;
pub use control::{ControlError, Controlled, ExactPlant, control, control_watched};
pub use diagnosis::{Diagnosis, RankChange, Ranks};
pub use friction_bands::{friction_bands, friction_colors};
pub use html::Figure;
pub use input_table::SampledScenario;
pub use measurement::SensorError;
pub use point::{PointError, point};
pub use reach::{Influence, ReachTable, Reached};
pub use scenario::{Run, Scenario, ScenarioError};
pub use simulation_report::{ModeChange, SimulationReport};
pub use stiffness_run::{
    ChosenPoses, CompensatedLog, CompensatedRow, Expectation, FaultCount, Identification, LoopGain, LostMotionSummary,
    MethodSummary, ParameterSummary, PredictedTranslation, RobotLog, StiffnessRunError, Unexplained, Weighing,
};
