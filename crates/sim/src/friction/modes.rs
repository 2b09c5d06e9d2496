//! Stick and slip: the modes of switches, and their changes.
//!
//! A switch is a set-valued sign `s ∈ Sgn(σ)` (or a unit vector `s ∈ σ/|σ|`) of a switching function `σ(t, x)`. It *slides* while
//! `σ ≠ 0` and *sticks* while `σ` stays zero, held there by the `s` that solves `σ̇ = 0`. It stops sticking when that `s`
//! leaves `[−1, 1]` (the unit ball).

use serde::{Deserialize, Serialize};

/// What one switch does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum FrictionMode {
    /// `σ > 0`, `s = +1`.
    Positive,
    /// `σ < 0`, `s = −1`.
    Negative,
    /// A unit vector with `σ ≠ 0`, `s = σ/|σ|`.
    Sliding,
    /// `σ = 0` stays so, by an `s` in `[−1, 1]`, or in the unit ball.
    Sticking,
}

impl FrictionMode {
    /// `+1`, `−1`, and 0 for sticking and for unit vectors.
    pub fn sign(self) -> f64 {
        match self {
            FrictionMode::Positive => 1.0,
            FrictionMode::Negative => -1.0,
            FrictionMode::Sliding | FrictionMode::Sticking => 0.0,
        }
    }

    /// The mode of a switching function of this sign that slides.
    ///
    /// ```
    /// use bracketry_sim::FrictionMode;
    /// assert_eq!(FrictionMode::of_sign(-0.3), FrictionMode::Negative);
    /// assert_eq!(FrictionMode::of_sign(-0.3).opposite().sign(), 1.0);
    /// ```
    pub fn of_sign(sign: f64) -> Self {
        if sign < 0.0 { FrictionMode::Negative } else { FrictionMode::Positive }
    }

    /// The mode of the other side of `σ = 0`; what sticks and what is a unit vector stays.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            FrictionMode::Positive => FrictionMode::Negative,
            FrictionMode::Negative => FrictionMode::Positive,
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
    pub from: FrictionMode,
    /// Mode after.
    pub to: FrictionMode,
}

/// A time interval during which a switch keeps its mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModeInterval {
    /// Start in seconds.
    pub from: f64,
    /// End in seconds.
    pub to: f64,
    /// The mode.
    pub mode: FrictionMode,
}
