//! Why a data set cannot be used, or says nothing about what was asked.

use super::spring_parameter::SpringParameter;
use crate::error::StiffnessError;
use std::fmt;

/// Entries of a wrench.
pub(super) const WRENCH_ENTRIES: [&str; 6] = ["force x", "force y", "force z", "moment x", "moment y", "moment z"];

/// Where a measurement stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Its number among the measurements, from 1.
    Row(usize),
    /// Its line in a file, from 1.
    Line(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Row(row) => write!(f, "row {row}"),
            Self::Line(line) => write!(f, "line {line}"),
        }
    }
}

/// A direction of loads without a load larger than its noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unloaded {
    /// An entry of the wrench, from 0.
    Axis(usize),
    /// A combination of entries, each in units of its noise.
    Combination([f64; 6]),
    /// Some direction, in which the loads move the tool no more than noise does.
    Unknown,
}

impl fmt::Display for Unloaded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const AXES: [&str; 3] = ["x", "y", "z"];
        match self {
            Self::Axis(entry @ 0..3) => write!(f, "no force along {}", AXES[*entry]),
            Self::Axis(entry) => write!(f, "no moment about {}", AXES[entry % 3]),
            Self::Combination(entries) => {
                let terms = entries.iter().enumerate().filter(|(_, v)| v.abs() > 0.2);
                let terms: Vec<String> = terms.map(|(i, v)| format!("{v:+.2} {}", WRENCH_ENTRIES[i])).collect();
                write!(f, "no combination {} (in units of their noise)", terms.join(" "))
            }
            Self::Unknown => f.write_str("in some direction, the displacements under load are within the noise"),
        }
    }
}

