#![doc = include_str!("../README.md")]

#[cfg(feature = "certify")]
pub use bracketry_certify as certify;
#[cfg(feature = "diagnose")]
pub use bracketry_diagnose as diagnose;
#[cfg(feature = "export")]
pub use bracketry_export as export;
pub use bracketry_files as files;
pub use bracketry_lie as lie;
#[cfg(feature = "control")]
pub use bracketry_mpc as mpc;
#[cfg(feature = "control")]
pub use bracketry_native as native;
#[cfg(feature = "plate")]
pub use bracketry_plate as plate;
#[cfg(feature = "plot")]
pub use bracketry_plot as plot;
#[cfg(feature = "report")]
pub use bracketry_report as report;
#[cfg(feature = "simulate")]
pub use bracketry_sim as sim;
#[cfg(feature = "steer")]
pub use bracketry_steer as steer;
#[cfg(feature = "stiffness")]
pub use bracketry_stiffness as stiffness;
pub use bracketry_symbolic as symbolic;
pub use bracketry_system as system;

pub use bracketry_lie::{Analysis, AnalysisError, Influence, ReachTable, Reached, analyze};
#[cfg(feature = "control")]
pub use bracketry_mpc::{ControlError, Controlled, control, control_watched};
#[cfg(feature = "report")]
pub use bracketry_report::analysis::{AffinizationReport, InputChange};
#[cfg(feature = "report")]
pub use bracketry_report::{Diagnosis, Figure, RankChange, Ranks, friction_bands, friction_colors};
#[cfg(feature = "simulate")]
pub use bracketry_sim::{Breakdown, ExactPlant, SampledScenario, Scenario, ScenarioError, ScenarioRun, SensorError};
pub use bracketry_system::{PointError, point};

/// From installation to a result on a system of one's own, in ten minutes.
#[cfg(feature = "report")]
#[doc = include_str!("../docs/getting_started.md")]
pub mod getting_started {}

/// A tutorial: from two equations to a verdict, and from there to the plate.
#[cfg(feature = "report")]
#[doc = include_str!("../docs/tutorial.md")]
pub mod tutorial {}

/// Model-predictive control of a model of one's own, from a problem file and from Rust.
#[cfg(feature = "report")]
#[doc = include_str!("../docs/mpc.md")]
pub mod control_guide {}

/// Controllers for a plant of one's own: from Rust, from Python, and over a pipe.
#[cfg(feature = "report")]
#[doc = include_str!("../docs/live.md")]
pub mod live_guide {}

/// Lyapunov functions, regions of attraction, passivity, and conserved functions, with certificates.
#[cfg(feature = "report")]
#[doc = include_str!("../docs/certify.md")]
pub mod certificates_guide {}

/// From measured data to the named cause: a guide.
#[cfg(feature = "report")]
#[doc = include_str!("../docs/diagnose.md")]
pub mod diagnose_guide {}

/// Verdicts by cases of parameters: special values, and maps over two of them.
#[cfg(feature = "report")]
#[doc = include_str!("../docs/parameters.md")]
pub mod parameters_guide {}

/// The equations of a model as source code.
#[cfg(feature = "report")]
#[doc = include_str!("../docs/export.md")]
pub mod export_guide {}

/// Identifiability in full.
#[cfg(feature = "report")]
#[doc = include_str!("../docs/identifiability.md")]
pub mod identifiability_guide {}
