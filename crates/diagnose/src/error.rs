//! What can be wrong with the data or the request.

use bracketry_sim::{InputError, SimError};
use bracketry_system::FileError;
use std::path::PathBuf;

/// Why a diagnosis cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum DiagnoseError {
    /// Data that cannot be used: file, line, column, remedy.
    #[error(transparent)]
    File(#[from] FileError),
    /// A simulation cannot be set up.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A simulation cannot be started.
    #[error(transparent)]
    Simulation(#[from] SimError),
    /// A file cannot be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// No record was given.
    #[error("no data were given; pass at least one record")]
    NoRecords,
    /// A record does not belong to the model.
    #[error("`{record}` has {found} {what}, but the model has {expected}; read it with this model")]
    Mismatch {
        /// The record.
        record: String,
        /// What is counted.
        what: &'static str,
        /// As many as the model has.
        expected: usize,
        /// As many as the record has.
        found: usize,
    },
    /// A record holds no measured column.
    #[error("`{record}` has no measured column; give a column for a state or an output of the model: {known}")]
    NothingMeasured {
        /// The record.
        record: String,
        /// States and outputs of the model.
        known: String,
    },
    /// The records are too short.
    #[error("{records} has no section of at least {samples} samples without a gap; record longer")]
    TooShort {
        /// Names of the records.
        records: String,
        /// Fewest samples per window.
        samples: usize,
    },
    /// Windows of a length that the data do not have.
    #[error("the data cannot be cut into windows of {length} (--window); choose {shortest:.3e} to {longest:.3e}")]
    WindowLength {
        /// The length asked for, s.
        length: f64,
        /// Duration of the fewest samples that a window may have, s.
        shortest: f64,
        /// The longest stretch without a gap, s.
        longest: f64,
    },
    /// A name that the model does not have.
    #[error("the model has no {what} `{name}`; it has {known}")]
    UnknownName {
        /// What was looked for.
        what: &'static str,
        /// The name.
        name: String,
        /// Names that exist.
        known: String,
    },
    /// An expression of an effect cannot be read.
    #[error("cannot read the term `{text}`: {message}")]
    Term {
        /// The expression.
        text: String,
        /// What is wrong.
        message: String,
    },
    /// A coefficient of an effect has a name that the model uses.
    #[error("the model already has a `{name}`; give the coefficient another name")]
    NameTaken {
        /// The name.
        name: String,
    },
    /// A substitution that finds nothing.
    #[error("`{text}` does not occur in the equations in which it is to be replaced")]
    NothingReplaced {
        /// What should be replaced.
        text: String,
    },
    /// The [`StopFlag`](bracketry_symbolic::StopFlag) of the model's pool was raised.
    #[error("the diagnosis was stopped")]
    Stopped,
    /// A setting without meaning.
    #[error("{name} is {value}, but must be {requirement}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        requirement: &'static str,
    },
    /// A window that a study does not have.
    #[error("there is no window {index}; the study has {windows}")]
    NoSuchWindow {
        /// The index asked for.
        index: usize,
        /// Number of windows.
        windows: usize,
    },
    /// Samples that a record does not have, or too few to begin from.
    #[error("record {record} has {samples} samples: there is no stretch from {from} to {to} of two or more")]
    NoSuchStretch {
        /// Index of the record.
        record: usize,
        /// First sample asked for.
        from: usize,
        /// One past the last sample asked for.
        to: usize,
        /// Samples of the record.
        samples: usize,
    },
    /// All that the model does is over between two samples.
    #[error(
        "`{record}`: the samples are {step} apart in time, in which even the slowest mode of the model completes {turns:.1} \
         cycles: model and data use different units of time; t is in the unit of time of the model: divide it by 1000 if it counts \
         milliseconds and the model seconds, by the rate if it counts samples"
    )]
    TimeScale {
        /// The record.
        record: String,
        /// Time between samples, s.
        step: f64,
        /// Turns of the slowest motion between two samples.
        turns: f64,
    },
    /// A simulation over the data takes too long.
    #[error(
        "`{record}`: a simulation takes {per_sample} steps from one sample to the next ({step} in time): the model is far faster than the \
         data; check that t is in the unit of time of the model, and the values of the parameters, or replace fast dynamics by their steady state"
    )]
    Effort {
        /// The record.
        record: String,
        /// Steps between two samples.
        per_sample: usize,
        /// Time between samples, s.
        step: f64,
    },
    /// The model cannot be simulated over any of the windows.
    #[error(
        "the model cannot be simulated over any of the {windows} windows; the first, from t = {from} s of `{record}`: \
         {reason}; {remedy}"
    )]
    NoWindow {
        /// Windows tried.
        windows: usize,
        /// Record of the first.
        record: String,
        /// Its start, s.
        from: f64,
        /// Why the simulation ended.
        reason: String,
        /// What to change.
        remedy: String,
    },
}
