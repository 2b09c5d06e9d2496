//! Bounds and points that do not fit the model.

/// Misuse.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FromRestError {
    /// A text that gives no bound.
    #[error("`{text}` is not a bound: write NAME=LOW..HIGH, such as der(X,2)=-4..4")]
    Bound {
        /// The text.
        text: String,
    },
    /// A bound of something unknown.
    #[error("`{name}` has no bounds here: give bounds of {}", .known.join(", "))]
    Unknown {
        /// The name.
        name: String,
        /// What may have bounds.
        known: Vec<String>,
    },
    /// Two bounds of the same thing.
    #[error("`{name}` has two bounds: remove one")]
    Twice {
        /// The name.
        name: String,
    },
    /// The highest derivative of an input is not bounded.
    #[error("`{name}` is not bounded: give its bounds, as in {name}=-4..4")]
    Unbounded {
        /// The derivative.
        name: String,
    },
    /// Bounds that exclude rest.
    #[error("the bounds of `{name}` exclude its value at rest, {rest}: widen them, or change the point")]
    RestOutside {
        /// The name.
        name: String,
        /// Its value at rest.
        rest: f64,
    },
    /// An axis of a map that is no bound of an input.
    #[error(
        "the axis `{name}` of the map: give an input or one of its derivatives, as in {name}=0.1..2, and at least one cell"
    )]
    Axis {
        /// The name.
        name: String,
    },
    /// A coordinate whose value at the point is no number.
    #[error("`{name}` has no finite value at the point: give one")]
    Point {
        /// The coordinate.
        name: String,
    },
    /// The model cannot be simulated.
    #[error(transparent)]
    Input(#[from] bracketry_sim::InputError),
    /// Derivatives of inputs that cannot be replaced by integrators.
    #[error(transparent)]
    Affine(#[from] bracketry_system::AffineError),
    /// The equations divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] bracketry_system::ZeroDenominator),
}
