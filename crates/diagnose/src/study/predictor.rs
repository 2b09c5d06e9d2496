//! Predictions of a fitted model over any stretch of a record.

use super::compiled::Compiled;
use super::fit::{Estimate, Fit, FitStatus};
use super::multiple_shooting::{Study, theta_of};
use super::normal::simulate;
use super::runner::{Failure, Runner};
use super::slot::Slot;
use super::unknown::Unknown;
use super::window::Window;
use crate::error::DiagnoseError;
use nalgebra::{DMatrix, DVector};

/// A fitted model, compiled, to predict with.
pub struct Predictor<'a> {
    study: &'a Study,
    compiled: Compiled,
    theta: Vec<f64>,
}

impl Study {
    /// The model as it was given: parameters at their values, no effects, no windows. Standard deviations are those of the prior.
    pub fn nominal(&self) -> Fit {
        let parameters = self.parameters.iter().map(|&i| &self.system.parameters[i]);
        let unknowns: Vec<Unknown> =
            parameters.map(|p| Unknown::parameter(&self.system, p, &self.settings.priors)).collect();
        let variances = unknowns.iter().map(|u| u.prior * u.prior);
        Fit {
            effects: Vec::new(),
            covariance: DMatrix::from_diagonal(&DVector::from_iterator(unknowns.len(), variances)),
            values: unknowns
                .into_iter()
                .map(|u| Estimate { name: u.name, nominal: u.nominal, value: u.nominal, std: u.prior })
                .collect(),
            windows: Vec::new(),
            unidentified: Vec::new(),
            limited: Vec::new(),
            status: FitStatus::Converged,
        }
    }

    /// Compiles a fit for predictions.
    ///
    /// # Errors
    /// [`DiagnoseError`] for effects that do not fit the model.
    pub fn predictor(&self, fit: &Fit) -> Result<Predictor<'_>, DiagnoseError> {
        let compiled = self.compiled(&fit.effects)?;
        Ok(Predictor { study: self, compiled, theta: theta_of(fit) })
    }
}

impl Predictor<'_> {
    /// The initial state at the first sample of a stretch (earlier by the longest sensor delay), and after it what the filter of each
    /// measured column shows first (NaN without one), fitted to the samples of the stretch alone; why and when the simulation ended where that is not possible.
    ///
    /// # Errors
    /// [`DiagnoseError::NoSuchStretch`] for a stretch of fewer than two samples or beyond its record.
    pub fn fit_initial_state(&self, stretch: Window) -> Result<Result<Vec<f64>, String>, DiagnoseError> {
        let runner = self.runner(stretch)?;
        let record = &self.study.sources.records[stretch.record];
        let guess = &self.study.guesses[stretch.record];
        let (start, scales) = self.study.guessed(guess, &self.compiled, guess.at(record, stretch));
        let state = Err(Failure::not_simulated());
        let mut slot = Slot { index: 0, runner, known: false, start: start.clone(), guess: start, scales, state };
        slot.settle(&self.compiled, &self.theta, self.compiled.settings.solver.settled_share);
        if slot.runner.fitted_starts() == 0 {
            return Ok(slot.state.map(|point| point.x0).map_err(|failure| failure.to_string()));
        }
        let settled = slot.state.and_then(|point| simulate(&mut slot.runner, &self.theta, &point.x0));
        let starts = slot.runner.trajectory.filter_starts.iter().zip(&slot.runner.weights).map(|(s, w)| s / w);
        Ok(settled.map(|point| point.x0.into_iter().chain(starts).collect()).map_err(|failure| failure.to_string()))
    }

    /// What every measured column of the record would show at every sample of a stretch, from an initial state as
    /// [`Predictor::fit_initial_state`] gives it; NaN after a simulation that stopped.
    ///
    /// # Errors
    /// [`DiagnoseError::NoSuchStretch`] for a stretch of fewer than two samples or beyond its record.
    pub fn predict(&self, stretch: Window, x0: &[f64]) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let mut runner = self.runner(stretch)?;
        runner.weights.fill(1.0);
        runner.present.fill(true);
        let (x0, starts) = x0.split_at((self.study.system.states.len() + self.compiled.hidden.len()).min(x0.len()));
        runner.filter_starts = Some(starts.to_vec()).filter(|s| s.len() == runner.weights.len());
        let mut out = vec![f64::NAN; runner.target.len()];
        // Where it stops, the rest stays NaN.
        let _stopped = runner.simulate(&self.theta, x0, &mut out);
        Ok(out.chunks(runner.samples()).map(<[f64]>::to_vec).collect())
    }

    fn runner(&self, stretch: Window) -> Result<Runner<'_>, DiagnoseError> {
        let record = self.study.sources.records.get(stretch.record);
        let samples = record.map_or(0, |r| r.times.len());
        if stretch.from + 2 > stretch.to || stretch.to > samples {
            return Err(DiagnoseError::NoSuchStretch {
                record: stretch.record,
                from: stretch.from,
                to: stretch.to,
                samples,
            });
        }
        let noise = &self.study.noise[stretch.record];
        Runner::new(&self.study.sources.records, &self.compiled, stretch, noise)
    }
}
