//! The sign that the amplitude had in a log.

use super::period_start::SignSource;
use super::setup::PlateSetup;
use crate::experiment::{Coordinate, Experiment};
use crate::{PlateError, PlateLog, PlateMotion};
use bracketry_numerics::spline::noise;

/// An error of more standard deviations is not a matter of noise.
pub(super) const DEVIATIONS: f64 = 3.0;
/// Least share of the smallest amplitude that a logged plate must have moved with for its sign to count.
const SHARE: f64 = 0.5;
/// Least number of rows of the log in a period from which a sign is read.
const ROWS: usize = 4;

/// The signs that the amplitude had in a log of an experiment with an amplitude law.
pub(super) struct LogSigns<'a> {
    log: &'a PlateLog,
    experiment: &'a Experiment,
    from: f64,
    column: &'a [f64],
    /// Standard deviation of the noise in it.
    pub(super) noise: f64,
    /// Whether the plate jumps where the amplitude changes, and with it the coordinate.
    jumps: bool,
}

/// The error of the log at some time.
#[derive(Clone, Copy, Debug)]
pub(super) struct LoggedError {
    /// `q − q_desired`, m or rad.
    pub(super) value: f64,
    /// Its standard deviation.
    pub(super) deviation: f64,
}

impl<'a> LogSigns<'a> {
    /// With the noise that the setup gives, else with that of the log.
    pub(super) fn new(setup: &'a PlateSetup, log: &'a PlateLog) -> Self {
        let experiment = &setup.experiment;
        let column: &[f64] = [&log.x, &log.y, &log.phi][experiment.index()];
        let noise = setup.noise.unwrap_or_else(|| noise(column));
        Self { log, experiment, from: setup.from, column, noise, jumps: experiment.coordinate == Coordinate::X }
    }

    /// The rows of the log after `t` within the period that starts there.
    fn rows(&self, t: f64) -> std::ops::Range<usize> {
        let (slack, end) = (1e-9 * self.experiment.period, t + self.experiment.period);
        self.log.t.partition_point(|s| *s <= t + slack)..self.log.t.partition_point(|s| *s < end - slack)
    }

    /// Times and values of the coordinate after `t` within the period that starts there, at most `most`; none if there are too
    /// few to read a sign from.
    pub(super) fn motion_after(&self, t: f64, most: usize) -> Option<Vec<(f64, f64)>> {
        let rows = self.rows(t);
        let stride = rows.len().div_ceil(most).max(1);
        let motion: Vec<(f64, f64)> = rows.step_by(stride).map(|k| (self.log.t[k], self.column[k])).collect();
        (motion.len() >= ROWS).then_some(motion)
    }

    /// The error at `t`, by a polynomial through the rows around it; where the plate jumps then, through those before it. None
    /// without such rows.
    pub(super) fn error(&self, t: f64) -> Option<LoggedError> {
        let slack = 1e-9 * self.experiment.period;
        let next = self.log.t.partition_point(|s| *s < t - slack);
        if next == 0 && self.log.t[0] <= t + slack {
            // The start, where the plate is at rest.
            return Some(LoggedError { value: self.column[0] - self.experiment.target, deviation: self.noise });
        }
        let (rows, degree) = if self.jumps {
            (next.checked_sub(5)?..next, 2)
        } else {
            let from = next.checked_sub(3)?;
            (from..from + 6, 3)
        };
        let (times, values) = (self.log.t.get(rows.clone())?, self.column.get(rows)?);
        let fit = LocalFit::new(times, t, degree);
        Some(LoggedError {
            value: fit.value(values) - self.experiment.target,
            deviation: fit.amplification() * self.noise.max(fit.misfit(values)),
        })
    }

