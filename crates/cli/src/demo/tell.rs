//! The chapters of the story, computed one after the other.

use std::thread;
use std::time::Instant;

use bracketry::diagnose::{Report, Role, diagnose};
use bracketry::lie::analysis::RankChange;
use bracketry::lie::{Analysis, AnalysisOptions, analyze};
use bracketry::plate::control::move_with;
use bracketry::plate::{Object, Shape, published};
use bracketry::report::from_rest::from_rest_map_text;
use bracketry::report::{Diagnosis, diagnosis_text};
use bracketry::steer::from_rest::{Bound, FromRestMap, FromRestOptions, from_rest_map};
use bracketry::system::System;

use super::event::{Finding, StoryEvent};
use super::logs::{self, identification_runs, log_of_move};
use super::on_equations::MoveOnEquations;
use super::on_plant::MoveOnPlant;
use super::settings::{StoryError, StorySettings};
use super::story::Story;
use super::text;

/// Cells along each axis of the map from rest to rest.
const CELLS: usize = 12;

impl Story {
    /// Computes all chapters; `watch` hears of each as it is done. What does not hang on the chapter before runs beside it.
    ///
    /// # Errors
    /// [`StoryError`] if a chapter cannot be computed. A controller that misses its target, or a diagnosis that finds nothing, is a
    /// result.
    pub fn tell(settings: &StorySettings, watch: &mut dyn FnMut(StoryEvent<'_>)) -> Result<Self, StoryError> {
        let clock = Instant::now();
        let Object { shape, .. } = &settings.plant.object;
        let model = published(shape, settings.plant.mu)?;

        watch(StoryEvent::Told(text::OPENING));
        let (OnPublished { analysis, from_rest, on_equations, as_published }, logs) = thread::scope(|beside| {
            let runs = beside.spawn(|| identification_runs(settings));
            let found = on_published(&model, shape, settings, watch)?;
            watch(StoryEvent::Told(text::FOURTH));
            watch(StoryEvent::Working(4, "identification runs on the plant"));
            let mut logs = vec![log_of_move(&found.as_published, settings)];
            logs.extend(joined(runs)?);
            Ok::<_, StoryError>((found, logs))
        })?;
        watch(StoryEvent::Told(&text::of_logs(&logs)));
        watch(StoryEvent::Found(Finding::Logs(&logs)));
        let mut records = logs::records(&logs, &model)?;
        let held_out: Vec<_> = records.pop().into_iter().collect();
        let mut progress =
            |stage: bracketry::diagnose::Stage| watch(StoryEvent::Working(4, &format!("diagnosis: {stage}")));
        let report = diagnose(&model, &records, &held_out, &settings.diagnosis, &mut progress)?;
        watch(StoryEvent::Told(&diagnosis_text(&report, None)));
        watch(StoryEvent::Found(Finding::Diagnosis(&report)));

        watch(StoryEvent::Told(text::FIFTH));
        watch(StoryEvent::Working(5, "what the extended model changes"));
        let extended_model = report.evidence.model.as_ref().map(|m| &m.system);
        let adjusted = adjusted(&report);
        let (ranks, extended_analysis, extended) = thread::scope(|beside| {
            let moved = extended_model
                .map(|model| beside.spawn(|| MoveOnPlant::run("extended model", model, &adjusted, settings)));
            let dimensions = AnalysisOptions { flatness: false, ..AnalysisOptions::default() };
            let extended_analysis = extended_model.and_then(|m| analyze(m, &dimensions).ok());
            let ranks = extended_analysis.as_ref().and_then(|extended| RankChange::between(&analysis, extended));
            watch(StoryEvent::Told(&text::of_ranks(ranks.as_ref(), extended_model.is_some())));
            watch(StoryEvent::Told(text::SIXTH));
            watch(StoryEvent::Working(6, "the extended model in control of the area-contact plant"));
            let moved = moved.map(joined).transpose()?;
            Ok::<_, StoryError>((ranks, extended_analysis, moved))
        })?;
        if let Some(moved) = &extended {
            watch(StoryEvent::Found(Finding::Extended(moved)));
        }
        let mut story = Self {
            settings: settings.clone(),
            published: model,
            analysis,
            from_rest,
            on_equations,
            as_published,
            logs,
            diagnosis: Diagnosis { report, ranks, extended_model: None, next_experiments: Vec::new() },
            extended_analysis,
            extended,
            seconds: 0.0,
        };
        story.seconds = clock.elapsed().as_secs_f64();
        watch(StoryEvent::Told(&story.ending()));
        Ok(story)
    }
}

/// What chapters 1 to 3 find.
struct OnPublished {
    analysis: Analysis,
    from_rest: FromRestMap,
    on_equations: MoveOnEquations,
    as_published: MoveOnPlant,
}

/// What changes from rest to rest, over the largest acceleration of the plate and its largest tilt.
fn from_rest(model: &System) -> Result<FromRestMap, StoryError> {
    let options =
        FromRestOptions { bounds: vec![Bound::new("der(theta,2)", -20.0, 20.0)], ..FromRestOptions::default() };
    let axes = [Bound::new("der(X,2)", 1.0, 5.0), Bound::new("theta", 0.1, 0.5)];
    Ok(from_rest_map(model, &axes, CELLS, &options)?)
}

/// Chapters 1 to 3: the published model analyzed, in control of its own equations, and in control of the area-contact plant.
fn on_published(
    model: &System,
    shape: &Shape,
    settings: &StorySettings,
    watch: &mut dyn FnMut(StoryEvent<'_>),
) -> Result<OnPublished, StoryError> {
    watch(StoryEvent::Told(text::FIRST));
    watch(StoryEvent::Working(1, "brackets and ranks"));
    let analysis = analyze(model, &AnalysisOptions::default())?;
    watch(StoryEvent::Told(&bracketry::report::analysis::text(&analysis)));
    watch(StoryEvent::Found(Finding::Analysis(&analysis)));
    watch(StoryEvent::Working(1, "what changes from rest to rest"));
    let from_rest = from_rest(model)?;
    watch(StoryEvent::Told(&from_rest_map_text(&from_rest)));

    watch(StoryEvent::Told(text::SECOND));
    let on_equations = MoveOnEquations::run(shape, settings, &mut |what| watch(StoryEvent::Working(2, what)))?;
    watch(StoryEvent::Told(&on_equations.to_string()));
    watch(StoryEvent::Found(Finding::OnEquations(&on_equations)));

    watch(StoryEvent::Told(text::THIRD));
    watch(StoryEvent::Working(3, "the same controller on the area-contact plant"));
    let shortest = &on_equations.shortest;
    let adjusted = ["mu".to_owned()];
    let as_published = MoveOnPlant::within("published model", move_with(model)?, shortest, &adjusted, settings)?;
    watch(StoryEvent::Told(&as_published.to_string()));
    watch(StoryEvent::Found(Finding::AsPublished(&as_published)));
    Ok(OnPublished { analysis, from_rest, on_equations, as_published })
}

/// What a thread has computed; its panic goes on here.
fn joined<T, E>(thread: thread::ScopedJoinHandle<'_, Result<T, E>>) -> Result<T, E> {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// Parameters of the extended model that a loop may correct: the friction coefficient and the amplitudes of the causes. Shapes, as
/// a radius under a root, are not told by so short a run.
fn adjusted(report: &Report) -> Vec<String> {
    let effects = report.evidence.extended.as_ref().map_or(&[][..], |fit| &fit.effects);
    let amplitudes = effects.iter().flat_map(|e| &e.coefficients).filter(|c| c.role == Role::Amplitude);
    std::iter::once("mu".to_owned()).chain(amplitudes.map(|c| c.name.clone())).collect()
}
