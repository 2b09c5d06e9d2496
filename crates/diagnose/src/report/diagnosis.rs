//! What a diagnosis found, as data.

use std::fmt;

use bracketry_symbolic::Named;
use bracketry_system::Quantities;
use serde::Serialize;

use super::columns::{ColumnFault, Rescaling};
use super::note::{Closeness, Flag, Note};
use super::reason::VerdictReason;
use super::regime::Regime;
use crate::effect::Cause;
use crate::effort::Effort;
use crate::extend::ExtendedModel;
use crate::formula::Formula;
use crate::gain::{Gain, HeldOut};
use crate::numbers::{measured, significant};
use crate::read::Audit;
use crate::study::{Fit, Windows};

/// What a diagnosis ended with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model lacks something that has a name, or a parameter is wrong by more than its tolerance.
    CauseFound,
    /// What the model lacks is a term without a name in the library.
    UnknownTerm,
    /// Terms explain a part of the residual, but held-out data are predicted so little better that they have no name.
    PartlyExplained,
    /// What explains the data of the fit predicts held-out data no better than the model without it.
    NoGain,
    /// The residual of the refitted model is noise.
    NothingFound,
    /// The residual of the refitted model is more than noise, and no candidate explains it.
    Unexplained,
    /// No measured column is significant above its noise: the data are not informative.
    Uninformative,
    /// With the other sign of a column, the residual is noise.
    WrongSign,
    /// With another unit of a column, the residual is noise.
    WrongUnit,
    /// With two columns exchanged, the residual is noise.
    SwappedColumns,
    /// With a column as a measurement of another quantity, the residual is noise.
    WrongColumn,
}

/// A number with its uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Value {
    /// The estimate.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
    /// The interval that holds the true value with 95 % probability, from resampling windows; absent where it was not made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// Unit; may be empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
}

/// Something that the experiment cannot tell from a cause.
#[derive(Clone, Debug, PartialEq)]
pub struct Rival {
    /// Its name.
    pub name: Cause,
    /// The state, input or measured column that it acts on.
    pub equation: String,
    /// The formula for the reader.
    pub term: Formula,
    /// Why it cannot be ruled out.
    pub closeness: Closeness,
}

/// A cause of what the model gets wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCause {
    /// Its name.
    pub name: Cause,
    /// The state, input or measured column that it acts on.
    pub equation: String,
    /// The formula for the reader, in the names of the model and of `parameters`.
    pub term: Formula,
    /// Its parameters by name; for [`Cause::ParameterError`] the parameter of the model.
    pub parameters: Named<Value>,
    /// Probability of such an improvement by chance, corrected for the number of candidates; absent where some of the data cannot be
    /// simulated without the cause.
    pub p_value: Option<f64>,
    /// Names that this experiment cannot tell from it, without repetition.
    pub confusable_with: Vec<Cause>,
    /// What to measure in order to tell them apart; empty if there is nothing to tell apart.
    pub separating_experiment: String,
    /// The same causes as in `confusable_with`, each with its place and the reason.
    pub rivals: Vec<Rival>,
    /// Share of the excess error on held-out data that this cause alone takes away from the model with the other causes.
    pub share: Option<f64>,
    /// What is odd about the values, as a negative friction coefficient; empty if nothing is.
    pub flags: Vec<Flag>,
    /// Of parameters that the data determine only in combination: that combination.
    pub combination: Option<Combination>,
}

/// A combination of parameters that the data determine although they do not determine each parameter (a base parameter), and that has left
/// its tolerance: the sum of the relative changes of the parameters, with weights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Combination {
    /// The weights by parameter, the largest first; the absolute values of all add up to 1, so that parameters within their tolerance change
    /// the sum by no more than that.
    pub weights: Named<f64>,
    /// The sum.
    pub change: f64,
    /// Its standard deviation.
    pub std: f64,
    /// The tolerance.
    pub tolerance: f64,
    /// Residual of the model as given over the noise; absent where it cannot be simulated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_given: Option<f64>,
    /// Parameters of which one alone, all others as given, explains the data as well, with its value.
    pub alone: Named<Value>,
}

/// Where the refitted model is wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The state in whose time derivative the error acts, or the measured column.
    pub equation: String,
    /// When.
    pub regime: Regime,
    /// Share of the excess error.
    pub share: f64,
    /// Share of the samples of the equation: an error that is alike everywhere has the same share of both.
    pub time: Option<f64>,
}

/// What the equation of a state misses over time, measured minus modeled rate: of a velocity, the force per mass that is missing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualAcceleration {
    /// Name of the record.
    pub record: String,
    /// The state.
    pub equation: String,
    /// Bandwidth of the derivatives, Hz.
    pub bandwidth_hz: f64,
    /// Standard deviation of the values by noise of the sensor, in their unit.
    pub std: f64,
    /// Times in seconds.
    #[serde(rename = "t")]
    pub times: Vec<f64>,
    /// What is missing, in the unit of the state over seconds.
    #[serde(rename = "value")]
    pub values: Vec<f64>,
}

/// A parameter of the given model, refitted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RefittedParameter {
    /// Its name.
    #[serde(skip)]
    pub name: String,
    /// Value in the model file.
    pub before: f64,
    /// Value in the final fit.
    pub after: f64,
    /// Standard deviation of `after`.
    pub std: f64,
    /// The interval that holds the true value with 95 % probability, from resampling windows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// Unit; may be empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
}

