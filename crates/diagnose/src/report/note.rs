//! What else the reader of a report should know.

use super::reason::{Mispredicted, OtherHold};
use crate::effect::Cause;
use crate::extend::OutsideDelay;
use crate::read::Warning;

/// What else the reader of a report should know.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// A record holds the same data as an earlier one and is left out.
    Repeated {
        /// The record.
        record: String,
        /// The earlier one.
        first: String,
        /// Where the two were given.
        place: Repetition,
    },
    /// Samples of a record stand alone, far from their neighbors.
    Outliers {
        /// The record.
        record: String,
        /// What was seen, a [`Warning::Outliers`].
        warning: Warning,
    },
    /// The noise of a column is another than the column alone shows.
    NoiseOfColumn {
        /// The column.
        column: String,
        /// Its noise as the residual says, in the unit of the column.
        std: f64,
        /// The same over what the column alone shows.
        factor: f64,
    },
    /// Curves through the samples of the inputs take the place of straight lines; the share of the excess that stays.
    Curves(f64),
    /// The search ended with as many causes as were allowed, and structure remains.
    MostCauses {
        /// How many there are.
        causes: usize,
        /// How many were allowed.
        allowed: usize,
    },
    /// Where the model is wrong cannot be shown: no equation can be evaluated on the data.
    NoPlaces,
    /// There is no force error: no equation can be evaluated on the data.
    NoForceError,
    /// A number stopped at the limit of its range.
    AtLimit {
        /// Its name.
        name: String,
        /// The limit.
        value: f64,
        /// Whether in the model without causes.
        without_causes: bool,
    },
    /// Parameters that keep their values, by the model file or by the settings.
    Fixed(Vec<String>),
    /// Numbers that the data hardly tell; they have no interval.
    HardlyIdentifiable(Vec<String>),
    /// Numbers that the data tell only in combination with others; they have no interval.
    OnlyInCombination(Vec<String>),
    /// Numbers without an interval, because resamples of the windows hardly differ in them.
    NoInterval(Vec<String>),
    /// What the extended model's equations cannot say.
    ExtendedModel(OutsideDelay),
    /// Only parameters are wrong, so that the gain compares with the model as given.
    OnlyParameters,
    /// Horizons that were asked for and are longer than the held-out data, s.
    HorizonsTooLong(Vec<f64>),
    /// The data are too short to measure the gain on a part of their own.
    TooShortForGain,
    /// What longer windows left unexplained has a cause in these.
    ShorterWindows {
        /// Their length, s.
        seconds: f64,
        /// Length of the windows before, s.
        used: f64,
    },
    /// The search for causes ended at its time limit.
    TimeLimit {
        /// The limit, s.
        seconds: f64,
        /// Fits that were not made, or not to their end, at least.
        left_out: u64,
    },
    /// The search for causes was asked to end.
    Interrupted {
        /// Fits that were not made, or not to their end, at least.
        left_out: u64,
    },
    /// Measured columns that are not significant above their noise.
    StillColumns(Vec<String>),
    /// Inputs that continue otherwise between samples explain the data without any cause.
    OtherHold(OtherHold),
    /// A run for validation is mispredicted.
    Mispredicted(Mispredicted),
}

/// Where the same data were given twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repetition {
    /// Both among the data of the fit.
    InFit,
    /// For validation, and among the data of the fit.
    FitAndValidation,
    /// Both for validation.
    InValidation,
}

/// What is odd about a cause or its values.
#[derive(Clone, Debug, PartialEq)]
pub enum Flag {
    /// A coefficient of Stribeck's law may take away all friction at rest: what is there is no dry friction.
    NoFrictionAtRest(String),
    /// A coefficient of Stribeck's law is negative: friction rises from rest instead of falling.
    RisingFriction(String),
    /// A coefficient has the sign that physics does not want.
    Unphysical {
        /// Its name.
        name: String,
        /// Whether it should lie above its nominal value.
        above: bool,
        /// The nominal value.
        nominal: f64,
    },
    /// A delay is counted beyond the hold of the inputs.
    BeyondHold {
        /// Half a sampling time, s.
        half: f64,
        /// Both together, s.
        all: f64,
    },
    /// A parameter stopped at a limit: beyond it, the cause may not be needed.
    ParameterAtLimit(String),
    /// A cause is smaller than what remains without a name, of which it may be the image.
    SmallerThanUnknown(Cause),
    /// A small cause that the data do not tell from others of another kind.
    OneOfSeveralKinds(Cause),
    /// What has changed during the run.
    Jumped {
        /// Its name.
        name: String,
        /// Value before the change.
        from: f64,
        /// Value after it.
        to: f64,
        /// Time of the change, s.
        at: f64,
    },
    /// A delay is half the sampling time.
    HalfSample {
        /// Whether the inputs were read as straight lines.
        lines: bool,
    },
}

/// How well a rival explains the data compared with the cause that was chosen, in units of the scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Closeness {
    /// Equally well.
    Equal,
    /// Better by so many units, but less simply.
    Better(f64),
    /// Worse by so many units only.
    Worse {
        /// The units.
        by: f64,
        /// Those that would rule it out.
        margin: f64,
    },
    /// It leaves only slightly more, compared with what no cause explains.
    LittleMore,
}
