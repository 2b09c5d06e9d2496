//! Why a diagnosis ended with its verdict.

use bracketry_sim::Hold;

use super::columns::ColumnFault;
use crate::effect::Cause;

/// Why a diagnosis ended with its verdict.
#[derive(Clone, Debug, PartialEq)]
pub struct VerdictReason {
    /// How the search for causes ended.
    pub outcome: Outcome,
    /// What speaks against it.
    pub caveats: Vec<Caveat>,
}

/// How the search for causes ended. Sizes are root mean squares over the noise, shares those of the excess over it.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// With its parameters refitted, the model leaves noise.
    Noise {
        /// Whether a parameter is off by more than its tolerance.
        parameter_off: bool,
    },
    /// The residual is correlated, but hardly larger than the noise, and no effect explains it in all parts of the data.
    Correlated {
        /// Size of the residual.
        size: f64,
        /// Whether a parameter is off by more than its tolerance.
        parameter_off: bool,
    },
    /// With the named causes the model leaves noise.
    Explained,
    /// The named causes explain a part of the excess.
    PartlyExplained {
        /// The part.
        share: f64,
        /// Size of what they leave.
        size: f64,
    },
    /// No effect explains the residual significantly, or the best ones explain too little.
    Unexplained {
        /// Size of the refitted model's residual.
        size: f64,
        /// What the best effects explain, if any is significant.
        share: Option<f64>,
    },
    /// What explains the data of the fit predicts held-out data no better.
    NotBorneOut {
        /// Size of the refitted model's residual.
        size: f64,
        /// What was explained in the data of the fit.
        share: f64,
    },
    /// The causes explain the data of the fit, but with them held-out data are predicted no better at the longest horizon, or no better than
    /// by a constant.
    NoGain {
        /// Their names.
        causes: Vec<Cause>,
        /// The errors.
        gain: SmallGain,
    },
    /// The model explains the data once columns are read otherwise.
    WrongColumns {
        /// How they are to be read.
        fault: ColumnFault,
        /// Size of the refitted model's residual with the columns as they are; `None` where it cannot be simulated.
        size: Option<f64>,
        /// The same with the columns as they are to be read.
        corrected: f64,
    },
    /// No measured column is significant above its noise.
    NoMotion(NoMotion),
}

/// What drives a device of which nothing that was measured moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoMotion {
    /// It has no inputs.
    NoInputs,
    /// No input moves.
    StillInputs,
    /// The inputs move.
    DrivenInputs,
}

/// What speaks against a verdict.
#[derive(Clone, Debug, PartialEq)]
pub enum Caveat {
    /// Inputs that continue otherwise between samples explain the data without any cause.
    OtherHold(OtherHold),
    /// A run for validation is mispredicted.
    Mispredicted(Mispredicted),
    /// Held-out data are predicted only a little better.
    SmallGain(SmallGain),
    /// Structure remains, and there is a reason to doubt the causes: they have no name.
    Doubtful(Doubt),
}

/// What makes causes doubtful where structure remains.
#[derive(Clone, Debug, PartialEq)]
pub enum Doubt {
    /// They explain too small a share of the excess.
    Share(f64),
    /// Their residual is no smaller, compared with its noise, than that without them.
    Noise {
        /// Residual over noise without them.
        before: f64,
        /// With them.
        after: f64,
    },
    /// The force error is larger with them.
    ForceError {
        /// Without them.
        before: f64,
        /// With them.
        after: f64,
    },
    /// A value of a cause stopped at a limit.
    AtLimit(String),
}

/// Errors of predictions at the longest horizon, relative to the standard deviation of what is predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallGain {
    /// The horizon, s.
    pub horizon: f64,
    /// Without the causes: of the model as given or refitted, whichever predicts better.
    pub before: f64,
    /// With the causes.
    pub after: f64,
}

/// Excess of the refitted model with the other input hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherHold {
    /// The other hold.
    pub hold: Hold,
    /// Share of the excess that stays; `None`: no more than noise is left, so that any cause may be the image of the wrong hold.
    pub stays: Option<f64>,
}

/// A run that no fit has seen and that is mispredicted.
#[derive(Clone, Debug, PartialEq)]
pub struct Mispredicted {
    /// Name of the record.
    pub record: String,
    /// Size of the residual over the noise.
    pub size: f64,
}
