//! What a refit of one explanation to the output of another one leaves.

use crate::exact::{Exact, Free, Run};
use crate::options::ExperimentError;
use crate::signals::Signals;
use bracketry_numerics::least_squares::{Problem, Settings, minimize};
use nalgebra::{DMatrix, DVector};

/// A refit moves a parameter without limits of its own down to zero and up to a hundred times its value: with a narrower range, plans exploit
/// its ends.
const FREE_RANGE: [f64; 2] = [-1.0, 99.0];
/// The same for a parameter that is zero.
const FREE_RANGE_OF_ZERO: f64 = 100.0;
/// Relative step of the derivatives by parameters: far above the tolerance of the simulation, far below what a refit moves.
const STEP: f64 = 1e-4;
/// Most steps of a refit, and the decrease of the sum of squares at which it ends.
const SETTLED: (usize, f64) = (25, 1e-5);
/// Combinations of parameters below this part of the strongest one are left as they are.
const RANK: f64 = 1e-8;

/// The exact output of a model as a function of relative changes of its free parameters.
pub(crate) struct Fitted<'a> {
    exact: &'a Exact<'a>,
    signals: &'a Signals,
    free: &'a [Free],
    noise: &'a [f64],
    /// What it is compared with, one row per sample; zeros where there is nothing.
    truth: Option<&'a Run>,
    limits: Vec<[f64; 2]>,
    /// An error of a simulation that cannot be set up.
    error: Option<ExperimentError>,
}

impl<'a> Fitted<'a> {
    pub(crate) fn new(
        exact: &'a Exact<'a>,
        signals: &'a Signals,
        free: &'a [Free],
        noise: &'a [f64],
        truth: Option<&'a Run>,
    ) -> Self {
        let limits = free.iter().map(Free::relative_range).collect();
        Self { exact, signals, free, noise, truth, limits, error: None }
    }

    fn outputs(&mut self, at: &DVector<f64>) -> Option<DVector<f64>> {
        let values: Vec<(&Free, f64)> =
            self.free.iter().zip(at.iter()).map(|(p, z)| (p, p.value + z * p.scale)).collect();
        let run = match self.exact.run(self.signals, &values) {
            Ok(run) => run?,
            Err(e) => {
                self.error = Some(e);
                return None;
            }
        };
        let rows = run.outputs.iter().enumerate().flat_map(|(k, y)| {
            let truth = self.truth.map(|t| &t.outputs[k]);
            y.iter().zip(self.noise).enumerate().map(move |(i, (y, std))| (y - truth.map_or(0.0, |t| t[i])) / std)
        });
        Some(DVector::from_iterator(run.outputs.len() * self.noise.len(), rows))
    }

    /// A matrix with a column per variable, from the points a step above and below.
    fn differences(
        &mut self,
        at: &DVector<f64>,
        column: impl Fn(&mut Self, [DVector<f64>; 2]) -> Option<DVector<f64>>,
    ) -> Option<DMatrix<f64>> {
        let columns = (0..at.len()).map(|j| {
            let moved = [STEP, -STEP].map(|step| {
                let mut moved = at.clone();
                moved[j] += step;
                moved
            });
            column(self, moved)
        });
        let columns = columns.collect::<Option<Vec<_>>>()?;
        let rows = columns.first().map_or(0, DVector::len);
        Some(if columns.is_empty() { DMatrix::zeros(rows, 0) } else { DMatrix::from_columns(&columns) })
    }

    /// The derivatives of the outputs, in units of the noise, by relative changes of the parameters; none where a simulation stops.
    pub(crate) fn sensitivities(&mut self) -> Result<Option<DMatrix<f64>>, ExperimentError> {
        let at = DVector::zeros(self.free.len());
        let jacobian = self.differences(&at, |fitted, moved| {
            let [up, down] = moved.map(|at| fitted.outputs(&at));
            Some((up? - down?) / (2.0 * STEP))
        });
        match self.error.take() {
            Some(error) => Err(error),
            None => Ok(jacobian),
        }
    }

    /// The least sum of squares of the differences, with the parameters at which it is reached, from the best of several starts.
    pub(crate) fn refit(mut self, starts: &[Vec<f64>]) -> Result<Option<Refit>, ExperimentError> {
        let settings = Settings {
            iterations: SETTLED.0,
            settled: SETTLED.1,
            scaled: true,
            rank: RANK,
            longest: 1.0,
            ..Settings::default()
        };
        let mut best: Option<Refit> = None;
        for start in starts {
            let relative = self.free.iter().zip(start).map(|(p, v)| (v - p.value) / p.scale);
            let start = DVector::from_iterator(self.free.len(), relative);
            let found = minimize(&mut self, &start, &settings);
            if let Some(error) = self.error.take() {
                return Err(error);
            }
            let Some(found) = found else { continue };
            let square = found.residual.norm_squared();
            if best.as_ref().is_none_or(|b| square < b.square) {
                let values = self.free.iter().zip(found.at.iter()).map(|(p, z)| p.value + z * p.scale).collect();
                best = Some(Refit { square, values });
            }
        }
        Ok(best)
    }
}

/// A refit and what it leaves.
#[derive(Clone, Debug)]
pub(crate) struct Refit {
    /// Sum of squares of the differences in units of the noise.
    pub(crate) square: f64,
    /// Values of the free parameters.
    pub(crate) values: Vec<f64>,
}

impl Free {
    /// How far a refit may go, relative to the value.
    fn relative_range(&self) -> [f64; 2] {
        let own = if self.value == 0.0 { [-FREE_RANGE_OF_ZERO, FREE_RANGE_OF_ZERO] } else { FREE_RANGE };
        let [low, high] = self.range.map(|end| (end - self.value) / self.scale);
        // A limit of the model says more than the range of one without limits.
        [if low.is_finite() { low } else { own[0] }, if high.is_finite() { high } else { own[1] }]
    }
}

impl Problem for Fitted<'_> {
    fn residual(&mut self, at: &DVector<f64>) -> Option<DVector<f64>> {
        self.outputs(at)
    }

    /// By forward differences, at half the cost of central ones.
    fn jacobian(&mut self, at: &DVector<f64>, residual: &DVector<f64>) -> Option<DMatrix<f64>> {
        self.differences(at, |fitted, moved| {
            let [up, down] = moved;
            match fitted.outputs(&up) {
                Some(up) => Some((up - residual) / STEP),
                // Where one side cannot be simulated, the other one is enough.
                None => fitted.outputs(&down).map(|down| (residual - down) / STEP),
            }
        })
    }

    fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }
}
