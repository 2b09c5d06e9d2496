//! How long windows should be.

use bracketry_system::System;
use nalgebra::DMatrix;

use super::Settings;
use crate::{DiagnoseError, Fit, Linearization, Record, Study, StudySettings};

/// Samples in the shortest windows that are tried; each next length is twice as long.
const SHORTEST: f64 = 50.0;
/// Fewest windows.
const FEWEST_WINDOWS: f64 = 12.0;
/// Most lengths that are tried.
const MOST_LENGTHS: usize = 6;

/// The study with the windows that tell most about the parameters, and the model's fit to them.
///
/// Long windows average noise, short ones keep the model's errors from adding up: a wrong force drifts away with the square
/// of time, and the drift of one window drowns what another could tell. Which matters more is in the data: the length is
/// taken whose parameters have the smallest covariance as the scatter between windows shows it (sandwich estimate, windows
/// as independent blocks), by its determinant.
pub(crate) fn study(system: &System, records: &[Record], settings: &Settings) -> Result<(Study, Fit), DiagnoseError> {
    let all = |study: &Study| (0..study.windows().len()).collect::<Vec<_>>();
    if settings.study.window.is_some() {
        let study = Study::new(system, records, &settings.study)?;
        let fit = study.fit(&[], &all(&study), None)?;
        return Ok((study, fit));
    }
    let mut best: Option<(f64, Study, Fit)> = None;
    let mut previous: Option<Fit> = None;
    for length in lengths(records) {
        let study = Study::new(system, records, &StudySettings { window: Some(length), ..settings.study.clone() })?;
        // Only the parameters carry over: the windows are other ones.
        let start = previous.take().map(|fit| Fit { windows: Vec::new(), ..fit });
        let fit = study.fit(&[], &all(&study), start.as_ref())?;
        let volume = spread(&study.linearize(&fit, &[], &all(&study))?);
        if best.as_ref().is_none_or(|b| volume < b.0) {
            best = Some((volume, study, fit.clone()));
        }
        previous = Some(fit);
    }
    if let Some((_, study, fit)) = best {
        return Ok((study, fit));
    }
    let study = Study::new(system, records, &settings.study)?;
    let fit = study.fit(&[], &all(&study), None)?;
    Ok((study, fit))
}

/// Lengths to try, s, from the sampling and the duration.
fn lengths(records: &[Record]) -> Vec<f64> {
    let duration: f64 = records.iter().filter_map(|r| Some(r.times.last()? - r.times.first()?)).sum();
    let samples: usize = records.iter().map(|r| r.times.len()).sum();
    let shortest = SHORTEST * duration / samples.max(1) as f64;
    let longest = duration / FEWEST_WINDOWS;
    (0..MOST_LENGTHS).map(|k| shortest * 2.0_f64.powi(k as i32)).filter(|l| *l <= longest).collect()
}

/// Mean logarithm of the principal variances of the columns' estimates, from the scatter of the windows' gradients.
fn spread(linearization: &Linearization) -> f64 {
    let n = linearization.columns.len();
    if n == 0 {
        return 0.0;
    }
    let mut gram = DMatrix::from_fn(n, n, |i, j| if i == j { linearization.prior[i] } else { 0.0 });
    let mut scatter = gram.clone();
    let windows = linearization.windows.len() as f64;
    for normal in &linearization.windows {
        gram += &normal.gram;
        scatter += &normal.gradient * normal.gradient.transpose();
    }
    let Some(inverse) = gram.try_inverse() else { return f64::INFINITY };
    let few = windows / (windows - n as f64).max(1.0);
    let covariance = &inverse * scatter * &inverse * few;
    let sum: f64 = covariance.symmetric_eigenvalues().iter().map(|v| v.max(1e-300).ln()).sum();
    if sum.is_finite() { sum / n as f64 } else { f64::INFINITY }
}
