//! Many trials in parallel and what they come to.

use super::scenario::Trial;
use super::statistics::{Quantiles, Share, quantile};
use super::trial::{TrialOutcome, TrialRun, TrialSetup, Utilization, run_trial};
use crate::TrialError;
use bracketry_plate::control::PlateController;
use bracketry_plate::experiment::sweep;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

/// Wall times of a controller in s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WallTimes {
    /// From the call for the controller to its first command: making and planning.
    pub planning: f64,
    /// Median of the other samples.
    pub p50: Option<f64>,
    /// 99 % quantile of the other samples.
    pub p99: Option<f64>,
    /// The longest of the other samples.
    pub max: Option<f64>,
}

/// What a trial came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialReport {
    /// The trial.
    pub trial: Trial,
    /// How it ended.
    pub outcome: TrialOutcome,
    /// Error at the end, `x, y` (m), `phi` (rad, to the nearest whole turn).
    pub final_error: [f64; 3],
    /// How far the bounds were made use of.
    pub utilization: Utilization,
    /// Time simulated in s.
    pub simulated: f64,
    /// Wall times of the controller. They differ from run to run.
    pub wall: WallTimes,
}

impl TrialReport {
    /// The report of a run whose controller took `making` seconds to be made.
    pub fn new(trial: &Trial, run: &TrialRun, making: f64) -> Self {
        let seconds: Vec<f64> = run.controls.iter().map(|c| c.seconds).collect();
        let (first, others) = seconds.split_first().map_or((0.0, &[][..]), |(first, others)| (*first, others));
        let [p50, p99, max] = [0.5, 0.99, 1.0].map(|q| quantile(others, q));
        Self {
            trial: trial.clone(),
            outcome: run.outcome.clone(),
            final_error: run.final_error,
            utilization: run.utilization,
            simulated: run.samples.last().map_or(0.0, |s| s.t),
            wall: WallTimes { planning: making + first, p50, p99, max },
        }
    }

    /// Time to target in s; infinite if the target was not reached.
    pub fn time(&self) -> f64 {
        self.outcome.time().unwrap_or(f64::INFINITY)
    }
}

/// What a series of trials came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialSummary {
    /// Trials that reached their target.
    pub reached: Share,
    /// Trials that kept all bounds of the plate's motion.
    pub bounds_kept: Share,
    /// Outcomes with their numbers.
    pub outcomes: BTreeMap<String, usize>,
    /// Time to target in s over all trials, those without counted as infinite.
    pub time: Quantiles,
    /// Greater of the errors along x and y at the end in m, over all trials.
    pub position_error: Quantiles,
    /// Error of the yaw at the end in rad, over all trials.
    pub angle_error: Quantiles,
    /// Wall time to the first command in s.
    pub planning: Quantiles,
    /// Trials' median wall times of a sample in s.
    pub sample_p50: Quantiles,
    /// Trials' 99 % quantiles of the wall time of a sample in s.
    pub sample_p99: Quantiles,
}

impl TrialSummary {
    /// The summary of reports.
    pub fn of(reports: &[TrialReport]) -> Self {
        let count =
            |holds: fn(&TrialReport) -> bool| Share::new(reports.iter().filter(|r| holds(r)).count(), reports.len());
        let quantiles =
            |number: fn(&TrialReport) -> f64| Quantiles::of(&reports.iter().map(number).collect::<Vec<_>>());
        let mut outcomes: BTreeMap<String, usize> = BTreeMap::new();
        for report in reports {
            *outcomes.entry(report.outcome.label().to_owned()).or_default() += 1;
        }
        Self {
            reached: count(|r| r.outcome.time().is_some()),
            bounds_kept: count(|r| r.utilization.keeps()),
            outcomes,
            time: quantiles(TrialReport::time),
            position_error: quantiles(|r| r.final_error[0].abs().max(r.final_error[1].abs())),
            angle_error: quantiles(|r| r.final_error[2].abs()),
            planning: quantiles(|r| r.wall.planning),
            sample_p50: quantiles(|r| r.wall.p50.unwrap_or(f64::INFINITY)),
            sample_p99: quantiles(|r| r.wall.p99.unwrap_or(f64::INFINITY)),
        }
    }
}

/// Runs trials on all threads of the current rayon pool, each with a controller that `make` makes for it. The results come in
/// the order of the trials; those of a sweep that was canceled through `progress` (see [`sweep`]) are missing. But for wall
/// times they do not depend on the number of threads.
///
/// # Errors
/// The first error of a trial: the setup has no meaning, or the controller cannot be made.
pub fn run_trials<C: PlateController>(
    trials: &[Trial],
    setup: &TrialSetup,
    make: impl Fn(&Trial) -> Result<C, TrialError> + Sync,
    progress: impl Fn(usize) -> ControlFlow<()> + Sync,
) -> Result<Vec<TrialReport>, TrialError> {
    let run = |trial: &Trial| {
        let started = Instant::now();
        let mut controller = make(trial)?;
        let making = started.elapsed().as_secs_f64();
        let run = run_trial(trial, setup, &mut controller)?;
        Ok(TrialReport::new(trial, &run, making))
    };
    sweep(trials, run, progress).into_iter().flatten().collect()
}

/// Median over the trials of the ratio of two times to target, `a/b`: 0 where only `a` reached, infinite where only `b` did,
/// left out where neither did. Absent without such trials and where it is infinite.
pub fn median_time_ratio(a: &[TrialReport], b: &[TrialReport]) -> Option<f64> {
    let ratios: Vec<f64> = a.iter().zip(b).map(|(a, b)| a.time() / b.time()).filter(|ratio| !ratio.is_nan()).collect();
    quantile(&ratios, 0.5)
}
