//! Hides an effect that is chosen at random in a log of a slider and diagnoses it from its CSV and the model text alone.

use bracketry_diagnose::{
    HiddenEffect, RecordSettings, Report, Score, Settings, Slider, SliderLog, SliderSensors, SyntheticError, diagnose,
    read_record,
};
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

/// What may be hidden. Tests and examples use some each.
#[allow(dead_code)]
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

    /// Diagnoses the log and compares with the truth.
    pub(crate) fn run(&self, settings: &Settings) -> Result<(Report, Score), Box<dyn Error>> {
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
fn verdict(csv: &Path, model: &str, settings: &Settings) -> Result<Report, Box<dyn Error>> {
    let system = System::parse("slider.toml", model)?;
    let (record, _) = read_record(csv, &system, &RecordSettings::default())?;
    Ok(diagnose(&system, &[record], &[], settings, &mut |_| {})?)
}

fn one(effects: &[HiddenEffect], random: &mut StdRng) -> Vec<HiddenEffect> {
    vec![effects[random.random_range(0..effects.len())]]
}
