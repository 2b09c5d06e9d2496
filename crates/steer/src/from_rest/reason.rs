//! Why there is no answer.

use serde::Serialize;

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "reason")]
pub enum FromRestReason {
    /// No state is a coordinate: one whose rate vanishes at rest whatever the inputs.
    NoCoordinates,
    /// No dry friction acts on a velocity.
    NoFriction,
    /// Inputs act with a delay.
    Delays,
    /// The model in affine form has other inputs.
    Inputs,
    /// The point is not a rest state: friction does not hold it there with the inputs at their values.
    NotAtRest,
    /// A sign of something else than velocities.
    OtherSwitch {
        /// The switching function.
        name: String,
    },
    /// The loops that were tried do not positively span the coordinates.
    Loops {
        /// Loops that were tried.
        tried: usize,
    },
    /// The displacements of full loops positively span the coordinates, but not those of shorter ones, and no loops were found that
    /// lead back.
    NoReturn,
    /// The time limit was reached, or it was asked to stop.
    Stopped,
}

impl std::fmt::Display for FromRestReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoCoordinates => write!(f, "no state keeps its value at rest whatever the inputs"),
            Self::NoFriction => {
                write!(f, "no dry friction acts on a velocity: the other verdicts on controllability apply")
            }
            Self::Delays => write!(f, "inputs act with a delay: analyze the model without it"),
            Self::Inputs => write!(f, "the model with integrators in front of the inputs has other inputs"),
            Self::NotAtRest => {
                write!(f, "friction is not shown to hold the state at the point; choose a point at rest")
            }
            Self::OtherSwitch { name } => write!(f, "the equations switch with {name}, which is not a velocity"),
            Self::Loops { tried } => {
                write!(f, "the displacements of {tried} loops do not positively span the coordinates; try wider bounds")
            }
            Self::NoReturn => write!(
                f,
                "the displacements of full loops positively span the coordinates, but those of shorter ones do not, and no loops \
                 lead back; try other bounds"
            ),
            Self::Stopped => write!(f, "the time limit was reached"),
        }
    }
}
