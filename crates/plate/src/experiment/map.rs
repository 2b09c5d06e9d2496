//! Maps of an experiment over two quantities: time to target, drift, run-off.

use super::protocol::Experiment;
use super::sweep::sweep;
use crate::driven::Course;
use crate::{DrivenObject, PlateError};
use bracketry_sim::Outcome;
use std::ops::ControlFlow;

/// How far an object may go on the plate before it counts as lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Greatest distance of the center of mass from its start along either axis, in meters.
    pub travel: f64,
}

impl Default for Limits {
    /// 0.15 m.
    fn default() -> Self {
        Self { travel: 0.15 }
    }
}

/// What a run comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// First time at which 98 % of the distance was covered, in seconds.
    pub reached: Option<f64>,
    /// End of the period in which the object went beyond the limits; the run ends there.
    pub run_off: Option<f64>,
    /// Time simulated, in seconds.
    pub duration: f64,
    /// State at the end, `x, y, phi, vx, vy, w`.
    pub end: [f64; 6],
    /// Displacement from the start to the end in x, y (m) and phi (rad).
    pub displacement: [f64; 3],
    /// Least normal load per mass in m/s²; see [`Run::least_load`](crate::experiment::Run::least_load).
    pub least_load: f64,
    /// How the simulation ended.
    pub outcome: Outcome,
}

impl Summary {
    /// Distance between start and end on the plate over the time simulated, in m/s.
    pub fn drift(&self) -> f64 {
        if self.duration > 0.0 { self.displacement[0].hypot(self.displacement[1]) / self.duration } else { 0.0 }
    }
}

/// Runs an experiment for `duration` seconds, or until the object has gone beyond the limits at the end of a period.
///
/// # Errors
/// [`PlateError`] if the experiment does not fit the object.
pub fn summarize<P: DrivenObject>(
    experiment: &Experiment,
    object: &mut P,
    duration: f64,
    limits: Limits,
) -> Result<Summary, PlateError> {
    let (from, start) = (object.time(), object.state());
    let mut run_off = None;
    let run = experiment.run_until(object, duration, |t, state| {
        let lost = (0..2).any(|i| (state[i] - start[i]).abs() > limits.travel);
        run_off = lost.then_some(t - from);
        lost
    })?;
    let end = object.state();
    Ok(Summary {
        reached: run.reached.map(|t| t - from),
        run_off,
        duration: run.trajectory.end() - from,
        end,
        displacement: [end[0] - start[0], end[1] - start[1], end[2] - start[2]],
        least_load: run.least_load,
        outcome: run.outcome,
    })
}

/// Results over two quantities, the first one varying fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Map<R> {
    /// Values of the first quantity.
    pub across: Vec<f64>,
    /// Values of the second quantity.
    pub up: Vec<f64>,
    /// One result for each pair; `None` if the sweep was canceled before.
    pub results: Vec<Option<R>>,
}

impl<R: Send> Map<R> {
    /// Runs `run(across, up)` for every pair of values; see [`sweep`] for `progress`.
    pub fn compute(
        across: &[f64],
        up: &[f64],
        run: impl Fn(f64, f64) -> R + Sync,
        progress: impl Fn(usize) -> ControlFlow<()> + Sync,
    ) -> Self {
        let cases: Vec<(f64, f64)> = up.iter().flat_map(|&b| across.iter().map(move |&a| (a, b))).collect();
        let results = sweep(&cases, |&(a, b)| run(a, b), progress);
        Self { across: across.to_vec(), up: up.to_vec(), results }
    }
}

impl<R> Map<R> {
    /// The result at `(column, row)`.
    pub fn get(&self, column: usize, row: usize) -> Option<&R> {
        if column >= self.across.len() {
            return None;
        }
        self.results.get(row * self.across.len() + column)?.as_ref()
    }

    /// A number for every pair, row by row.
    pub fn numbers(&self, number: impl Fn(Option<&R>) -> f64) -> Vec<f64> {
        self.results.iter().map(|result| number(result.as_ref())).collect()
    }
}

/// `count` values from `from` to `to`, both included, evenly spaced.
///
/// ```
/// assert_eq!(bracketry_plate::experiment::linspace(0.0, 1.0, 3), [0.0, 0.5, 1.0]);
/// ```
pub fn linspace(from: f64, to: f64, count: usize) -> Vec<f64> {
    let last = count.saturating_sub(1).max(1) as f64;
    (0..count).map(|i| from + (to - from) * i as f64 / last).collect()
}
