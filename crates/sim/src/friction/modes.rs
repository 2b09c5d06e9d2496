//! Stick and slip: the modes of switches, and their changes.
//!
//! A switch is a set-valued sign `s ∈ Sgn(σ)` (or a unit vector `s ∈ σ/|σ|`) of a switching function `σ(t, x)`. It *slides* while
//! `σ ≠ 0` and *sticks* while `σ` stays zero, held there by the `s` that solves `σ̇ = 0`. It stops sticking when that `s`
//! leaves `[−1, 1]` (the unit ball).

use serde::{Deserialize, Serialize};

/// What one switch does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Mode {
    /// `σ > 0`, `s = +1`.
    Positive,
    /// `σ < 0`, `s = −1`.
    Negative,
    /// A unit vector with `σ ≠ 0`, `s = σ/|σ|`.
    Sliding,
    /// `σ = 0` stays so, by an `s` in `[−1, 1]`, or in the unit ball.
    Sticking,
}

impl Mode {
    /// `+1`, `−1`, and 0 for sticking and for unit vectors.
    pub fn sign(self) -> f64 {
        match self {
            Mode::Positive => 1.0,
            Mode::Negative => -1.0,
            Mode::Sliding | Mode::Sticking => 0.0,
        }
    }

    /// The mode of a switching function of this sign that slides.
    ///
    /// ```
    /// use bracketry_sim::Mode;
    /// assert_eq!(Mode::of_sign(-0.3), Mode::Negative);
    /// assert_eq!(Mode::of_sign(-0.3).opposite().sign(), 1.0);
    /// ```
    pub fn of_sign(sign: f64) -> Self {
        if sign < 0.0 { Mode::Negative } else { Mode::Positive }
    }

    /// The mode of the other side of `σ = 0`; what sticks and what is a unit vector stays.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Mode::Positive => Mode::Negative,
            Mode::Negative => Mode::Positive,
            other => other,
        }
    }
}

/// A change of mode: a switch starts to stick, breaks loose, or crosses `σ = 0`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModeChange {
    /// Time in seconds.
    pub t: f64,
    /// Index of the switch, in the order of the system.
    pub switch: usize,
    /// Mode before.
    pub from: Mode,
    /// Mode after.
    pub to: Mode,
}

/// A time interval during which a switch keeps its mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModeInterval {
    /// Start in seconds.
    pub from: f64,
    /// End in seconds.
    pub to: f64,
    /// The mode.
    pub mode: Mode,
}
