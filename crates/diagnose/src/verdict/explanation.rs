//! Sets of candidates with their fits, and those that the linearized problem promises.

use super::alarm::Alarm;
use crate::settings::SearchSettings;
use crate::{Effect, Fit, Role};

/// A set of candidates, fitted together.
#[derive(Clone, Debug)]
pub(crate) struct Explanation {
    /// Places among the candidates, in the order in which they came.
    pub(crate) members: Vec<usize>,
    /// The fit.
    pub(crate) fit: Fit,
    /// Its residual.
    pub(crate) alarm: Alarm,
    /// Number of the effects' coefficients.
    pub(crate) coefficients: usize,
    /// Whether every amplitude has the sign that physics wants.
    pub(crate) physical: bool,
}

impl Explanation {
    /// Numbers that are fitted for its effects: coefficients, and in every window the starts of the states that they add.
    pub(crate) fn numbers(&self) -> usize {
        self.coefficients + self.fit.hidden_states() * self.fit.windows.len()
    }

    pub(crate) fn square(&self) -> f64 {
        self.alarm.square
    }

    /// Whether causes remove all of the residual of `base` but for what the inexactness of any law leaves, and that is near
    /// the noise: a further name would be given to it.
    pub(crate) fn spans(&self, base: &Explanation, settings: &SearchSettings) -> bool {
        !self.members.is_empty()
            && self.alarm.size < settings.near_noise
            && self.alarm.excess() < settings.inexact * base.alarm.excess()
    }

    /// Names of the model's parameters that stopped at a limit, except those that fell there below the share `vanished` of their nominal
    /// value.
    pub(crate) fn stopped(&self, vanished: f64) -> impl Iterator<Item = &str> {
        let parameters = self.fit.values.len() - self.coefficients;
        let limited = self.fit.limited.iter().filter(move |&&i| i < parameters);
        limited
            .map(|&i| &self.fit.values[i])
            .filter(move |e| e.value.abs() > vanished * e.nominal.abs())
            .map(|e| e.name.as_str())
    }

    /// Sum of squares of an effect's amplitudes over their standard deviations: about what it costs to leave it out, in units
    /// of the residual's variance.
    pub(crate) fn expected_cost(&self, effect: &Effect) -> f64 {
        let amplitudes = effect.coefficients.iter().filter(|c| c.role == Role::Amplitude);
        amplitudes
            .filter_map(|c| Some((c, self.fit.estimate(&c.name)?)))
            .map(|(c, e)| ((e.value - c.nominal) / e.std.max(f64::MIN_POSITIVE)).powi(2))
            .sum()
    }

    /// Parameters of the model that had to change by more than `tolerance`, relative to their value.
    pub(crate) fn moved_parameters(&self, tolerance: f64) -> usize {
        let parameters = self.fit.values.len() - self.coefficients;
        (0..parameters)
            .filter(|i| !self.fit.unidentified.contains(i))
            .map(|i| &self.fit.values[i])
            .filter(|e| (e.value - e.nominal).abs() > tolerance * e.nominal.abs())
            .count()
    }
}

/// A set of candidates with what the linearized problem promises.
#[derive(Clone, Debug)]
pub(crate) struct Promise {
    /// Candidates to add.
    pub(crate) candidates: Vec<usize>,
    /// Decrease of the sum of squares.
    pub(crate) square: f64,
    /// Coefficients that it takes, shapes included.
    pub(crate) coefficients: usize,
    /// Where an exact fit should begin: names and values.
    pub(crate) start: Vec<(String, f64)>,
}
