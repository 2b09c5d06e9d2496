//! Hides an effect that is chosen at random in a log of a slider and diagnoses it from its CSV and the model text alone.

use bracketry_diagnose::{HiddenEffect, Slider, SliderLog, SliderSensors, SyntheticError};
use rand::rngs::StdRng;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};

/// What may be hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// Nothing.
    Nothing,
    /// One of the basic effects.
    Any,
    /// Two of the basic effects.
    Pair,
    /// One of the further effects in the library.
    Further,
    /// One that has no name in the library.
    Outside,
    /// This one.
    Only(HiddenEffect),
}

/// One log to be diagnosed.
pub(crate) struct Trial {
    /// Everything about it follows from this number and the settings.
    pub(crate) seed: u64,
    /// What is hidden.
    pub(crate) hidden: Vec<HiddenEffect>,
    /// The experiment.
    pub(crate) slider: Slider,
}

impl Trial {
    /// Draws effects and experiment. `general`: sampling, noise, excitation and sizes at random as well.
    pub(crate) fn draw(choice: Choice, sensors: SliderSensors, size: f64, general: bool, seed: u64) -> Self {
        let mut random = StdRng::seed_from_u64(seed);
        let hidden = match choice {
            Choice::Nothing => Vec::new(),
            Choice::Any => one(&HiddenEffect::BASIC, &mut random),
            Choice::Further => one(&HiddenEffect::FURTHER, &mut random),
            Choice::Outside => one(&HiddenEffect::OUTSIDE, &mut random),
            Choice::Only(effect) => vec![effect],
            Choice::Pair => HiddenEffect::BASIC.sample(&mut random, 2).copied().collect(),
        };
        let slider = if general {
            Slider::random(sensors, &mut random)
        } else {
            Slider { size, ..Slider::basic(sensors, &mut random) }
        };
        Self { seed, hidden, slider }
    }

    /// The log.
    pub(crate) fn log(&self) -> Result<SliderLog, SyntheticError> {
        self.slider.run(&self.hidden, self.seed)
    }
}

fn one(effects: &[HiddenEffect], random: &mut StdRng) -> Vec<HiddenEffect> {
    vec![effects[random.random_range(0..effects.len())]]
}
