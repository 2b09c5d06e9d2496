//! A filter: the globalization of Fletcher and Leyffer.
//!
//! A step is acceptable when it improves defect or objective enough against the current iterate and against everything in
//! the filter (Fletcher and Leyffer 2002; conditions as in Wächter and Biegler 2005). No penalty weight has to be guessed, and
//! iterates may pass through large defects.

use crate::transcription::Merit;

/// Largest sum of defects of an iterate, relative to that of the guess (but at least 1). Large defects are the short way to most
/// solutions; where that leads astray, as with unstable dynamics over a long horizon, the second attempt keeps closer to what the
/// dynamics can do.
pub(super) const WIDEST: [f64; 2] = [1e4, 5.0];

/// Fraction of the defect by which defect or objective must improve.
const MARGIN: f64 = 1e-5;
/// Fraction of the decrease promised by the program that an almost feasible step must realize.
const ARMIJO: f64 = 1e-4;
/// Defect, relative to that of the first (but at least 1), below which only the objective decides.
const NARROW: f64 = 1e-4;
/// Rounding errors of an objective, relative to it.
const ROUNDING: f64 = 1e-13;

/// What became of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The objective falls at a small defect.
    Descent,
    /// Acceptable; the iterate that is left goes into the filter.
    Progress,
    /// Not acceptable.
    Rejected,
}

/// Pairs of defect and objective that no later iterate may fall short of.
#[derive(Clone, Debug)]
pub(crate) struct Filter {
    entries: Vec<(f64, f64)>,
    widest: f64,
    narrow: f64,
}

impl Filter {
    /// An empty filter for an iteration that starts here. `widest` is the largest sum of defects of an iterate, relative to that of
    /// the start (but at least 1).
    pub(crate) fn new(start: &Merit, widest: f64) -> Self {
        Self::with_entries(Vec::new(), start, widest)
    }

    /// As [`Filter::new`], in the memory of an empty list.
    pub(crate) fn with_entries(entries: Vec<(f64, f64)>, start: &Merit, widest: f64) -> Self {
        let unit = start.defects.max(1.0);
        Self { entries, widest: widest * unit, narrow: NARROW * unit }
    }

    /// The memory of its entries.
    pub(crate) fn into_entries(self) -> Vec<(f64, f64)> {
        self.entries
    }

    /// Judges a step of which the program promises that the objective falls by `promised`.
    pub(crate) fn judge(&self, now: &Merit, trial: &Merit, promised: f64) -> Verdict {
        let finite = trial.defects.is_finite() && trial.objective.is_finite();
        if !finite || !self.accepts(trial) {
            return Verdict::Rejected;
        }
        let fall = now.objective - trial.objective;
        let rounding = ROUNDING * now.objective.abs();
        if self.is_narrow(now) && self.is_narrow(trial) && promised > now.defects {
            let enough = fall >= ARMIJO * promised - rounding;
            return if enough { Verdict::Descent } else { Verdict::Rejected };
        }
        if improves(trial, (now.defects, now.objective + rounding)) { Verdict::Progress } else { Verdict::Rejected }
    }

    /// Whether an iterate improves on everything in the filter.
    pub(crate) fn accepts(&self, trial: &Merit) -> bool {
        trial.defects <= self.widest && self.entries.iter().all(|&e| improves(trial, e))
    }

    /// Whether the defects of an iterate are so small that the objective decides.
    pub(crate) fn is_narrow(&self, now: &Merit) -> bool {
        now.defects <= self.narrow
    }

    /// Forbids everything that is no better than this iterate.
    pub(crate) fn add(&mut self, left: &Merit) {
        self.entries.retain(|&(defects, objective)| defects < left.defects || objective < left.objective);
        self.entries.push((left.defects, left.objective));
    }
}

/// Without defects before, only the objective can improve.
fn improves(trial: &Merit, (defects, objective): (f64, f64)) -> bool {
    trial.defects < (1.0 - MARGIN) * defects || trial.objective <= objective - MARGIN * defects
}
