//! How a simulation with area contact ended.

/// How a simulation with area contact ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AreaOutcome {
    /// It reached the end time.
    Finished,
    /// The center of pressure reached the rim: the object starts to tip there.
    Tipping {
        /// When, in s.
        t: f64,
        /// Where on the rim, from the centroid, plate axes, in m.
        at: [f64; 2],
        /// Normal force in N.
        normal: f64,
    },
    /// The plate would have to pull: the object lifts off.
    LiftOff {
        /// When, in s.
        t: f64,
    },
    /// The state or the plate's motion is no longer finite.
    NotFinite {
        /// The last time at which it was, in s.
        t: f64,
    },
}

impl std::fmt::Display for AreaOutcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Finished => write!(f, "the end time was reached"),
            Self::Tipping { t, at: [x, y], normal } => write!(
                f,
                "at {t} s the object starts to tip over its rim at ({x}, {y}) m from its center, normal force {normal} N"
            ),
            Self::LiftOff { t } => write!(f, "at {t} s the object lifts off the plate"),
            Self::NotFinite { t } => write!(f, "after {t} s the state or the motion of the plate is not finite"),
        }
    }
}

impl AreaOutcome {
    /// Whether the end time was reached.
    pub fn is_finished(&self) -> bool {
        matches!(self, AreaOutcome::Finished)
    }
}
