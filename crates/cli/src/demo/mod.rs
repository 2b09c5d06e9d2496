//! The whole story of the vibrating plate, chapter by chapter: what the published equations let the inputs reach, a closed loop
//! on them, the same controller on the true plant, a diagnosis of what was logged there, and the extended model in control.

mod figures;
mod logs;
mod on_equations;
mod on_plant;
mod page;
mod summary;
mod text;

use std::time::Instant;

use bracketry::diagnose::{DiagnoseError, Settings, diagnose};
use bracketry::lie::Options;
use bracketry::mpc::MpcError;
use bracketry::plate::{LogSettings, Object, PlateError, PlateLog, Shape, published};
use bracketry::plot::PlotError;
use bracketry::system::System;

use bracketry::lie::{Analysis, AnalysisError, analyze};
use bracketry::report::ControlError;
use bracketry::report::Diagnosis;
use bracketry::report::Figure;
use bracketry::report::MoveError;

pub use figures::StoryAnimation;
pub use logs::record_logs;
pub use on_equations::MoveOnEquations;
pub use on_plant::MoveOnPlant;

/// How the story is told.
#[derive(Clone, Debug)]
pub struct StorySettings {
    /// The plant with contact over the whole footprint, and how it is recorded.
    pub plant: LogSettings,
    /// Length of the multisines and of experiment 1 (s); experiment 3 takes five seconds at most.
    pub seconds: f64,
    /// Seed of multisines and noise.
    pub seed: u64,
    /// Samples after the move in which object and plate must stay at rest.
    pub rest_samples: usize,
    /// How the logs are diagnosed.
    pub diagnosis: Settings,
}

impl Default for StorySettings {
    /// The reference disk with friction 0.3; logs of 8 s at 200 Hz with noise of 0.5 mm and 0.3°; up to six causes from windows of
    /// 0.5 s; 0.6 s of rest.
    fn default() -> Self {
        let mut diagnosis = Settings { max_causes: 6, ..Settings::default() };
        diagnosis.study.window = Some(0.5);
        Self { plant: LogSettings::default(), seconds: 8.0, seed: 1_000_003, rest_samples: 30, diagnosis }
    }
}

/// A story that cannot be told.
#[derive(Debug, thiserror::Error)]
pub enum StoryError {
    /// The object, its friction, or the way it is recorded.
    #[error(transparent)]
    Plate(#[from] PlateError),
    /// The published model cannot be analysed.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// The move cannot be set up.
    #[error(transparent)]
    Move(#[from] MoveError),
    /// The closed loop on the published equations.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The closed loop on the true plant.
    #[error("the closed loop on the area-contact plant: {0}")]
    Loop(#[from] MpcError),
    /// The logs cannot be diagnosed.
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    /// A figure or animation cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// What is going on while the story is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoryEvent<'a> {
    /// Work that takes its time begins.
    Working(&'a str),
    /// A chapter, or a part of one, is done: its text.
    Told(&'a str),
}

/// The story.
#[derive(Clone)]
pub struct Story {
    /// The published model.
    pub published: System,
    /// Chapter 1: what the inputs of the published model reach.
    pub analysis: Analysis,
    /// Chapter 2: closed loop on the published equations.
    pub on_equations: MoveOnEquations,
    /// Chapter 3: the same controller on the area-contact plant.
    pub as_published: MoveOnPlant,
    /// Chapter 4: what was logged; the first is the log of chapter 3, the last is held out.
    pub logs: Vec<PlateLog>,
    /// Chapters 4 and 5: what the published model gets wrong in these logs, and what the extended one reaches.
    pub diagnosis: Diagnosis,
    /// Chapter 5: what the inputs of the extended model reach; absent without one, or if it cannot be analysed.
    pub extended_analysis: Option<Analysis>,
    /// Chapter 6: the extended model in control of the same plant; absent where nothing was found.
    pub extended: Option<MoveOnPlant>,
    /// Wall time (s).
    pub seconds: f64,
}

impl Story {
    /// Computes all chapters; `watch` hears of each as it is done.
    ///
    /// # Errors
    /// [`StoryError`] if a chapter cannot be computed. A controller that misses its target, or a diagnosis that finds nothing, is a
    /// result.
    pub fn tell(settings: &StorySettings, watch: &mut dyn FnMut(StoryEvent<'_>)) -> Result<Self, StoryError> {
        let begin = Instant::now();
        let Object { shape, .. } = &settings.plant.object;
        let model = published(shape, settings.plant.mu)?;

        watch(StoryEvent::Told(text::FIRST));
        watch(StoryEvent::Working("brackets and ranks"));
        let analysis = analyze(&model, &Options::default())?;
        watch(StoryEvent::Told(&bracketry::report::analysis::text(&analysis)));

        watch(StoryEvent::Told(text::SECOND));
        let on_equations = MoveOnEquations::run(shape, settings, watch)?;
        watch(StoryEvent::Told(&on_equations.to_string()));

        watch(StoryEvent::Told(text::THIRD));
        watch(StoryEvent::Working("the same controller on the area-contact plant"));
        let as_published = MoveOnPlant::run("published model", &model, settings)?;
        watch(StoryEvent::Told(&as_published.to_string()));

        watch(StoryEvent::Told(text::FOURTH));
        watch(StoryEvent::Working("identification runs on the plant"));
        let logs = record_logs(&as_published, settings)?;
        watch(StoryEvent::Told(&text::of_logs(&logs)));
        let (mut records, audits) = logs::records(&logs, &model)?;
        let held_out: Vec<_> = records.pop().into_iter().collect();
        let mut progress =
            |stage: bracketry::diagnose::Stage| watch(StoryEvent::Working(&format!("diagnosis: {stage}")));
        let mut report = diagnose(&model, &records, &held_out, &settings.diagnosis, &mut progress)?;
        report.data = audits;
        watch(StoryEvent::Told(&report.to_string()));

        watch(StoryEvent::Told(text::FIFTH));
        watch(StoryEvent::Working("what the extended model changes"));
        let diagnosis = Diagnosis::new(&model, report);
        let extended_model = diagnosis.report.evidence.model.as_ref().map(|m| &m.system);
        let extended_analysis = extended_model.and_then(|m| analyze(m, &Options::default()).ok());
        watch(StoryEvent::Told(&text::of_ranks(&diagnosis)));

        watch(StoryEvent::Told(text::SIXTH));
        let extended = match extended_model {
            None => None,
            Some(model) => {
                watch(StoryEvent::Working("the extended model in control of the area-contact plant"));
                Some(MoveOnPlant::run("extended model", model, settings)?)
            }
        };
        let mut story = Self {
            published: model,
            analysis,
            on_equations,
            as_published,
            logs,
            diagnosis,
            extended_analysis,
            extended,
            seconds: 0.0,
        };
        story.seconds = begin.elapsed().as_secs_f64();
        watch(StoryEvent::Told(&story.ending()));
        Ok(story)
    }

    /// Every figure, chapter by chapter.
    pub fn figures(&self) -> Vec<Figure> {
        self.chapters().into_iter().flatten().collect()
    }

    /// The object of the story.
    fn shape(&self) -> &Shape {
        &self.on_equations.shape
    }
}
