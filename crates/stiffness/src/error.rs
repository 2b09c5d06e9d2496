//! What can be wrong with a robot, a pose or a load.

/// Why a deformation cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StiffnessError {
    /// A list that does not fit the robot.
    #[error("{found} {what} for a robot with {joints} joints; give one for each")]
    Count {
        /// What is counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// Joints of the robot.
        joints: usize,
    },
    /// A number that is not finite.
    #[error("{what} is {value}; give a finite number")]
    NotFinite {
        /// What it is.
        what: String,
        /// The number.
        value: f64,
    },
    /// A spring that pushes in the wrong direction or yields without limit.
    #[error("joint {joint}: {what} is {value}; it must be positive")]
    NotPositive {
        /// Number of the joint, from 1.
        joint: usize,
        /// Which number of the spring.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// The load bends the robot more than its springs can hold.
    #[error(
        "the load has no stable equilibrium near this pose: the joint stiffness minus the geometric stiffness of the load \
         is not positive definite (smallest eigenvalue {smallest:.3e} N·m/rad); reduce the load or check the stiffnesses' \
         units"
    )]
    Unstable {
        /// Smallest eigenvalue of the loaded joint stiffness.
        smallest: f64,
    },
    /// The iteration to the loaded equilibrium did not settle.
    #[error(
        "no equilibrium under the load after {iterations} iterations, last change {change:.3e} rad; reduce the load"
    )]
    NoEquilibrium {
        /// Iterations made.
        iterations: usize,
        /// Largest change of a joint in the last one.
        change: f64,
    },
    /// The robot does not get to a pose.
    #[error(
        "no joint coordinates for the pose after {iterations} iterations, {missing:.3e} m away; is it within reach?"
    )]
    NoPose {
        /// Iterations made.
        iterations: usize,
        /// Distance from the pose in m.
        missing: f64,
    },
}

/// Refuses numbers that are not finite, called `what` as a whole.
pub(crate) fn check_finite<'v>(
    what: impl std::fmt::Display,
    values: impl IntoIterator<Item = &'v f64>,
) -> Result<(), StiffnessError> {
    match values.into_iter().find(|v| !v.is_finite()) {
        Some(value) => Err(StiffnessError::NotFinite { what: what.to_string(), value: *value }),
        None => Ok(()),
    }
}

/// The same, naming the entry from 1.
pub(crate) fn check_entries(what: &str, values: &[f64]) -> Result<(), StiffnessError> {
    let mut entries = values.iter().enumerate();
    entries.try_for_each(|(i, value)| check_finite(format_args!("{what}: entry {}", i + 1), [value]))
}
