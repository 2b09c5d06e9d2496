//! Plants that look like those of published measurements, with effects that the model files lack.
//!
//! Nothing is copied from data: parameters and effects are drawn at random; positions are measured by an encoder with
//! steps and some colored noise; the motor adds colored noise that the log does not contain, so that, as with real
//! data, no model leaves a white residual.

mod measure;
mod pendulum;
mod rack;
mod servo;
mod wrist;

use bracketry::diagnose::Cause;
use rand::SeedableRng;
use rand::rngs::StdRng;

/// Which plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plant {
    /// A pendulum let go: the friction has two terms, the model none.
    FreePendulum,
    /// The same with a motor on its axis.
    DrivenPendulum,
    /// Joints 5 and 6 of a robot: the motor of joint 6 turns with the sum of both.
    Wrist,
    /// A carriage on a rack: a force that repeats with the pinion, and one more effect.
    Rack,
}

impl Plant {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::FreePendulum, Self::DrivenPendulum, Self::Wrist, Self::Rack];

    /// The file of the model that lacks the effects, in `models/`.
    pub(crate) const fn model(self) -> &'static str {
        match self {
            Self::FreePendulum => "pendulum_without_friction.toml",
            Self::DrivenPendulum => "pendulum_driven.toml",
            Self::Wrist => "wrist.toml",
            Self::Rack => "rack_and_pinion.toml",
        }
    }

    /// Two runs of one plant whose parameters and effects are drawn with the seed.
    pub(crate) fn draw(self, seed: u64) -> Drawn {
        let random = &mut StdRng::seed_from_u64(seed);
        match self {
            Self::FreePendulum => pendulum::free(random),
            Self::DrivenPendulum => pendulum::driven(random),
            Self::Wrist => wrist::wrist(random),
            Self::Rack => rack::rack(random),
        }
    }
}

/// What was drawn.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    /// The measured run, as CSV.
    pub(crate) data: String,
    /// A second run, as CSV.
    pub(crate) validate: String,
    /// The hidden effects: for each the names under which it may be found.
    pub(crate) truth: Vec<Vec<Cause>>,
    /// The true model, for the reader.
    pub(crate) true_model: String,
}
