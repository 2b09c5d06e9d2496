//! Effects: changes of a model that may explain what it gets wrong.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::formula::Formula;

/// Names of causes, as reports print them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)]
pub enum Cause {
    ViscousFriction,
    CoulombFriction,
    StribeckFriction,
    QuadraticDrag,
    Leak,
    QuadraticLoss,
    FrictionAsymmetry,
    AnisotropicFriction,
    PressureRadius,
    ConstantBias,
    Tilt,
    LinearStiffness,
    CubicStiffness,
    InputGain,
    InputDelay,
    ActuatorLag,
    SensorDelay,
    SensorLag,
    SensorBias,
    SensorDrift,
    DeadZone,
    Saturation,
    PeriodicDisturbance,
    InertialCoupling,
    JointCoupling,
    YawFriction,
    FrictionCoupling,
    ComOffset,
    LiftOff,
    Backlash,
    ParameterError,
    ParameterJump,
    ElasticJoint,
    HiddenVibration,
    Hysteresis,
    WrongSign,
    WrongUnit,
    SwappedColumns,
    WrongColumn,
    UnknownTerm,
}

impl Cause {
    /// Its name in words: `viscous friction`, `Coulomb friction`.
    pub fn words(self) -> String {
        let mut text = String::new();
        for c in format!("{self:?}").chars() {
            if c.is_uppercase() && !text.is_empty() {
                text.push(' ');
            }
            text.extend(c.to_lowercase());
        }
        for name in ["Coulomb", "Stribeck"] {
            text = text.replace(&name.to_lowercase(), name);
        }
        text
    }
}

impl fmt::Display for Cause {
    /// As in reports: `viscous_friction`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// What a coefficient of an effect does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The effect vanishes where all its amplitudes are at their nominal value.
    Amplitude,
    /// A shape, as a Stribeck velocity or a period: without meaning while the amplitudes are zero, tried at several values.
    Shape,
}

/// A parameter that an effect adds to the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficient {
    /// Its name in the extended model, one that the model does not have yet.
    pub name: String,
    /// What it does.
    pub role: Role,
    /// Amplitudes: where the effect vanishes. Shapes: a first value.
    pub nominal: f64,
    /// A typical size, for steps and scaling; positive.
    pub scale: f64,
    /// Smallest value that the mathematics allows.
    pub min: f64,
    /// Largest value that the mathematics allows; if it is the smallest, too, the effect is there altogether or not at all.
    pub max: f64,
    /// Values to try first (shapes; delays and lags, whose response is not linear). Empty: only `nominal`.
    pub trials: Vec<f64>,
    /// +1 or −1 where physics wants (value − nominal) of that sign, 0 where both are possible.
    pub physical_sign: i8,
    /// Value at which a term of the model that this coefficient scales has the opposite sign; `None` where it scales none.
    pub sign_flipped: Option<f64>,
    /// Of a period: the state in which the effect repeats, or [`crate::TIME_INPUT`].
    pub period_of: Option<String>,
    /// Unit, as free text; may be empty.
    pub unit: String,
    /// What it is.
    pub about: String,
}

impl Coefficient {
    /// The value of a law that is there altogether or not at all: its limits are one number, which the fit does not move.
    pub(crate) fn settled(&self) -> Option<f64> {
        (self.min == self.max).then_some(self.min)
    }
}

/// An effect in a signal path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Path {
    /// Pure delay of inputs, s.
    InputDelay,
    /// First-order lag of inputs, s.
    ActuatorLag,
    /// Pure delay of measured columns, s.
    SensorDelay,
    /// First-order filter of measured columns, s.
    SensorLag,
    /// The same, computed from sample to sample.
    DigitalFilter,
    /// Offset of a measured column.
    SensorBias,
    /// Offset of a measured column that grows with the time from the start of a record, per second.
    SensorDrift,
}

/// How a model changes. Texts are expressions in the names of the model and of the effect's coefficients.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Terms added to the time derivatives of states, by name of the state.
    Terms(Vec<(String, String)>),
    /// Every occurrence of an expression in the dynamics of the named states (none: of all) is replaced by another; a
    /// component of a unit vector, as `vx/sqrt(vx^2 + vy^2)`, also where its factors stand apart in a product.
    Substitution {
        /// Names of states whose equations change; empty: all.
        states: Vec<String>,
        /// Pairs: what is replaced, by what.
        pairs: Vec<(String, String)>,
    },
    /// Rates count for more or less in the limit surface of a contact, whose friction has components `rate/sqrt(square)`: each rate
    /// is replaced by its length times itself, and the friction follows by the principle of greatest dissipation. Several such effects
    /// on one surface multiply. Where there are no lengths, a contact whose friction has no such root is left as it is.
    Stretch {
        /// What stands under the root.
        square: String,
        /// Names of the rates of the slip.
        slips: Vec<String>,
        /// Names of rates, of the slip or of a spin, with the expressions of their lengths.
        lengths: Vec<(String, String)>,
        /// Names of spins that are not under the root and take part in the slip, with the expressions of their lengths.
        spins: Vec<(String, String)>,
    },
    /// Several changes of the equations with the same coefficients.
    Several(Vec<Change>),
    /// States that no column shows, with a change of the equations that may use them.
    Hidden {
        /// The states.
        states: Vec<HiddenState>,
        /// What they do to the equations of the model.
        change: Box<Change>,
    },
    /// What is measured of a body in the plane is the motion of a point p off its center of mass c, which the equations are
    /// about: `p = c + R(angle) d`, `p' = c' + spin z × R(angle) d`; the two coefficients are d, in axes of the body.
    TrackedPoint {
        /// Names of the states of the position.
        position: [String; 2],
        /// Names of their rates.
        velocity: [String; 2],
        /// Name of the state of the angle.
        angle: String,
        /// Name of its rate.
        spin: String,
    },
    /// An effect in the path of inputs or measured columns, by name; the one coefficient is its time constant or its offset.
    Path {
        /// What.
        path: Path,
        /// Names of inputs or of measured columns.
        signals: Vec<String>,
    },
}

/// A state of an effect, with a start of its own in every window.
#[derive(Clone, Debug, PartialEq)]
pub struct HiddenState {
    /// Its name, one that the model does not have yet.
    pub name: String,
    /// Its time derivative.
    pub rate: String,
    /// The state of the model near which it starts; `None` for zero.
    pub like: Option<String>,
    /// Its typical size; where it starts near a state, that one's counts.
    pub scale: f64,
}

/// A change of the model that may explain what it gets wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Its name.
    pub cause: Cause,
    /// The state, input or measured column that it acts on.
    pub equation: String,
    /// The formula for the reader, as `-c*v`.
    pub term: Formula,
    /// Its parameters.
    pub coefficients: Vec<Coefficient>,
    /// What it does to the model.
    pub change: Change,
}

impl Effect {
    /// Whether signals come late by it: a delay, a lag, or a filter.
    pub(crate) fn is_late(&self) -> bool {
        let Change::Path { path, .. } = &self.change else { return false };
        !matches!(path, Path::SensorBias | Path::SensorDrift)
    }

    /// The states that it adds.
    pub(crate) fn hidden(&self) -> &[HiddenState] {
        if let Change::Hidden { states, .. } = &self.change { states } else { &[] }
    }

    /// Whether it is a filter of measured columns.
    pub(crate) fn is_filter(&self) -> bool {
        matches!(self.change, Change::Path { path: Path::SensorLag | Path::DigitalFilter, .. })
    }
}
