//! What follows from the fits of a report: intervals, the extended model, the gain.

use nalgebra::{DMatrix, DVector};

use super::diagnosis::Report;
use super::note::Note;
use crate::error::DiagnoseError;
use crate::extend::ExtendedModel;
use crate::gain::{Fitted, bootstrap, measure_gain};
use crate::record::Record;
use crate::settings::DiagnosisSettings;
use crate::study::{Estimate, Fit, Linearization, Study};

/// The fits of a report, to all windows of the study.
#[derive(Clone, Copy)]
pub(crate) struct Fits<'a> {
    /// The given model with its parameters refitted.
    pub(crate) refitted: &'a Fit,
    /// The model with the causes.
    pub(crate) extended: &'a Fit,
    /// The factor by which correlation of the residuals widens standard deviations.
    pub(crate) width: f64,
}

/// Half the width of an interval of 95 % in standard deviations.
const NORMAL: f64 = 1.96;

impl Report {
    /// Adds to a report with causes the intervals of its numbers, the extended model, and the gain. Other reports get the fits
    /// and intervals only.
    pub(crate) fn complete(
        &mut self,
        study: &Study,
        fits: Fits<'_>,
        validate: &[Record],
        settings: &DiagnosisSettings,
    ) -> Result<(), DiagnoseError> {
        let Fits { refitted, extended, width } = fits;
        let all: Vec<usize> = (0..study.windows().len()).collect();
        let at_extended = study.linearize(extended, &[], &all)?;
        let Intervals { of_values, hardly, combined, alike } = intervals(extended, &at_extended, width, settings);
        for (estimate, interval) in extended.values.iter().zip(of_values) {
            if let Some(interval) = interval {
                self.set_interval(&estimate.name, interval);
            }
        }
        self.note_limits(refitted, extended);
        let name = |&j: &usize| extended.values.get(j).map(|e| e.name.clone());
        let hardly: Vec<String> = hardly.iter().filter_map(name).collect();
        if !hardly.is_empty() {
            self.notes.push(Note::HardlyIdentifiable(hardly));
        }
        if !combined.is_empty() {
            self.notes.push(Note::OnlyInCombination(combined));
        }
        if !alike.is_empty() {
            self.notes.push(Note::NoInterval(alike));
        }
        self.evidence.refitted = Some(refitted.clone());
        if !self.verdict.extends_the_model() {
            // Nothing is gained, but what the model predicts is to be seen.
            let at = study.linearize(refitted, &[], &all)?;
            let fitted = Fitted { refitted, at_refitted: &at, extended: refitted, at_extended: &at };
            self.evidence.held_out = measure_gain(study, &fitted, validate, settings)?.map(|(_, held_out)| held_out);
            return Ok(());
        }
        self.evidence.extended = Some(extended.clone());
        let model = ExtendedModel::new(study.system(), extended, width)?;
        self.notes.extend(model.notes.iter().cloned().map(Note::ExtendedModel));
        self.evidence.model = Some(model);
        let at_refitted = study.linearize(refitted, &[], &all)?;
        let fitted = Fitted { refitted, at_refitted: &at_refitted, extended, at_extended: &at_extended };
        match measure_gain(study, &fitted, validate, settings)? {
            Some((gain, held_out)) => {
                if gain.equation_error_after.is_none() {
                    self.notes.push(Note::NoForceError);
                }
                let wanted = settings.gain.predictions.horizons.iter().copied();
                let missing: Vec<f64> = wanted.filter(|h| !gain.horizons_s.contains(h)).collect();
                if !missing.is_empty() {
                    self.notes.push(Note::HorizonsTooLong(missing));
                }
                self.gain = Some(gain);
                if extended.effects.is_empty() {
                    self.notes.push(Note::OnlyParameters);
                }
                self.evidence.held_out = Some(held_out);
            }
            None => self.notes.push(Note::TooShortForGain),
        }
        Ok(())
    }

    /// Says which numbers stopped at a limit: they have no interval.
    fn note_limits(&mut self, refitted: &Fit, extended: &Fit) {
        for (fit, without_causes) in [(extended, false), (refitted, true)] {
            if without_causes && extended.effects.is_empty() {
                continue;
            }
            for estimate in fit.limited.iter().filter_map(|&j| fit.values.get(j)) {
                let (name, value) = (estimate.name.clone(), estimate.value);
                self.notes.push(Note::AtLimit { name, value, without_causes });
            }
        }
    }

    fn set_interval(&mut self, name: &str, interval: [f64; 2]) {
        for p in self.parameters.iter_mut().filter(|p| p.name == name) {
            p.interval = Some(interval);
        }
        for (_, value) in self.causes.iter_mut().flat_map(|c| &mut c.parameters.0).filter(|(n, _)| n == name) {
            value.interval = Some(interval);
        }
    }
}

