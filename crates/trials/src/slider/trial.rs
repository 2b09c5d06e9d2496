//! One trial: an effect chosen at random is hidden in a log of a slider, which is diagnosed from its CSV and the model text alone.

use super::effect::SliderEffect;
use super::error::SyntheticError;
use super::experiment::{Slider, SliderLog, SliderSensors};
use super::score::Score;
use bracketry_diagnose::{DiagnosisSettings, RecordSettings, Report, diagnose, read_record};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use std::error::Error;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Files written so far: tests run side by side, each log has a file of its own.
static FILES: AtomicUsize = AtomicUsize::new(0);

/// What may be hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
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
    Only(SliderEffect),
}

/// One log to be diagnosed.
pub struct SliderTrial {
    /// Everything about it follows from this number and the settings.
    pub seed: u64,
    /// What is hidden.
    pub hidden: Vec<SliderEffect>,
    /// The experiment.
    pub slider: Slider,
}

impl SliderTrial {
    /// Draws effects and experiment. `general`: sampling, noise, excitation and sizes at random as well.
    pub fn draw(choice: Choice, sensors: SliderSensors, size: f64, general: bool, seed: u64) -> Self {
        let mut random = StdRng::seed_from_u64(seed);
        let hidden = match choice {
            Choice::Nothing => Vec::new(),
            Choice::Any => one(&SliderEffect::BASIC, &mut random),
            Choice::Further => one(&SliderEffect::FURTHER, &mut random),
            Choice::Outside => one(&SliderEffect::OUTSIDE, &mut random),
            Choice::Only(effect) => vec![effect],
            Choice::Pair => SliderEffect::BASIC.sample(&mut random, 2).copied().collect(),
        };
        let slider = if general {
            Slider::random(sensors, &mut random)
        } else {
            Slider { size, ..Slider::basic(sensors, &mut random) }
        };
        Self { seed, hidden, slider }
    }

    /// The log.
    ///
    /// # Errors
    /// As [`Slider::run`].
    pub fn log(&self) -> Result<SliderLog, SyntheticError> {
        self.slider.run(&self.hidden, self.seed)
    }

    /// Diagnoses the log and compares with the truth.
    ///
    /// # Errors
    /// A log that cannot be made, and what the diagnosis refuses.
    pub fn run(&self, settings: &DiagnosisSettings) -> Result<(Report, Score), Box<dyn Error>> {
        let log = self.log()?;
        let (process, number) = (std::process::id(), FILES.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(format!("hidden_effect_{process}_{number}.csv"));
        fs::write(&path, log.csv())?;
        let report = verdict(&path, &log.model, settings);
        fs::remove_file(&path)?;
        let report = report?;
        let score = Score::of(&log.truth, &report);
        Ok((report, score))
    }
}

/// What a diagnosis says that is given a CSV and the text of a model.
fn verdict(csv: &Path, model: &str, settings: &DiagnosisSettings) -> Result<Report, Box<dyn Error>> {
    let system = System::parse("slider.toml", model)?;
    let record = read_record(csv, &system, &RecordSettings::default())?;
    Ok(diagnose(&system, &[record], &[], settings, &mut |_| {})?)
}

fn one(effects: &[SliderEffect], random: &mut StdRng) -> Vec<SliderEffect> {
    vec![effects[random.random_range(0..effects.len())]]
}
