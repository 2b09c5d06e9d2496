//! Why a data set cannot be used, or says nothing about what was asked.

use crate::error::StiffnessError;

/// Why nothing is identified. Rows count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentificationError {
    /// Robot, springs or a load that do not fit.
    #[error(transparent)]
    Robot(#[from] StiffnessError),
    /// A number that is not finite.
    #[error("row {row}, {column}: {value} is not a finite number; correct or remove the row")]
    NotFinite {
        /// Row.
        row: usize,
        /// Column.
        column: String,
        /// The number.
        value: f64,
    },
    /// A row of another length.
    #[error("row {row}: {found} {what}, expected {expected}")]
    Count {
        /// Row.
        row: usize,
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
    #[error("row {row} is equal to row {first} in every digit; a copy adds no information: remove it")]
    Repeated {
        /// The later row.
        row: usize,
        /// The earlier one.
        first: usize,
    },
    /// More than a robot bends or bears.
    #[error(
        "row {row}: a {what} of {value:.3e} {unit} is more than a robot bends or bears (limit {limit:e} {unit}); correct or \
         remove the row"
    )]
    Implausible {
        /// Row.
        row: usize,
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
        "{found} of {of} loads push one way and the robot moves the other; change the sign of all forces and moments: the \
         wrench is what acts on the robot, not what the robot exerts"
    )]
    Sign {
        /// Measurements whose load takes work out of the robot, by more than noise.
        found: usize,
        /// All measurements.
        of: usize,
    },
    /// A noise that is none.
    #[error(
        "the covariance of the {what} is not symmetric positive definite, or its standard deviations are not between 1e-12 and 1e6"
    )]
    Noise {
        /// Displacement or wrench.
        what: &'static str,
    },
    /// Measurements at several poses given to an estimator for one.
    #[error(
        "row {row} is at another pose than row 1 (joint {joint} differs by {by:.3e}); a Cartesian stiffness belongs to one \
         pose: select the rows of one, or fit joint springs"
    )]
    PosesDiffer {
        /// Row.
        row: usize,
        /// Joint from 1.
        joint: usize,
        /// Difference in rad or m.
        by: f64,
    },
    /// Loads that leave out a direction.
    #[error("the loads do not tell the stiffness: {}; add loads in these directions, larger than the sensor's noise, or check the units", .directions.join("; "))]
    NotLoaded {
        /// What was never loaded, in words.
        directions: Vec<String>,
    },
    /// More outliers than an error of measurement explains.
    #[error(
        "{found} of {of} measurements contradict the rest; this is no matter of outliers: check the model, the units and the noise"
    )]
    TooManyOutliers {
        /// Measurements beyond the threshold.
        found: usize,
        /// All measurements.
        of: usize,
    },
    /// Parameters that the data do not tell.
    #[error("not identified by these poses and loads: {}", .parameters.join("; "))]
    NotIdentified {
        /// Which, and why.
        parameters: Vec<String>,
    },
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
        "the fit did not settle in {iterations} iterations; start closer or remove parameters that the data do not tell"
    )]
    NotConverged {
        /// Iterations made.
        iterations: usize,
    },
}

/// A range in words.
fn between(low: f64, high: f64) -> String {
    if low > 0.0 { format!("lies between {low:e} and {high:e}") } else { format!("is at most {high}") }
}
