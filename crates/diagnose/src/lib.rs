//! From measured data to what a model gets wrong: the cause by name, the extended model, the gain.
//!
//! A [`Record`] is one run of the real thing. The model's parameters are fitted to it anew, then what remains between
//! measurement and simulation is put against a library of [`Effect`]s, each a change of the model with parameters of its own.

mod effect;
mod effort;
mod error;
mod extend;
mod formula;
mod gain;
mod library;
mod numbers;
mod read;
mod record;
mod report;
mod settings;
mod study;
mod verdict;

pub use bracketry_sim::{Bandwidth, SmoothingSpline, smooth};
pub use effect::{Cause, Change, Coefficient, Effect, Path, Role};
pub use effort::Effort;
pub use error::DiagnoseError;
pub use extend::{ExtendedModel, OutsideDelay};
pub use formula::Formula;
pub use gain::{
    Fitted, ForceResidual, Gain, HeldOut, Predicted, bootstrap, force_error, force_residuals, measure_gain,
};
pub use library::{TIME_INPUT, candidates, dictionary, reference_candidates, separating_experiment};
pub use numbers::{measured, p_value, probability, significant};
pub use read::{Audit, ColumnAudit, Noise, RecordSettings, Warning, estimate_noise, read_record};
pub use record::{Measured, Quantity, Record, Signal};
pub use report::{
    Candidate, Caveat, Closeness, Evidence, Excess, Flag, Mispredicted, NamedCause, NoMotion, Note, OtherHold, Outcome,
    Place, Reason, RefittedParameter, Regime, Repetition, Report, Rescaling, ResidualAcceleration, Rival, ScaledColumn,
    Value, Verdict,
};
pub use settings::{
    AlarmSettings, ConsistencySettings, EquationSettings, GainSettings, LibrarySettings, NamingSettings, NoiseSettings,
    PeriodSettings, PlaceSettings, PredictionSettings, PriorSettings, ReadSettings, RivalSettings, SearchSettings,
    SelectionSettings, Settings, SignalSettings, SolverSettings, StudySettings, TimeScaleSettings, UnitSettings,
    VerdictSettings, WindowSettings,
};
pub use study::{
    Column, Estimate, Fit, FitStatus, Linearization, Normal, Predictor, Study, Window, WindowFit, WindowLength,
};
pub use verdict::{Stage, diagnose};
