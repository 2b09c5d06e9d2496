#![doc = include_str!("../README.md")]

pub use bracketry_diagnose as diagnose;
pub use bracketry_lie as lie;
pub use bracketry_mpc as mpc;
pub use bracketry_native as native;
pub use bracketry_plate as plate;
pub use bracketry_plot as plot;
pub use bracketry_sim as sim;
pub use bracketry_stiffness as stiffness;
pub use bracketry_symbolic as symbolic;
pub use bracketry_system as system;

mod affinization;
mod analysis;
mod analysis_pictures;
mod area_plant;
mod breakdown;
mod closed_loop_figure;
mod control;
mod diagnosis;
mod friction_bands;
mod html;
mod input_table;
mod measurement;
mod plate_move;
mod plate_run;
mod point;
mod reach;
mod report;
mod scenario;
mod simulation_report;
mod stiffness_run;
mod story;

pub use affinization::{AffinizationReport, InputChange};
pub use analysis::{Analysis, AnalysisError, analyze};
pub use area_plant::AreaLoopPlant;
pub use breakdown::Breakdown;
pub use control::{ControlError, Controlled, ExactPlant, control, control_watched};
pub use diagnosis::{Diagnosis, RankChange, Ranks};
pub use friction_bands::{friction_bands, friction_colors};
pub use html::Figure;
pub use input_table::SampledScenario;
pub use measurement::SensorError;
pub use plate_move::{Arrival, MoveError, move_with, plate_move, target_of};
pub use plate_run::{
    Comparison, Deviation, Jump, LoggedMotion, PlateExperiment, PlateLog, PlateModel, PlateOptions, PlateReport,
    PlateRow, PlateRun, PlateRunError, PlateSetup, SetupError,
};
pub use point::{PointError, point};
pub use reach::{Influence, ReachTable, Reached};
pub use scenario::{Run, Scenario, ScenarioError};
pub use simulation_report::{ModeChange, SimulationReport};
pub use stiffness_run::{
    ChosenPoses, CompensatedLog, CompensatedRow, Expectation, FaultCount, Identification, LoopGain, LostMotionSummary,
    MethodSummary, ParameterSummary, PredictedTranslation, RobotLog, StiffnessRunError, Unexplained, Weighing,
};
pub use story::{
    MoveOnEquations, MoveOnPlant, Story, StoryAnimation, StoryError, StoryEvent, StorySettings, outline, record_logs,
};

/// From installation to a result on a system of one's own, in ten minutes.
#[doc = include_str!("../docs/getting_started.md")]
pub mod getting_started {}

/// A tutorial: from two equations to a verdict, and from there to the plate.
#[doc = include_str!("../docs/tutorial.md")]
pub mod tutorial {}

/// Model-predictive control of a model of one's own, from a problem file and from Rust.
#[doc = include_str!("../docs/mpc.md")]
pub mod control_guide {}

/// From measured data to the named cause: a guide.
#[doc = include_str!("../docs/diagnose.md")]
pub mod diagnose_guide {}
