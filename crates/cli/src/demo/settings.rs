//! How the story is told, and what can go wrong.

use bracketry::diagnose::{DiagnoseError, DiagnosisSettings};
use bracketry::lie::AnalysisError;
use bracketry::mpc::ControlError;
use bracketry::mpc::MpcError;
use bracketry::plate::PlateError;
use bracketry::plate::control::MoveError;
use bracketry::plate::recording::{RecordingError, RecordingSettings};
use bracketry::plot::PlotError;
use bracketry::steer::from_rest::FromRestError;

/// How the story is told.
#[derive(Clone, Debug)]
pub struct StorySettings {
    /// The plant with contact over the whole footprint, and how it is recorded.
    pub plant: RecordingSettings,
    /// Length of the multisines and of experiment 1 (s); its second run, with a wider displacement, takes four seconds at most.
    pub seconds: f64,
    /// Seed of multisines and noise.
    pub seed: u64,
    /// Samples after the move in which object and plate must stay at rest.
    pub rest_samples: usize,
    /// How the logs are diagnosed.
    pub diagnosis: DiagnosisSettings,
}

impl Default for StorySettings {
    /// The reference disk with friction 0.3; logs of 8 s at 200 Hz with noise of 0.5 mm and 0.3°; up to seven causes from windows of
    /// 0.5 s; 0.6 s of rest.
    fn default() -> Self {
        let mut diagnosis = DiagnosisSettings { max_causes: 7, ..DiagnosisSettings::default() };
        diagnosis.study.window = Some(0.5);
        Self { plant: RecordingSettings::default(), seconds: 8.0, seed: 1_000_003, rest_samples: 30, diagnosis }
    }
}

/// A story that cannot be told.
#[derive(Debug, thiserror::Error)]
pub enum StoryError {
    /// The object or its friction.
    #[error(transparent)]
    Plate(#[from] PlateError),
    /// The published model cannot be analyzed.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// The inputs of the published model are not those of a plate.
    #[error(transparent)]
    FromRest(#[from] FromRestError),
    /// The logs.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The move cannot be set up.
    #[error(transparent)]
    Move(#[from] MoveError),
    /// The closed loop on the published equations.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The closed loop on the true plant.
    #[error("the closed loop on the area-contact plant: {0}")]
    Loop(#[from] MpcError),
    /// The logs cannot be diagnosed.
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    /// A figure or animation cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}
