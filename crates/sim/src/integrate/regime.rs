//! When steps are stiff ones: where stability, not accuracy, limits the explicit ones, as long as that pays.

use super::step::{Method, Step};
use super::tableau::A;
use crate::settings::SimulationSettings;

/// The explicit pair is stable along the negative axis up to this length times the largest rate.
const STABLE: f64 = 3.25;
/// Explicit steps at the limit of stability, and within it, that decide (Hairer and Wanner 1996, section IV.2).
const SUSPECT: usize = 15;
const CLEARED: usize = 20;
/// Every how many steps the rate is measured where nothing is suspected.
const SAMPLED: usize = 32;
/// Evaluations of an explicit step.
const STAGES: f64 = 6.0;
/// Stiff steps after which they have to have paid, and the most explicit steps between two trials.
const TRIAL: usize = 8;
const MOST_PATIENT: usize = 2000;

/// Whether the field is stiff, by the steps so far.
#[derive(Debug, Clone)]
pub(crate) struct Regime {
    stiff: bool,
    /// Explicit steps, those of them at the limit of stability, and those within it since.
    steps: usize,
    limited: usize,
    cleared: usize,
    /// Explicit steps at the limit that make it stiff.
    patience: usize,
    /// Stiff steps of this trial, the time they covered, and their work in evaluations.
    tried: usize,
    covered: f64,
    effort: f64,
}

impl Regime {
    pub(crate) fn new() -> Self {
        Self { stiff: false, steps: 0, limited: 0, cleared: 0, patience: SUSPECT, tried: 0, covered: 0.0, effort: 0.0 }
    }

    pub(crate) fn is_stiff(&self) -> bool {
        self.stiff
    }

    /// Takes note of the step of length `h` that is about to be accepted.
    pub(crate) fn note(&mut self, step: &mut Step, h: f64, settings: &SimulationSettings) {
        match step.method {
            Method::Explicit => {
                self.steps += 1;
                if self.limited > 0 || self.steps.is_multiple_of(SAMPLED) {
                    self.measure(step, h, settings);
                }
            }
            Method::Stiff => self.note_stiff(step, h),
            Method::Directions => {}
        }
    }

    /// The last two stages lie at the same time: what their fields differ by, over their distance, is a rate of the field.
    fn measure(&mut self, step: &Step, h: f64, settings: &SimulationSettings) {
        let (mut apart, mut by) = (0.0, 0.0);
        for (j, end) in step.end.iter().enumerate() {
            let stage = step.x[j] + h * (0..5).map(|l| A[5][l] * step.k[l][j]).sum::<f64>();
            let scale = settings.scale(end.abs());
            apart += ((end - stage) / scale).powi(2);
            by += ((step.k[6][j] - step.k[5][j]) / scale).powi(2);
        }
        if h * h * by > STABLE * STABLE * apart {
            self.limited += 1;
            self.cleared = 0;
            if self.limited >= self.patience {
                (self.stiff, self.limited) = (true, 0);
                (self.tried, self.covered, self.effort) = (0, 0.0, 0.0);
            }
        } else if self.limited > 0 {
            self.cleared += 1;
            if self.cleared >= CLEARED {
                self.limited = 0;
            }
        }
    }

    /// Stiff steps go on as long as they get further, for their work, than explicit ones at the limit of stability would.
    fn note_stiff(&mut self, step: &mut Step, h: f64) {
        self.tried += 1;
        self.covered += h;
        self.effort += step.newton.take_effort();
        if self.tried < TRIAL {
            return;
        }
        let explicit = STABLE / step.newton.norm() / STAGES;
        if self.covered < explicit * self.effort {
            self.give_up();
        }
        (self.tried, self.covered, self.effort) = (0, 0.0, 0.0);
    }

    /// Takes note of a step of length `h` that was too inaccurate: beyond the limit of stability, that is why.
    pub(crate) fn note_rejected(&mut self, step: &Step, h: f64, settings: &SimulationSettings) {
        if step.method == Method::Explicit {
            self.measure(step, h, settings);
        }
    }

    /// A step of length `h` could not be solved: where an explicit one is stable, it is the one to take.
    pub(crate) fn note_failure(&mut self, step: &Step, h: f64) {
        if step.method == Method::Stiff && h * step.newton.norm() < STABLE {
            self.give_up();
        }
    }

    fn give_up(&mut self) {
        self.stiff = false;
        (self.limited, self.cleared) = (0, 0);
        self.patience = (2 * self.patience).min(MOST_PATIENT);
    }
}
