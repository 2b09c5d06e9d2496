//! Whether run and log took the same signs of the amplitude, and what that is worth to their comparison.

use std::ops::{Bound, ControlFlow};

use serde::Serialize;

use super::error::PlateRunError;
use super::log_signs::{DEVIATIONS, LogSigns, LoggedError};
use super::period_start::{PeriodStart, SignSource};
use super::pose_deviations::{Deviation, PoseDeviations, UNITS};
use super::result::{PlateRow, PlateRun};
use super::setup::PlateSetup;
use crate::PlateLog;
use crate::experiment::Coordinate;

/// The signs of the amplitude in a run and in a log. The amplitude of a period has the sign of the error at its start; where
/// that error is less than what noise or the model's own deviation explains, run and log may take opposite signs, and the motion
/// of one is the mirror image of the other's from then on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignComparison {
    /// The coordinate whose error is meant.
    pub coordinate: Coordinate,
    /// The motion of the plate with this amplitude.
    pub input: ScaledInput,
    /// Standard deviation of the noise of that coordinate in the log, in m or rad.
    pub noise: f64,
    /// Whether that was given, not estimated from the log.
    pub noise_given: bool,
    /// How many starts of periods run and log have in common.
    pub starts: usize,
    /// Starts at which run and log took the same sign, although an error is less than three standard deviations of the log's or
    /// less than the difference of both.
    pub close: Vec<ErrorsAtStart>,
    /// The first start at which they took opposite signs.
    pub opposite: Option<OppositeSigns>,
}

/// The errors `q − q_desired` of run and log at the start of a period, in m or rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorsAtStart {
    /// When, in s.
    pub t: f64,
    /// Of the run.
    pub run_error: f64,
    /// Of the log.
    pub log_error: f64,
    /// Standard deviation of that of the log.
    pub log_deviation: f64,
}

/// Run and log with opposite signs of the amplitude.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OppositeSigns {
    /// The first start of a period with opposite signs.
    #[serde(flatten)]
    pub errors: ErrorsAtStart,
    /// Where the sign of the log comes from.
    pub sign_of_log: SignSource,
    /// Largest difference of both errors that noise and the deviation before explain: three standard deviations, in m or
    /// rad.
    pub explained: f64,
    /// Until then.
    pub before: Option<PoseDeviations>,
    /// From then on.
    pub after: Option<PoseDeviations>,
    /// From then on, of a run with the signs of the log; none if that run ended before.
    pub after_with_signs_of_log: Option<PoseDeviations>,
    /// Starts of periods at which that run had to be given the sign of the log, in s.
    pub given_signs: Vec<f64>,
    /// What depends on the sign: differences between both runs from then on.
    pub depending: Dependence,
}

/// Differences between a run and the same with other signs of the amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Dependence {
    /// Along x, in millimeters.
    pub x_mm: Deviation,
    /// Along y, in millimeters.
    pub y_mm: Deviation,
    /// Yaw, in degrees.
    pub phi_deg: Deviation,
}

/// A motion of the plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum ScaledInput {
    /// Its displacement.
    X,
    /// Its tilt.
    #[serde(rename = "theta")]
    Theta,
}

/// What the signs of the amplitude say about a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SignStatus {
    /// Run and log took the same signs, each for an error beyond the noise.
    Decided,
    /// They took the same signs; some of the errors are less than the noise or than the difference of both.
    Agreed,
    /// They took opposite signs where noise or the deviation before decides: only the comparison before that counts.
    Undecided,
    /// They took opposite signs, although their errors differ by more than noise and the deviation before explain.
    Contradicted,
}

impl SignComparison {
    /// What the signs say about the comparison.
    pub fn status(&self) -> SignStatus {
        match &self.opposite {
            Some(opposite) if opposite.is_chance() => SignStatus::Undecided,
            Some(_) => SignStatus::Contradicted,
            None if self.close.is_empty() => SignStatus::Decided,
            None => SignStatus::Agreed,
        }
    }

