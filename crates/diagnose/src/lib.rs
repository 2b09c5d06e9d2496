//! Finds what a model lacks from measured data: named causes, the extended model, the improvement.
//!
//! A [`Record`] is one run of the real thing. The model's parameters are fitted to it anew, then what remains between
//! measurement and simulation is put against a library of [`Effect`]s, each a change of the model with parameters of its own.
//!
//! ```
//! use bracketry_diagnose::{Cause, Record, RecordSettings, DiagnosisSettings, diagnose};
//! use bracketry_system::System;
//! // The model of a cart knows no friction; the cart has some: v' = u − 0.8 v.
//! let text = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u' }";
//! let model = System::parse("cart.toml", text).unwrap();
//! let (mut x, mut v, mut columns) = (0.0, 0.0, [vec![], vec![], vec![], vec![]]);
//! for k in 0..400 {
//!     let t = 0.02 * f64::from(k);
//!     let u = (1.3 * t).sin() + 0.6 * (4.1 * t).cos();
//!     columns.iter_mut().zip([t, x, v, u]).for_each(|(column, value): (&mut Vec<f64>, f64)| column.push(value));
//!     // The exact solution over a sample with the input held.
//!     let (decay, rest) = ((-0.8_f64 * 0.02).exp(), u / 0.8);
//!     x += rest * 0.02 + (v - rest) * (1.0 - decay) / 0.8;
//!     v = rest + (v - rest) * decay;
//! }
//! let [t, x, v, u] = columns;
//! let columns = [("x", x), ("v", v), ("u", u)].map(|(name, values)| (name.to_owned(), values)).into();
//! let record = Record::from_columns("run 1", t, columns, &model, &RecordSettings::default()).unwrap();
//! let report = diagnose(&model, &[record], &[], &DiagnosisSettings::default(), &mut |_| ()).unwrap();
//! assert_eq!(report.causes[0].name, Cause::ViscousFriction);
//! ```

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
mod signal;
mod study;
mod verdict;

pub use bracketry_sim::{Bandwidth, SmoothingSpline, smooth};
pub use effect::{Cause, Change, Coefficient, Effect, HiddenState, Path, Role};
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
pub use record::Record;
pub use report::{
    Candidate, Caveat, Closeness, ColumnFault, Combination, Doubt, Evidence, Excess, Flag, Mispredicted, NamedCause,
    NoMotion, Note, OtherHold, OtherUnit, Outcome, Place, RefittedParameter, Regime, Repetition, Report, Rescaling,
    ResidualAcceleration, Rival, RivalModel, ScaledColumn, SmallGain, TemperatureScale, Value, Verdict, VerdictReason,
};
pub use settings::{
    AlarmSettings, ColumnSettings, ConsistencySettings, DecimationSettings, DiagnosisSettings, EquationSettings,
    GainSettings, JumpSettings, LibrarySettings, NamingSettings, NoiseSettings, OutlierSettings, PeriodSettings,
    PlaceSettings, PredictionSettings, PriorSettings, ReadSettings, RepairSettings, RivalSettings, SearchSettings,
    SelectionSettings, SignalSettings, SolverSettings, StudySettings, TimeScaleSettings, VerdictSettings,
    WindowSettings,
};
pub use signal::{Measured, Quantity, Signal};
pub use study::{
    Column, Estimate, Fit, FitStatus, Linearization, Normal, Predictor, Study, Window, WindowFit, WindowLength, Windows,
};
pub use verdict::{Stage, diagnose};
