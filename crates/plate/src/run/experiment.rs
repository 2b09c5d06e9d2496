//! An experiment that was run, with what it is judged by.

use std::ops::ControlFlow;

use super::comparison::Comparison;
use super::error::PlateRunError;
use super::pose_deviations::PoseDeviations;
use super::result::{Assumption, PlateRun};
use super::setup::PlateSetup;
use super::sign_comparison::SignComparison;
use crate::PlateLog;

/// One experiment on the plate: what was run, what it gave, and how that agrees with a log.
#[derive(Clone, Debug)]
pub struct PlateExperiment {
    /// What was run.
    pub setup: PlateSetup,
    /// What it gave.
    pub run: PlateRun,
    /// The log that it is compared with.
    pub log: Option<PlateLog>,
    /// Whether the plate moved as in the log.
    pub driven_by_log: bool,
    /// How far the run is from the log.
    pub comparison: Option<Comparison>,
    /// The same with the signs that the amplitude has in the log, where the run's own are others.
    pub with_signs_of_log: Option<PlateRun>,
}

/// How an experiment ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlateOutcome {
    /// The target was reached.
    Reached,
    /// It was not.
    NotReached,
    /// The run ended early.
    Stopped,
    /// The object does not lie flat at the end.
    NotFlat,
}

impl PlateExperiment {
    /// Runs an experiment beside a log, or, if `driven_by_log`, on the plate motion of the log. `watch` is told the time now and
    /// then, and can break the run off.
    ///
    /// # Errors
    /// [`PlateRunError`] if something does not fit. What stops a run is an answer, not an error.
    pub fn new(
        setup: PlateSetup,
        log: Option<PlateLog>,
        driven_by_log: bool,
        mut watch: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Self, PlateRunError> {
        let run = setup.run(log.as_ref().filter(|_| driven_by_log), &mut watch)?;
        let mut ran = Self { setup, run, log, driven_by_log, comparison: None, with_signs_of_log: None };
        let Some(log) = &ran.log else { return Ok(ran) };
        let Some(whole) = PoseDeviations::new(&ran.run.rows, log, ..) else {
            return Err(PlateRunError::NoCommonTime { log: log.name.clone() });
        };
        let signs = if driven_by_log { None } else { SignComparison::new(&ran.setup, &ran.run, log, watch)? };
        let (signs, with_signs_of_log) = signs.map_or((None, None), |(signs, run)| (Some(signs), run));
        ran.comparison = Some(Comparison { log: log.name.clone(), whole, signs });
        ran.with_signs_of_log = with_signs_of_log;
        Ok(ran)
    }

    /// How it ended.
    pub fn outcome(&self) -> PlateOutcome {
        match (&self.run.stopped, self.run.flat, self.run.reached) {
            (Some(_), _, _) => PlateOutcome::Stopped,
            (None, false, _) => PlateOutcome::NotFlat,
            (None, true, Some(_)) => PlateOutcome::Reached,
            (None, true, None) => PlateOutcome::NotReached,
        }
    }

    /// What is assumed where the description of the experiment leaves a choice.
    pub fn assumptions(&self) -> Vec<Assumption> {
        let experiment = &self.setup.experiment;
        let mut assumptions = Vec::new();
        if self.driven_by_log {
            assumptions.push(Assumption::LoggedMotion);
        } else {
            assumptions.push(Assumption::TimeConstant);
            if experiment.law.is_some() {
                assumptions.extend([Assumption::HeldAmplitude, Assumption::AmplitudeStep(experiment.step)]);
            }
        }
        assumptions.extend([Assumption::StartAtRest, Assumption::TimeToTarget]);
        assumptions
    }
}