/// The intervals of the values of a fit.
pub(crate) struct Intervals {
    /// One for each value that has one.
    pub(crate) of_values: Vec<Option<[f64; 2]>>,
    /// Places of values that the data hardly tell.
    hardly: Vec<usize>,
    /// Names of values that resamples tell hardly from each other because the prior holds them: the data determine only their combinations.
    combined: Vec<String>,
    /// Names of values that come out alike in all resamples, as where the sum of squares has a kink.
    alike: Vec<String>,
}

/// The intervals of the values of a fit, by its linearized problem. `width` is the factor by which correlation within windows widens
/// standard deviations.
pub(crate) fn intervals(fit: &Fit, at: &Linearization, width: f64, settings: &DiagnosisSettings) -> Intervals {
    let hardly = hardly_told(fit, at, width, settings.study.priors.unidentified_share);
    let mut of_values = vec![None; fit.values.len()];
    let (mut combined, mut alike) = (Vec::new(), Vec::new());
    let narrowest = settings.gain.narrowest_interval;
    let of_data = share_of_data(at);
    let single = of_one_window(at, fit.values.len(), settings.gain.most_of_one_window);
    let held: Vec<usize> = fit.limited.iter().chain(&single).copied().collect();
    let steps = bootstrap(at, &held, settings.gain.resamples, settings.seed).unwrap_or_default();
    for (j, (estimate, step)) in fit.values.iter().zip(steps).enumerate() {
        let half = NORMAL * estimate.widened(width);
        let step = if single.contains(&j) && !fit.limited.contains(&j) { Some([-half, half]) } else { step };
        // What the data do not tell keeps near the prior in every resample.
        let Some([low, high]) = step.filter(|_| !hardly.contains(&j)) else { continue };
        if high - low < narrowest * 2.0 * NORMAL * estimate.widened(width) {
            let held = of_data.get(j).is_some_and(|share| *share < narrowest * narrowest);
            if held { &mut combined } else { &mut alike }.push(estimate.name.clone());
        } else {
            let (min, max) = allowed(fit, &estimate.name);
            of_values[j] = Some([low, high].map(|s| (estimate.value + s).max(min).min(max)));
        }
    }
    Intervals { of_values, hardly, combined, alike }
}

/// Of each value, the share of its variance that noise in the data contributes: with `C = (G + P)⁻¹` that of `C G C` in `C`. The rest is that
/// of the prior, which does not scatter in resamples. Empty where the values are not determined.
fn share_of_data(at: &Linearization) -> Vec<f64> {
    let prior = DMatrix::from_diagonal(&DVector::from_column_slice(&at.prior));
    let gram = at.windows.iter().fold(DMatrix::zeros(prior.nrows(), prior.ncols()), |sum, normal| sum + &normal.gram);
    let Some(cholesky) = (&gram + prior).cholesky() else { return Vec::new() };
    let covariance = cholesky.inverse();
    let of_noise = &covariance * gram * &covariance;
    (0..covariance.nrows()).map(|j| of_noise[(j, j)] / covariance[(j, j)]).collect()
}

/// Places of the first values, `count` of them, of which one window tells more than the share `most`, as the instant of a change:
/// resamples that leave it out tell nothing of them.
fn of_one_window(at: &Linearization, count: usize, most: f64) -> Vec<usize> {
    let alone = |&j: &usize| {
        let told = at.windows.iter().map(|normal| normal.gram[(j, j)]);
        let (sum, largest) = told.fold((0.0, 0.0), |(sum, largest): (f64, f64), g| (sum + g, largest.max(g)));
        largest > most * sum
    };
    (0..count).filter(alone).collect()
}

/// Least and largest value that the mathematics allows a coefficient of an effect; all numbers for a parameter of the model.
fn allowed(fit: &Fit, name: &str) -> (f64, f64) {
    let coefficient = fit.effects.iter().flat_map(|e| &e.coefficients).find(|c| c.name == name);
    coefficient.map_or((f64::NEG_INFINITY, f64::INFINITY), |c| (c.min, c.max))
}

/// Places in the values of a fit that the data hardly tell: of which the standard deviation that is stated is more than this share of the
/// prior's.
fn hardly_told(fit: &Fit, at: &Linearization, width: f64, share: f64) -> Vec<usize> {
    let prior = |j: usize| at.scales.get(j).zip(at.prior.get(j)).map_or(f64::INFINITY, |(s, p)| s / p.sqrt());
    let vague = |(j, e): &(usize, &Estimate)| fit.unidentified.contains(j) || e.widened(width) > share * prior(*j);
    fit.values.iter().enumerate().filter(vague).map(|(j, _)| j).collect()
}
