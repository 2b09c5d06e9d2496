//! What can be wrong with a plate.

use crate::object::ShapeError;

/// What can be wrong with a plate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlateError {
    /// A length or coefficient without meaning.
    #[error("{name} = {value} must be a positive number")]
    BadNumber {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A coefficient without meaning.
    #[error("{name} = {value} must be a finite number, zero or positive")]
    NegativeNumber {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The model lacks a definition that its contact forces are read from.
    #[error("the model defines no `{name}`; use a model from first principles")]
    NoDefinition {
        /// The definition.
        name: &'static str,
    },
    /// A model that knows only objects on their whole footprint.
    #[error(
        "this model supports only objects that rest on their whole footprint about their center of mass; use the \
         model `area`"
    )]
    UnevenBearing,
    /// Static friction below sliding friction.
    #[error("mu_static = {mu_static} is below mu = {mu}; give a static friction of at least the sliding friction")]
    StaticBelowSliding {
        /// Coefficient of sliding.
        mu: f64,
        /// Coefficient of sticking.
        mu_static: f64,
    },
    /// A number of a state, or a time, that is not finite or lies in the past.
    #[error("{value} is not a valid state entry or time: states must be finite, times finite and not in the past")]
    BadState {
        /// The number.
        value: f64,
    },
    /// Equations that were not solved.
    #[error(
        "{what} was not found (relative error left: {left:.1e}); choose other numbers of points or shorter steps, and report the case"
    )]
    NotConverged {
        /// What was sought.
        what: &'static str,
        /// What is left of its equations, in units of what is balanced.
        left: f64,
    },
    /// Too few points for a footprint.
    #[error("{count} points cannot cover a footprint; ask for at least {least}")]
    TooFewPoints {
        /// How many were asked for.
        count: usize,
        /// The least number.
        least: usize,
    },
    /// A model in principal axes and a shape with others.
    #[error(
        "the principal axes of the polygon are rotated by {angle} rad against its own; rotate the vertices by the negative of this angle"
    )]
    TurnedAxes {
        /// Angle of the principal axes in rad.
        angle: f64,
    },
    /// A restitution without meaning.
    #[error("restitution = {value} must lie between 0 (no rebound) and 1 (no loss)")]
    Restitution {
        /// Its value.
        value: f64,
    },
    /// An object whose inertia underflows or overflows.
    #[error("the object's inertia is out of the range of floating-point numbers; check the units of lengths and mass")]
    Inertia,
    /// A body that starts inside the plate.
    #[error("the body starts {depth} m below the plate's surface; raise its center of mass by this amount")]
    Penetration {
        /// How far, in m.
        depth: f64,
    },
    /// Two settings of gravity for one object.
    #[error("gravity is {area} m/s² while the object lies flat and {body} m/s² otherwise; give both the same")]
    GravityDiffers {
        /// That of the settings of area contact.
        area: f64,
        /// That of the settings of the rigid body.
        body: f64,
    },
    /// The friction at contact points cannot be solved for.
    #[error(transparent)]
    Contact(#[from] bracketry_sim::ContactError),
    /// An expression of the plate's motion cannot be used.
    #[error("the plate motion `{text}`: {reason}")]
    Motion {
        /// The expression.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A number of the plate's motion that is none.
    #[error("the number {name} = {value} of the plate motion must be finite")]
    BadMotionNumber {
        /// Which one.
        name: String,
        /// Its value.
        value: f64,
    },
    /// The states of the model are not those of a plant, or the experiment moves none of them.
    #[error(
        "a plate model needs the states x, y, phi, vx, vy, w, in this order, and experiments move one of the first \
         three; `{name}` is missing"
    )]
    NoState {
        /// The state.
        name: &'static str,
    },
    /// Nothing was to be done.
    #[error("no experiment was given")]
    NoExperiment,
    /// The shape is none.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The model file cannot be read.
    #[error(transparent)]
    File(Box<bracketry_system::FileError>),
    /// The inputs do not fit the model.
    #[error(transparent)]
    Input(#[from] bracketry_sim::InputError),
    /// The state or the settings do not fit.
    #[error(transparent)]
    Sim(#[from] bracketry_sim::SimError),
    /// The optimal control problem of a move cannot be set up.
    #[error("the move cannot be set up: {reason}")]
    Move {
        /// Why.
        reason: String,
    },
}

impl From<bracketry_mpc::MpcError> for PlateError {
    fn from(error: bracketry_mpc::MpcError) -> Self {
        Self::Move { reason: error.to_string() }
    }
}

impl From<bracketry_system::FileError> for PlateError {
    fn from(error: bracketry_system::FileError) -> Self {
        Self::File(Box::new(error))
    }
}
