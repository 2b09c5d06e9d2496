//! What moves the plate in a run, and when the object model is told of a change.

use super::setup::PlateSetup;
use crate::log::LoggedMotion;
use crate::motion::ExpressionMotion;
use crate::{PlateKinematics, PlateMotion};

/// What moves the plate.
#[derive(Clone, Debug)]
pub(super) enum ImposedMotion {
    /// The experiment's formula with live numbers.
    Formula(ExpressionMotion),
    /// A logged motion, and the time whose smooth piece holds.
    Logged(LoggedMotion, f64),
}

impl ImposedMotion {
    pub(super) fn set_amplitude(&mut self, amplitude: f64) {
        if let Self::Formula(motion) = self {
            motion.set("A", amplitude);
        }
    }

    /// Takes the smooth piece that starts at `t`.
    pub(super) fn start_piece(&mut self, t: f64) {
        if let Self::Logged(_, piece) = self {
            *piece = t;
        }
    }
}

impl PlateMotion for ImposedMotion {
    fn at(&mut self, t: f64) -> PlateKinematics {
        match self {
            Self::Formula(motion) => motion.at(t),
            Self::Logged(motion, piece) => motion.within(*piece, t),
        }
    }
}

/// The times at which the periods of an experiment or the smooth pieces of a logged motion start.
pub(super) enum Schedule {
    Periods {
        from: f64,
        period: f64,
        count: usize,
    },
    /// The latest first.
    Pieces(Vec<f64>),
}

impl Schedule {
    pub(super) fn new(setup: &PlateSetup, motion: &ImposedMotion) -> Self {
        match motion {
            ImposedMotion::Formula(_) => Self::Periods { from: setup.from, period: setup.experiment.period, count: 0 },
            ImposedMotion::Logged(motion, _) => {
                Self::Pieces(motion.jumps().iter().map(|j| j.t).filter(|t| *t > setup.from).rev().collect())
            }
        }
    }

    /// Takes the next time if it is not after `end`.
    pub(super) fn next_until(&mut self, end: f64) -> Option<f64> {
        match self {
            Self::Periods { from, period, count } => {
                let next = *from + *count as f64 * *period;
                (next <= end).then(|| {
                    *count += 1;
                    next
                })
            }
            Self::Pieces(pieces) => pieces.pop_if(|t| *t <= end),
        }
    }
}
