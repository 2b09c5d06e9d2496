//! A window in a fit, and how it is explained.

use super::compiled::Compiled;
use super::linearization::Normal;
use super::normal::{Eliminated, Full, Point, States, residual, settle, simulate};
use super::runner::{Failure, Runner};

/// How a window is explained.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowFit {
    /// Index of the window.
    pub window: usize,
    /// Fitted initial state, at the window's first sample (earlier by the longest sensor delay).
    pub x0: Vec<f64>,
    /// Sum of squared residuals over noise, `Σ(r/σ)²`.
    pub square: f64,
    /// Number of residuals.
    pub count: usize,
    /// Measured − simulated over noise, one list per measured column of the record; NaN where the measurement was lost.
    pub residuals: Vec<Vec<f64>>,
    /// Why the window could not be simulated, and when; then there are no residuals.
    pub failure: Option<String>,
}

/// A window in a fit.
pub(super) struct Slot<'a> {
    pub(super) index: usize,
    pub(super) runner: Runner<'a>,
    /// Whether `start` was fitted before.
    pub(super) known: bool,
    /// Initial value of the fit of the initial state.
    pub(super) start: Vec<f64>,
    /// Mean of the initial state's prior.
    pub(super) guess: Vec<f64>,
    pub(super) scales: Vec<f64>,
    pub(super) state: Result<Point, Failure>,
}

impl Slot<'_> {
    pub(super) fn states(&self) -> States<'_> {
        States::new(&self.guess, &self.scales, self.runner.compiled.settings.priors.state)
    }

    pub(super) fn cost(&self) -> f64 {
        self.state.as_ref().map_or(0.0, |p| p.square + self.states().penalty(&p.x0))
    }

    /// Fits the initial state until the sum of squares falls by less than `share` of it.
    pub(super) fn settle(&mut self, compiled: &Compiled, theta: &[f64], share: f64) {
        let states = States::new(&self.guess, &self.scales, compiled.settings.priors.state);
        self.state = settle(&mut self.runner, compiled, theta, &self.start, &states, share);
    }

    /// Takes an initial state that was fitted with the same values of the unknowns, fits it otherwise.
    pub(super) fn resume(&mut self, compiled: &Compiled, theta: &[f64]) {
        if self.known {
            self.state = simulate(&mut self.runner, theta, &self.start);
        } else {
            self.settle(compiled, theta, compiled.settings.solver.settled_share);
        }
    }

    /// The normal equations with the initial state eliminated.
    pub(super) fn normal(&self, full: &Full) -> Option<Normal> {
        let point = self.state.as_ref().ok()?;
        let e = Eliminated::new(full, &point.x0, &self.states(), 0.0)?;
        Some(Normal {
            window: self.index,
            gram: e.gram,
            gradient: e.gradient,
            square: (full.square - e.gain).max(0.0),
            count: self.runner.present.iter().filter(|p| **p).count(),
        })
    }

    pub(super) fn report(&self) -> WindowFit {
        let samples = self.runner.samples();
        match &self.state {
            Ok(point) => {
                let r = residual(&self.runner, point);
                let residuals = (0..self.runner.weights.len())
                    .map(|c| {
                        (c * samples..(c + 1) * samples)
                            .map(|at| if self.runner.present[at] { r[at] } else { f64::NAN })
                            .collect()
                    })
                    .collect();
                WindowFit {
                    window: self.index,
                    x0: point.x0.clone(),
                    square: point.square,
                    count: self.runner.present.iter().filter(|p| **p).count(),
                    residuals,
                    failure: None,
                }
            }
            Err(failure) => WindowFit {
                window: self.index,
                x0: self.guess.clone(),
                square: 0.0,
                count: 0,
                residuals: Vec::new(),
                failure: Some(failure.to_string()),
            },
        }
    }
}