/// Why nothing is identified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentificationError {
    /// Robot, springs or a load that do not fit.
    #[error(transparent)]
    Robot(#[from] StiffnessError),
    /// A number that is not finite.
    #[error("{row}, {column}: {value} is not a finite number; correct or remove it")]
    NotFinite {
        /// Where.
        row: Place,
        /// Column.
        column: String,
        /// The number.
        value: f64,
    },
    /// A row of another length.
    #[error("{row}: {found} {what}, expected {expected}")]
    Count {
        /// Where.
        row: Place,
        /// What is counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// Not enough measurements.
    #[error("{found} measurements; {what} needs at least {needed}")]
    TooFew {
        /// What needs them.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// The same row twice, which measured data never contain.
    #[error("{row} equals {first} in every digit; a copy adds no information: remove it")]
    Repeated {
        /// The later one.
        row: Place,
        /// The earlier one.
        first: Place,
    },
    /// More than a robot bends or bears.
    #[error(
        "{row}: a {what} of {value:.3e} {unit} is more than a robot deforms or carries (limit {limit:e} {unit}); correct or \
         remove it"
    )]
    Implausible {
        /// Where.
        row: Place,
        /// Translation, rotation, force or moment.
        what: &'static str,
        /// Its size.
        value: f64,
        /// The largest accepted.
        limit: f64,
        /// Unit of both.
        unit: &'static str,
    },
    /// Sizes that no robot has.
    #[error("{what} is {value:.3e} {unit} in the median, which {} for robots; {remedy}", between(*low, *high))]
    Units {
        /// What was computed.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Smallest plausible value.
        low: f64,
        /// Largest plausible value.
        high: f64,
        /// Its unit.
        unit: &'static str,
        /// Which units may have been mixed up.
        remedy: &'static str,
    },
    /// Displacements against their loads.
    #[error(
        "{found} of {of} loads push in one direction and the robot moves in the other; change the sign of all forces and moments: the \
         wrench is what acts on the robot, not what the robot exerts"
    )]
    Sign {
        /// Measurements whose load takes work out of the robot, by more than noise.
        found: usize,
        /// All measurements.
        of: usize,
    },
    /// Numbers in another unit or with another sign, as the fit of joint springs tells.
    #[error(
        "{what}: the median residual of the joint springs is {found:.1} σ as given, {changed:.1} σ with this change; \
         {remedy}"
    )]
    Convention {
        /// What seems wrong.
        what: &'static str,
        /// Middle residual of the data as they are, in units of their noise.
        found: f64,
        /// The same of the changed data.
        changed: f64,
        /// What to do.
        remedy: &'static str,
    },
    /// A part of the displacements that was not measured.
    #[error(
        "all {what} are exactly 0, which is not plausible for measurements: give the measured values; if they were not \
         measured, set their noise to {least} or more"
    )]
    Zero {
        /// Translations or rotations.
        what: &'static str,
        /// Standard deviation (m, rad) from which on they count for nothing.
        least: f64,
    },
    /// A load that moved nothing at all.
    #[error(
        "{row}: a displacement of exactly 0 under a load, in {found} of {of} measurements; give what was measured, or remove them"
    )]
    Unmoved {
        /// The first of them.
        row: Place,
        /// How many there are.
        found: usize,
        /// All measurements.
        of: usize,
    },
    /// A noise that is none.
    #[error(
        "the covariance of the {what} is not symmetric positive definite, or its standard deviations are not between 1e-12 \
         and 1e6"
    )]
    Noise {
        /// Displacement or wrench.
        what: &'static str,
    },
    /// Measurements at several poses given to an estimator for one.
    #[error(
        "{row} is at a different pose from {first} (joint {joint} differs by {by:.3e}); a Cartesian stiffness belongs to one \
         pose: select the measurements of one, or fit joint springs"
    )]
    PosesDiffer {
        /// Where.
        row: Place,
        /// The first measurement.
        first: Place,
        /// Joint from 1.
        joint: usize,
        /// Difference in rad or m.
        by: f64,
    },
    /// Loads that leave out a direction.
    #[error("the loads do not determine the stiffness: {}; add loads in these directions, larger than the sensor's \
             noise, or check the units", joined(.directions))]
    NotLoaded {
        /// What was never loaded.
        directions: Vec<Unloaded>,
    },
    /// More outliers than an error of measurement explains.
    #[error(
        "{found} of {of} measurements contradict the model, too many to be outliers: check the model, the units, and \
         the noise"
    )]
    TooManyOutliers {
        /// Measurements beyond the threshold.
        found: usize,
        /// All measurements.
        of: usize,
    },
    /// Parameters that the data do not tell.
    #[error("not identified by these poses and loads: {}", joined(.parameters))]
    NotIdentified {
        /// Which, and why.
        parameters: Vec<SpringParameter>,
    },
    /// A robot that has nothing to fit.
    #[error("not identified by these poses and loads: the robot has no joints")]
    NoJoints,
    /// A start from which logarithms cannot be taken.
    #[error("joint {joint}: the start of {name} is {value}; it is fitted as a logarithm and must start above 0")]
    Start {
        /// Joint from 1.
        joint: usize,
        /// Parameter.
        name: &'static str,
        /// Its start.
        value: f64,
    },
    /// The fit did not settle.
    #[error(
        "the fit did not converge in {iterations} iterations; start closer or remove parameters that the data do not \
         determine"
    )]
    NotConverged {
        /// Iterations made.
        iterations: usize,
    },
}

impl IdentificationError {
    /// The same about a file, whose `lines` the measurements stand in.
    #[must_use]
    pub fn in_file(mut self, lines: &[u64]) -> Self {
        let move_to_line = |place: &mut Place| {
            if let Place::Row(row) = *place
                && let Some(line) = row.checked_sub(1).and_then(|i| lines.get(i))
            {
                *place = Place::Line(*line);
            }
        };
        match &mut self {
            Self::Repeated { row, first } | Self::PosesDiffer { row, first, .. } => {
                move_to_line(row);
                move_to_line(first);
            }
            Self::NotFinite { row, .. }
            | Self::Count { row, .. }
            | Self::Implausible { row, .. }
            | Self::Unmoved { row, .. } => move_to_line(row),
            _ => {}
        }
        self
    }
}

fn joined(list: &[impl fmt::Display]) -> String {
    list.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// A range in words.
fn between(low: f64, high: f64) -> String {
    if low > 0.0 { format!("lies between {low:e} and {high:e}") } else { format!("is at most {high}") }
}
