//! The story as data.

use bracketry::lie::Analysis;
use bracketry::plate::Shape;
use bracketry::plate::recording::SyntheticLog;
use bracketry::report::Diagnosis;
use bracketry::steer::from_rest::FromRestMap;
use bracketry::system::System;

use super::on_equations::MoveOnEquations;
use super::on_plant::MoveOnPlant;
use super::settings::StorySettings;

/// The story.
#[derive(Clone)]
pub struct Story {
    /// How it is told: the plant, the seed.
    pub settings: StorySettings,
    /// The published model.
    pub published: System,
    /// Chapter 1: what the inputs of the published model reach.
    pub analysis: Analysis,
    /// Chapter 1: what changes from rest to rest, over the largest acceleration and tilt.
    pub from_rest: FromRestMap,
    /// Chapter 2: closed loop on the published equations.
    pub on_equations: MoveOnEquations,
    /// Chapter 3: the same controller on the area-contact plant.
    pub as_published: MoveOnPlant,
    /// Chapter 4: what was logged; the first is the log of chapter 3, the last is held out.
    pub logs: Vec<SyntheticLog>,
    /// Chapters 4 and 5: what the published model gets wrong in these logs, and what the extended one reaches.
    pub diagnosis: Diagnosis,
    /// Chapter 5: what the inputs of the extended model reach; absent without one, or if it cannot be analyzed.
    pub extended_analysis: Option<Analysis>,
    /// Chapter 6: the extended model in control of the same plant; absent where nothing was found.
    pub extended: Option<MoveOnPlant>,
    /// Wall time (s).
    pub seconds: f64,
}

impl Story {
    /// The object of the story.
    pub(super) fn shape(&self) -> &Shape {
        &self.on_equations.shape
    }
}

/// An animation of the story.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoryAnimation {
    /// Name of its file, without ending.
    pub name: &'static str,
    /// Chapter, from 1 on.
    pub chapter: usize,
    /// What it shows.
    pub title: &'static str,
    /// The images.
    pub gif: Vec<u8>,
    /// The last image as a PNG.
    pub still: Vec<u8>,
}
