//! Settings of a diagnosis, by stage. Every default stands beside its field, with its unit and its reason.

/// Defines structs of settings, each field with its default.
macro_rules! settings {
    ($($(#[$about:meta])* $name:ident { $($(#[$why:meta])* $field:ident: $type:ty = $default:expr,)* })*) => {$(
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $($(#[$why])* #[doc = concat!("\n\nDefault: `", stringify!($default), "`.")] pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }
    )*};
}

mod gain;
mod library;
mod read;
mod study;
mod verdict;

pub use gain::{EquationSettings, GainSettings, PredictionSettings};
pub use library::LibrarySettings;
pub use read::{ConsistencySettings, DecimationSettings, NoiseSettings, OutlierSettings, ReadSettings, RepairSettings};
pub use study::{PriorSettings, SolverSettings, StudySettings, TimeScaleSettings, WindowSettings};
pub use verdict::{
    AlarmSettings, ColumnSettings, JumpSettings, NamingSettings, PeriodSettings, PlaceSettings, RivalSettings,
    SearchSettings, SelectionSettings, SignalSettings, VerdictSettings,
};

use std::time::Duration;

use bracketry_symbolic::StopFlag;

use crate::effect::Effect;

settings! {
    /// Settings of a diagnosis.
    DiagnosisSettings {
        /// Windows and fits.
        study: StudySettings = StudySettings::default(),
        /// Values at which candidates are tried.
        library: LibrarySettings = LibrarySettings::default(),
        /// Search, selection, and verdict.
        verdict: VerdictSettings = VerdictSettings::default(),
        /// Predictions, force errors, and intervals.
        gain: GainSettings = GainSettings::default(),
        /// Most causes that are named together.
        max_causes: usize = 3,
        /// Accepted probability of a false alarm, and of a false cause; corrected for the number of candidates.
        significance: f64 = 0.01,
        /// Relative change of a parameter that is calibration; more is `parameter_error`.
        tolerance: f64 = 0.075,
        /// Seed of the resampling.
        seed: u64 = 1,
        /// Time after which the search for causes ends and what was found is reported, with what was left out; `None` for no limit.
        time_limit: Option<Duration> = None,
        /// Once it is raised, the search for causes ends as at its time limit. (The flag of the model's pool ends the diagnosis without a
        /// report.)
        end_search: StopFlag = StopFlag::default(),
        /// Effects to try in addition to those of the library.
        candidates: Vec<Effect> = Vec::new(),
    }
}