/// One explanation that was tried, in the order of merit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Its name.
    pub name: Cause,
    /// The state, input or measured column that it acts on.
    pub equation: String,
    /// The formula for the reader.
    pub term: Formula,
    /// Share of the excess error that it takes away, from 0 to 1; absent where the residual of the refitted model is noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// The interval of 95 % for `share`, from resampling windows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// Probability of such an improvement by chance, corrected for the number of candidates.
    pub p_value: f64,
    /// Whether it is among the causes.
    pub chosen: bool,
}

/// Size of a model's residual, in units of the noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Excess {
    /// Root mean square of residual over noise, 1 for noise alone: the given model with its parameters refitted.
    pub refitted: f64,
    /// The same for the extended model; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extended: Option<f64>,
    /// Probability of a residual like the refitted model's if there were only noise.
    pub p_value: f64,
}

/// The result of a diagnosis.
#[derive(Clone, Debug)]
pub struct Report {
    /// Name of the model.
    pub model: String,
    /// Units and labels of the model.
    pub quantities: Quantities,
    /// How it ended.
    pub verdict: Verdict,
    /// Why.
    pub reason: VerdictReason,
    /// What the model lacks, the most important first.
    pub causes: Vec<NamedCause>,
    /// Where the refitted model is wrong, the largest share first.
    pub places: Vec<Place>,
    /// The same by acceleration, position, and tilt: regimes of one kind add up to the share of their equation.
    pub regimes: Vec<Place>,
    /// What the equations of the refitted model miss over time.
    pub residual_acceleration: Vec<ResidualAcceleration>,
    /// What the extended model is worth; absent where there is none or the data were too short to tell.
    pub gain: Option<Gain>,
    /// The refitted parameters by name, in the order of the model.
    pub parameters: Vec<RefittedParameter>,
    /// Residual against noise.
    pub excess: Option<Excess>,
    /// What was tried, the best first.
    pub candidates: Vec<Candidate>,
    /// What was noticed in the data, one per record that was read from columns.
    pub data: Vec<Audit>,
    /// The windows in which the model was fitted; absent where it was not.
    pub windows: Option<Windows>,
    /// What else the reader should know.
    pub notes: Vec<Note>,
    /// What it cost, in counts.
    pub effort: Effort,
    /// Time that it took.
    pub seconds: f64,
    /// The fits behind the report, for files and figures.
    pub evidence: Evidence,
}

/// The given model with a rival in the place of a cause, fitted to the same data.
#[derive(Clone, Debug)]
pub struct RivalModel {
    /// The cause.
    pub cause: Cause,
    /// The rival.
    pub rival: Cause,
    /// The model.
    pub model: ExtendedModel,
}

/// What files and figures are made from.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    /// The fit of the given model's parameters; residuals are not kept.
    pub refitted: Option<Fit>,
    /// The fit with the causes; residuals are not kept.
    pub extended: Option<Fit>,
    /// The extended model.
    pub model: Option<ExtendedModel>,
    /// The model extended by a rival in the place of a named cause: the best one of every other name.
    pub rivals: Vec<RivalModel>,
    /// What figures of the gain are made from.
    pub held_out: Option<HeldOut>,
}

impl Verdict {
    /// Whether there are causes with which the model is extended.
    pub fn extends_the_model(self) -> bool {
        matches!(self, Self::CauseFound | Self::UnknownTerm | Self::PartlyExplained)
    }

    /// Whether this is an answer; otherwise the reason says what to do next.
    pub fn is_conclusive(self) -> bool {
        matches!(self, Self::CauseFound | Self::UnknownTerm | Self::NothingFound)
    }

    /// That of columns which are read wrongly.
    pub(crate) fn of_columns(fault: &ColumnFault) -> Self {
        match fault {
            ColumnFault::Scaled { by: Rescaling::Sign, .. } => Self::WrongSign,
            ColumnFault::Scaled { .. } => Self::WrongUnit,
            ColumnFault::Swapped { .. } => Self::SwappedColumns,
            ColumnFault::OtherQuantity { .. } => Self::WrongColumn,
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::CauseFound => "cause found",
            Verdict::UnknownTerm => "unknown term",
            Verdict::PartlyExplained => "partly explained",
            Verdict::NoGain => "no gain",
            Verdict::NothingFound => "nothing found",
            Verdict::Unexplained => "unexplained",
            Verdict::Uninformative => "uninformative data",
            Verdict::WrongSign => "wrong sign",
            Verdict::WrongUnit => "wrong unit",
            Verdict::SwappedColumns => "swapped columns",
            Verdict::WrongColumn => "wrong column",
        })
    }
}

impl fmt::Display for Value {
    /// `0.520 ± 0.010 kg/s (95 %: 0.50 … 0.54)`; `1 (as a whole, not fitted)` of a term that is there or not.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.std == 0.0 && self.interval == Some([self.value; 2]) {
            return write!(f, "{} (whole term, not fitted)", self.value);
        }
        write!(f, "{} ± {}", measured(self.value, self.std), significant(self.std, 2))?;
        if !self.unit.is_empty() {
            write!(f, " {}", self.unit)?;
        }
        match self.interval {
            Some([low, high]) => write!(f, " (95 %: {} … {})", measured(low, self.std), measured(high, self.std)),
            None => Ok(()),
        }
    }
}
