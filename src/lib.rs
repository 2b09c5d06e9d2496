#![doc = include_str!("../crates/README.md")]

#[cfg(feature = "certify")]
pub use bracketry_certify as certify;
#[cfg(feature = "diagnose")]
pub use bracketry_diagnose as diagnose;
#[cfg(feature = "experiment")]
pub use bracketry_experiment as experiment;
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

pub mod prelude;

#[cfg(feature = "diagnose")]
pub use bracketry_diagnose::diagnose;
pub use bracketry_lie::analysis::{Influence, RankChange, Ranks, ReachTable, Reached};
pub use bracketry_lie::{Analysis, AnalysisError, analyze};
#[cfg(feature = "control")]
pub use bracketry_mpc::{ControlError, Controlled, control, control_watched};
#[cfg(feature = "report")]
pub use bracketry_report::analysis::{AffinizationReport, InputChange};
#[cfg(feature = "report")]
pub use bracketry_report::{Diagnosis, Figure, friction_bands, friction_colors};
#[cfg(feature = "simulate")]
pub use bracketry_sim::{
    Breakdown, ExactPlant, SampledScenario, Scenario, ScenarioError, ScenarioRun, SensorError, simulate,
};
pub use bracketry_system::{PointError, System, point};

/// Programs in the documents of the repository are tested with those of the crate.
#[cfg(all(doctest, feature = "report"))]
mod documents {
    #[doc = include_str!("../README.md")]
    struct Readme;
    #[doc = include_str!("../docs/getting_started.md")]
    struct GettingStarted;
    #[doc = include_str!("../docs/tutorial.md")]
    struct Tutorial;
    #[doc = include_str!("../docs/mpc.md")]
    struct Mpc;
    #[doc = include_str!("../docs/live.md")]
    struct Live;
    #[doc = include_str!("../docs/certify.md")]
    struct Certify;
    #[doc = include_str!("../docs/diagnose.md")]
    struct Diagnose;
    #[doc = include_str!("../docs/parameters.md")]
    struct Parameters;
    #[doc = include_str!("../docs/export.md")]
    struct Export;
    #[doc = include_str!("../docs/from_rest.md")]
    struct FromRest;
    #[doc = include_str!("../docs/identifiability.md")]
    struct Identifiability;
}
