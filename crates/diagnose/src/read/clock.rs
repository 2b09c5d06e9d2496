//! The times of a run: order, gaps, jitter.

use bracketry_numerics::statistics::steps;
use bracketry_system::FileError;

use super::origin::Origin;

/// What the times of a run are like.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Clock {
    /// Median step, s.
    pub(super) step: f64,
    /// Standard deviation of the steps that are no gaps over the median step.
    pub(super) jitter: f64,
    /// Index of the first sample after each gap.
    pub(super) gaps: Vec<usize>,
}

impl Clock {
    /// Refuses times that no table of samples has.
    ///
    /// # Errors
    /// [`FileError`] for fewer than two, for one that is not finite, for the first that falls, and where all are the same.
    pub(super) fn check(origin: &Origin<'_>, times: &[f64]) -> Result<(), FileError> {
        if times.len() < 2 {
            return Err(origin.whole("the table has fewer than two rows", "give at least two samples"));
        }
        if let Some(row) = times.iter().position(|t| !t.is_finite()) {
            return Err(origin.at(row, "t", "not a finite number", "correct or remove the row"));
        }
        if let Some(row) = (1..times.len()).find(|&row| times[row] < times[row - 1]) {
            let problem = format!("the time {} is less than {} before it", times[row], times[row - 1]);
            return Err(origin.at(row, "t", &problem, "sort the rows by time; split runs that start again"));
        }
        if times[0] == times[times.len() - 1] {
            return Err(origin.whole("all times are the same", "give the time of each row"));
        }
        Ok(())
    }

    /// Looks at times that increase; steps of more than `gap` usual ones are gaps, and so are `cuts`.
    pub(super) fn of(times: &[f64], gap: f64, cuts: &[usize]) -> Self {
        let steps = steps(times);
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        let step = sorted[sorted.len() / 2];
        // Of a clock that runs unevenly, the long steps are no gaps.
        let usual = step.max(sorted[sorted.len() * 9 / 10]);
        let gaps: Vec<usize> =
            (1..times.len()).filter(|row| steps[row - 1] > gap * usual || cuts.contains(row)).collect();
        let regular = sorted.iter().filter(|dt| **dt <= gap * usual);
        let count = regular.clone().count() as f64;
        let mean = regular.clone().sum::<f64>() / count;
        let variance = regular.map(|dt| (dt - mean).powi(2)).sum::<f64>() / count;
        Self { step, jitter: variance.sqrt() / step, gaps }
    }
}
