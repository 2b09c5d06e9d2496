//! The measured gain of an extended model.

use rayon::prelude::*;

use super::bootstrap::weighted_step;
use super::equation::{ForceResidual, force_error, force_residuals};
use super::horizon::{Predicted, predict};
use super::report::Gain;
use super::trial::Trial;
use crate::error::DiagnoseError;
use crate::record::Record;
use crate::settings::{DiagnosisSettings, EquationSettings, GainSettings, PredictionSettings, StudySettings};
use crate::study::{Fit, Linearization, Study, Window};

/// The refitted and the extended model with their least-squares problems, both over all windows of a study.
pub struct Fitted<'a> {
    /// The given model, refitted.
    pub refitted: &'a Fit,
    /// Around it, without candidates.
    pub at_refitted: &'a Linearization,
    /// The model with the causes.
    pub extended: &'a Fit,
    /// Around it, without candidates.
    pub at_extended: &'a Linearization,
}

/// What figures of the gain are made from.
#[derive(Clone, Debug)]
pub struct HeldOut {
    /// The records that were predicted.
    pub records: Vec<Record>,
    /// Predictions over the longest horizon.
    pub predicted: Vec<Predicted>,
    /// Residuals of the equations of the refitted model.
    pub before: Vec<ForceResidual>,
    /// Residuals of the equations of the extended model.
    pub after: Vec<ForceResidual>,
}

/// Measures the gain: on the records for validation if there are any, else by turns on each of a few parts of the records of the
/// fit, with the values that the other parts give (one Gauss–Newton step from the fit to all). `None` if the data are too short.
///
/// # Errors
/// [`DiagnoseError`] for records that do not fit the model.
pub fn measure_gain(
    study: &Study,
    fitted: &Fitted<'_>,
    validate: &[Record],
    settings: &DiagnosisSettings,
) -> Result<Option<(Gain, HeldOut)>, DiagnoseError> {
    let window = study.windows_used().seconds;
    let GainSettings { predictions, equations, .. } = &settings.gain;
    let of_validation;
    let (study, trials) = if validate.is_empty() {
        (study, folds(study, fitted, predictions))
    } else {
        let of = StudySettings { window: Some(window), ..settings.study.clone() };
        of_validation = Study::counted(study.system(), validate, &of, study.counter())?;
        let trial = Trial {
            as_given: of_validation.nominal(),
            refitted: fitted.refitted.clone(),
            extended: fitted.extended.clone(),
            held_out: joined(&of_validation, of_validation.windows()),
        };
        (&of_validation, vec![trial])
    };
    let (horizons, predicted) = predict(study, &trials, window, predictions)?;
    let residuals = [
        force(study, &trials, equations, |t| &t.as_given)?,
        force(study, &trials, equations, |t| &t.refitted)?,
        force(study, &trials, equations, |t| &t.extended)?,
    ];
    if horizons.is_empty() && residuals[2].is_empty() {
        return Ok(None);
    }
    // Where only parameters are wrong, the refitted model is the extended one.
    let only_parameters = fitted.extended.effects.is_empty();
    let compared = usize::from(!only_parameters);
    let nrmse = |model: usize| horizons.iter().map(|h| (h.sums[model] / h.terms as f64).sqrt()).collect::<Vec<_>>();
    let [given, before, after] = [0, compared, 2].map(|k| force_error(&residuals[k]));
    let gain = Gain {
        metric: "multi-step NRMSE".to_owned(),
        horizons_s: horizons.iter().map(|h| h.seconds).collect(),
        before: nrmse(compared),
        after: nrmse(2),
        as_given: nrmse(0),
        held_out: true,
        predictions: horizons.iter().map(|h| h.predictions).collect(),
        equation_error_before: before,
        equation_error_after: after,
        equation_error_as_given: given,
        equation_bandwidth_hz: residuals[2].iter().map(|r| r.bandwidth).reduce(f64::min),
    };
    let [as_given, refitted, after] = residuals;
    let before = if only_parameters { as_given } else { refitted };
    Ok(Some((gain, HeldOut { records: study.records().to_vec(), predicted, before, after })))
}

/// Windows that follow each other without a gap, as one.
fn joined(study: &Study, windows: &[Window]) -> Vec<Window> {
    let mut out: Vec<Window> = Vec::new();
    for w in windows {
        match out.last_mut() {
            Some(last)
                if last.record == w.record
                    && last.to == w.from
                    && !study.records()[w.record].gaps.contains(&w.from) =>
            {
                last.to = w.to;
            }
            _ => out.push(*w),
        }
    }
    out
}

/// Splits the windows into parts that follow each other in time; every part is tried with the values that the others give.
fn folds(study: &Study, fitted: &Fitted<'_>, settings: &PredictionSettings) -> Vec<Trial> {
    let windows = study.windows();
    let parts = settings.folds.min(windows.len() / settings.shortest_fold);
    if parts < 2 {
        return Vec::new();
    }
    (0..parts)
        .filter_map(|k| {
            let held_out = k * windows.len() / parts..(k + 1) * windows.len() / parts;
            let without = |fit: &Fit, linearization: &Linearization| {
                let counts = |i: usize| if held_out.contains(&linearization.windows[i].window) { 0.0 } else { 1.0 };
                let step = weighted_step(linearization, &fit.limited, counts)?;
                let mut fit = fit.clone();
                for (estimate, step) in fit.values.iter_mut().zip(step.iter()) {
                    estimate.value += step;
                }
                for c in fit.effects.iter().flat_map(|e| &e.coefficients) {
                    if let Some(estimate) = fit.values.iter_mut().find(|v| v.name == c.name) {
                        estimate.value = estimate.value.clamp(c.min, c.max);
                    }
                }
                Some(fit)
            };
            Some(Trial {
                as_given: study.nominal(),
                refitted: without(fitted.refitted, fitted.at_refitted)?,
                extended: without(fitted.extended, fitted.at_extended)?,
                held_out: joined(study, &windows[held_out.clone()]),
            })
        })
        .collect()
}

/// Residuals of the equations in the held-out stretches.
fn force(
    study: &Study,
    trials: &[Trial],
    settings: &EquationSettings,
    of: impl Fn(&Trial) -> &Fit + Sync,
) -> Result<Vec<ForceResidual>, DiagnoseError> {
    let residuals = |trial: &Trial| {
        let fit = of(trial);
        force_residuals(study.system(), &fit.effects, &fit.values, study.records(), settings)
    };
    // The model as given is the same in all trials.
    let same = trials.iter().all(|t| of(t).values == of(&trials[0]).values);
    let each: Vec<Vec<ForceResidual>> = if same {
        let first = trials.first().map_or_else(|| Ok(Vec::new()), residuals)?;
        vec![first; trials.len()]
    } else {
        trials.par_iter().map(residuals).collect::<Result<_, _>>()?
    };
    let mut out = Vec::new();
    for (trial, residuals) in trials.iter().zip(each) {
        out.extend(residuals.into_iter().map(|r| {
            let record = r.record;
            r.only(|k| trial.held_out.iter().any(|w| w.record == record && (w.from..w.to).contains(&k)))
        }));
    }
    out.retain(|r| !r.values.is_empty());
    Ok(out)
}