    /// The sign at the start `t` of a period, from the motion of the plate if it is logged, else from the error if that is not
    /// a matter of noise.
    ///
    /// # Errors
    /// [`PlateError`] if the motion of the experiment cannot be read.
    pub(super) fn known(&self, t: f64) -> Result<Option<(f64, SignSource)>, PlateError> {
        if let Some(sign) = self.of_plate(t)? {
            return Ok(Some((sign, SignSource::LoggedPlate)));
        }
        let error = self.error(t).filter(|e| e.value.abs() > DEVIATIONS * e.deviation);
        Ok(error.map(|e| (self.experiment.amplitude(e.value).signum(), SignSource::LoggedError)))
    }

    /// The sign of the amplitude with which the logged plate moved in the period that starts at `t`.
    fn of_plate(&self, t: f64) -> Result<Option<f64>, PlateError> {
        let (Some(plate), Some(law)) = (&self.log.plate, self.experiment.law) else { return Ok(None) };
        let rows = self.rows(t);
        if rows.len() < ROWS {
            return Ok(None);
        }
        let mut motion = self.experiment.motion(self.from)?;
        let mut at = |amplitude: f64, k: usize| {
            motion.set("A", amplitude);
            let now = motion.at(self.log.t[k]);
            [now.displacement, now.tilt]
        };
        let (mut product, mut square) = (0.0, 0.0);
        for k in rows {
            let (zero, one) = (at(0.0, k), at(1.0, k));
            for (i, logged) in [plate.displacement[k], plate.tilt[k]].into_iter().enumerate() {
                let shape = one[i] - zero[i];
                product += shape * (logged - zero[i]);
                square += shape * shape;
            }
        }
        let amplitude = product / square;
        Ok((amplitude.abs() >= SHARE * law.offset.abs()).then(|| amplitude.signum()))
    }
}

/// A polynomial fitted to a few samples by least squares, by the weight of each in the value at some time.
struct LocalFit {
    /// Orthonormal polynomials at the samples, and their values at the time.
    basis: Vec<(Vec<f64>, f64)>,
    weights: Vec<f64>,
}

impl LocalFit {
    fn new(times: &[f64], t: f64, degree: usize) -> Self {
        let reach = times.iter().map(|s| (s - t).abs()).fold(f64::MIN_POSITIVE, f64::max);
        let mut basis: Vec<(Vec<f64>, f64)> = Vec::new();
        for power in 0..=degree {
            let mut column: Vec<f64> = times.iter().map(|s| ((s - t) / reach).powi(power as i32)).collect();
            let mut value = if power == 0 { 1.0 } else { 0.0 };
            for (known, known_value) in &basis {
                let part: f64 = column.iter().zip(known).map(|(c, k)| c * k).sum();
                column.iter_mut().zip(known).for_each(|(c, k)| *c -= part * k);
                value -= part * known_value;
            }
            let length = column.iter().map(|c| c * c).sum::<f64>().sqrt();
            for c in &mut column {
                *c /= length;
            }
            basis.push((column, value / length));
        }
        let weights = (0..times.len()).map(|k| basis.iter().map(|(column, value)| column[k] * value).sum()).collect();
        Self { basis, weights }
    }

    fn value(&self, values: &[f64]) -> f64 {
        self.weights.iter().zip(values).map(|(w, v)| w * v).sum()
    }

    /// Standard deviation of the value per that of a sample.
    fn amplification(&self) -> f64 {
        self.weights.iter().map(|w| w * w).sum::<f64>().sqrt()
    }

    /// Root mean square of what the polynomial leaves of the samples, per degree of freedom.
    fn misfit(&self, values: &[f64]) -> f64 {
        let mut left = values.to_vec();
        for (column, _) in &self.basis {
            let part: f64 = column.iter().zip(&left).map(|(c, v)| c * v).sum();
            left.iter_mut().zip(column).for_each(|(v, c)| *v -= part * c);
        }
        let freedom = values.len() - self.basis.len();
        (left.iter().map(|v| v * v).sum::<f64>() / freedom as f64).sqrt()
    }
}
