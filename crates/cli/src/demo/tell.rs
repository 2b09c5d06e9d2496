//! The chapters of the story, computed one after the other.

use std::time::Instant;

use bracketry::diagnose::{Report, Role, diagnose};
use bracketry::lie::Options;
use bracketry::lie::analyze;
use bracketry::plate::{Object, published};
use bracketry::report::{Diagnosis, diagnosis_text};

use super::event::{Finding, StoryEvent};
use super::logs::{self, record_logs};
use super::on_equations::MoveOnEquations;
use super::on_plant::MoveOnPlant;
use super::settings::{StoryError, StorySettings};
use super::story::Story;
use super::text;

impl Story {
    /// Computes all chapters; `watch` hears of each as it is done.
    ///
    /// # Errors
    /// [`StoryError`] if a chapter cannot be computed. A controller that misses its target, or a diagnosis that finds nothing, is a
    /// result.
    pub fn tell(settings: &StorySettings, watch: &mut dyn FnMut(StoryEvent<'_>)) -> Result<Self, StoryError> {
        let clock = Instant::now();
        let Object { shape, .. } = &settings.plant.object;
        let model = published(shape, settings.plant.mu)?;

        watch(StoryEvent::Told(text::OPENING));
        watch(StoryEvent::Told(text::FIRST));
        watch(StoryEvent::Working(1, "brackets and ranks"));
        let analysis = analyze(&model, &Options::default())?;
        watch(StoryEvent::Told(&bracketry::report::analysis::text(&analysis)));
        watch(StoryEvent::Found(Finding::Analysis(&analysis)));

        watch(StoryEvent::Told(text::SECOND));
        let on_equations = MoveOnEquations::run(shape, settings, &mut |what| watch(StoryEvent::Working(2, what)))?;
        watch(StoryEvent::Told(&on_equations.to_string()));
        watch(StoryEvent::Found(Finding::OnEquations(&on_equations)));

        watch(StoryEvent::Told(text::THIRD));
        watch(StoryEvent::Working(3, "the same controller on the area-contact plant"));
        let as_published = MoveOnPlant::run("published model", &model, &["mu".to_owned()], settings)?;
        watch(StoryEvent::Told(&as_published.to_string()));
        watch(StoryEvent::Found(Finding::AsPublished(&as_published)));

        watch(StoryEvent::Told(text::FOURTH));
        watch(StoryEvent::Working(4, "identification runs on the plant"));
        let logs = record_logs(&as_published, settings)?;
        watch(StoryEvent::Told(&text::of_logs(&logs)));
        watch(StoryEvent::Found(Finding::Logs(&logs)));
        let (mut records, audits) = logs::records(&logs, &model)?;
        let held_out: Vec<_> = records.pop().into_iter().collect();
        let mut progress =
            |stage: bracketry::diagnose::Stage| watch(StoryEvent::Working(4, &format!("diagnosis: {stage}")));
        let mut report = diagnose(&model, &records, &held_out, &settings.diagnosis, &mut progress)?;
        report.data = audits;
        watch(StoryEvent::Told(&diagnosis_text(&report)));
        let diagnosis = Diagnosis::new(&model, report);
        watch(StoryEvent::Found(Finding::Diagnosis(&diagnosis)));

        watch(StoryEvent::Told(text::FIFTH));
        watch(StoryEvent::Working(5, "what the extended model changes"));
        let extended_model = diagnosis.report.evidence.model.as_ref().map(|m| &m.system);
        let extended_analysis = extended_model.and_then(|m| analyze(m, &Options::default()).ok());
        watch(StoryEvent::Told(&text::of_ranks(&diagnosis)));

        watch(StoryEvent::Told(text::SIXTH));
        let extended = match extended_model {
            None => None,
            Some(model) => {
                watch(StoryEvent::Working(6, "the extended model in control of the area-contact plant"));
                let moved = MoveOnPlant::run("extended model", model, &adjusted(&diagnosis.report), settings)?;
                watch(StoryEvent::Found(Finding::Extended(&moved)));
                Some(moved)
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
        story.seconds = clock.elapsed().as_secs_f64();
        watch(StoryEvent::Told(&story.ending()));
        Ok(story)
    }
}

/// Parameters of the extended model that a loop may correct: the friction coefficient and the amplitudes of the causes. Shapes, as
/// a radius under a root, are not told by so short a run.
fn adjusted(report: &Report) -> Vec<String> {
    let effects = report.evidence.extended.as_ref().map_or(&[][..], |fit| &fit.effects);
    let amplitudes = effects.iter().flat_map(|e| &e.coefficients).filter(|c| c.role == Role::Amplitude);
    std::iter::once("mu".to_owned()).chain(amplitudes.map(|c| c.name.clone())).collect()
}