    /// Compares the signs of a run with those of a log; with the run that has the signs of the log, if there are others. None for
    /// an experiment without amplitude law.
    pub(super) fn new(
        setup: &PlateSetup,
        run: &PlateRun,
        log: &PlateLog,
        watch: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Option<(Self, Option<PlateRun>)>, PlateRunError> {
        if setup.experiment.law.is_none() {
            return Ok(None);
        }
        let signs = LogSigns::new(setup, log);
        let mut open = false;
        for start in &run.starts {
            let known = signs.known(start.t)?;
            open |= known.is_none_or(|(sign, _)| start.natural == 0.0 || sign != start.natural.signum());
        }
        let with_signs = if open { Some(setup.run_with_signs(&signs, watch)?) } else { None };
        // Both runs are the same until the first start with opposite signs.
        let starts = with_signs.as_ref().map_or(&run.starts, |other| &other.starts);
        let common: Vec<(&PeriodStart, LoggedError)> =
            starts.iter().filter_map(|start| Some((start, signs.error(start.t)?))).collect();
        let first = common.iter().position(|(start, _)| start.held != start.natural);
        let close = common[..first.unwrap_or(common.len())]
            .iter()
            .filter(|(start, log)| is_close(start.error, log))
            .map(|(start, log)| ErrorsAtStart::new(start, log))
            .collect();
        let opposite = match (first.map(|k| common[k]), &with_signs) {
            (Some((start, error)), Some(other)) => Some(OppositeSigns::new(setup, start, &error, [run, other], log)),
            _ => None,
        };
        let comparison = Self {
            coordinate: setup.experiment.coordinate,
            input: ScaledInput::of(setup)?,
            noise: signs.noise,
            noise_given: setup.noise.is_some(),
            starts: common.len(),
            close,
            opposite,
        };
        let with_signs = with_signs.filter(|_| comparison.opposite.is_some());
        Ok(Some((comparison, with_signs)))
    }
}

/// Whether a sign hangs on less than the noise, or on less than the difference between run and log.
fn is_close(run: f64, log: &LoggedError) -> bool {
    run.abs().min(log.value.abs()) < (DEVIATIONS * log.deviation).max((run - log.value).abs())
}

impl ErrorsAtStart {
    fn new(start: &PeriodStart, log: &LoggedError) -> Self {
        Self { t: start.t, run_error: start.error, log_error: log.value, log_deviation: log.deviation }
    }
}

impl OppositeSigns {
    fn new(
        setup: &PlateSetup,
        start: &PeriodStart,
        error: &LoggedError,
        [run, other]: [&PlateRun; 2],
        log: &PlateLog,
    ) -> Self {
        let (k, t) = (setup.coordinate(), start.t);
        let after = (Bound::Excluded(t), Bound::Unbounded);
        let before = PoseDeviations::new(&run.rows, log, ..=t);
        let deviation = before.as_ref().map_or(0.0, |b| b.rms(k));
        Self {
            errors: ErrorsAtStart::new(start, error),
            sign_of_log: start.sign,
            explained: DEVIATIONS * error.deviation.hypot(deviation),
            before,
            after: PoseDeviations::new(&run.rows, log, after),
            after_with_signs_of_log: PoseDeviations::new(&other.rows, log, after),
            given_signs: other.starts.iter().filter(|s| s.held != s.natural).map(|s| s.t).collect(),
            depending: Dependence::new(t, &run.rows, &other.rows),
        }
    }

    /// Whether noise and the deviation before explain the difference of the errors.
    pub fn is_chance(&self) -> bool {
        (self.errors.run_error - self.errors.log_error).abs() <= self.explained
    }
}

impl Dependence {
    /// Between runs with the same times, from `t` on.
    fn new(t: f64, run: &[PlateRow], other: &[PlateRow]) -> Self {
        let pairs = || run.iter().zip(other).filter(|(row, _)| row.t > t);
        let along = |k: usize| {
            let differences: Vec<f64> = pairs().map(|(a, b)| UNITS[k] * (a.state[k] - b.state[k])).collect();
            Deviation::of(&differences)
        };
        Self { x_mm: along(0), y_mm: along(1), phi_deg: along(2) }
    }
}

impl ScaledInput {
    /// The motion with the amplitude of an experiment: the displacement, if its formula has the amplitude.
    fn of(setup: &PlateSetup) -> Result<Self, PlateRunError> {
        let experiment = &setup.experiment;
        Ok(if experiment.scales_displacement()? { Self::X } else { Self::Theta })
    }
}
