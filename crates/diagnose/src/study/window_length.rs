//! How long windows should be: as the data say.
//!
//! Long windows let noise average out, since fewer initial states are fitted. Short windows forget sooner what the model gets
//! wrong slowly (drift, disturbances), which in long ones swamps everything else. So the length is chosen at which the shared unknowns
//! come out most certain, by a covariance that is honest about both: the sandwich `H⁻¹ M H⁻¹` with windows as blocks
//! (White 1982).

use super::fit::Fit;
use super::linearization::Normal;
use super::multiple_shooting::Study;
use super::window::{WindowLength, longest_window, shortest_window};
use crate::effect::Effect;
use crate::error::DiagnoseError;
use nalgebra::{Cholesky, DMatrix, DVector};

impl Study {
    /// The same study with windows of the length that makes the unknowns most certain with `effects` in the model, and the fit
    /// over all of them. Where the settings give the length, it stays.
    ///
    /// Long windows let noise average out, since fewer initial states are fitted; short windows forget sooner what the model
    /// gets wrong slowly, which in long ones swamps everything else. Lengths are tried from the fewest samples that a window may
    /// have, doubling, to a sixteenth of the data. The one taken is the longest whose unknowns have, within 3 %, the least
    /// standard deviations by the sandwich covariance with windows as blocks (White, "Maximum likelihood estimation of
    /// misspecified models", Econometrica 50, 1982). With causes found, another length may suit better than without.
    ///
    /// # Errors
    /// [`DiagnoseError`] as [`Study::fit`].
    pub fn with_best_windows(&self, effects: &[Effect], start: Option<&Fit>) -> Result<(Self, Fit), DiagnoseError> {
        choose(self, effects, start)
    }

    /// The lengths of windows that were tried by [`Study::with_best_windows`], shortest first.
    pub fn window_lengths(&self) -> &[WindowLength] {
        &self.lengths
    }
}

/// Tries all lengths, the shortest first: there a fit converges from afar, and its estimates start the next.
fn choose(study: &Study, effects: &[Effect], start: Option<&Fit>) -> Result<(Study, Fit), DiagnoseError> {
    let settings = &study.settings.windows;
    let longest = longest_window(study.records(), settings);
    let shortest = shortest_window(study.records(), study.system.states.len(), settings);
    let mut lengths = vec![study.settings.window.unwrap_or(longest)];
    while study.settings.window.is_none() && 0.5 * lengths[lengths.len() - 1] >= shortest {
        lengths.push(0.5 * lengths[lengths.len() - 1]);
    }
    // Initial states belong to other windows.
    let mut start = start.map(Fit::without_windows);
    let mut tried: Vec<(WindowLength, Study, Fit)> = Vec::new();
    let last = lengths.len() - 1;
    for (i, &seconds) in lengths.iter().rev().enumerate() {
        let trial = study.with_windows(seconds)?;
        let all: Vec<usize> = (0..trial.windows.len()).collect();
        let (fit, normals, prior) = match trial.fit_with_normals(effects, &all, start.as_ref(), f64::INFINITY) {
            Ok(all) => all,
            // Another length may do.
            Err(DiagnoseError::NoWindow { .. }) if i < last || !tried.is_empty() => continue,
            Err(error) => return Err(error),
        };
        let uncertainty = uncertainty(&normals, &prior).unwrap_or(f64::INFINITY);
        if certain(&normals, &prior, settings.certain_share) {
            start = Some(fit.without_windows());
        }
        tried.push((WindowLength { seconds, uncertainty }, trial, fit));
    }
    let lengths: Vec<WindowLength> = tried.iter().map(|t| t.0).collect();
    let least = lengths.iter().map(|w| w.uncertainty).fold(f64::INFINITY, f64::min);
    let good = tried.into_iter().rfind(|(w, ..)| w.uncertainty <= least + settings.indifferent);
    let (_, mut best, fit) = good.ok_or_else(|| study.too_short())?;
    best.lengths = lengths;
    Ok((best, fit))
}

/// `½ log det(H⁻¹ (M + H) H⁻¹)/p`, with `M` the scatter of the windows' gradients. Where only noise is left, `M` is `H` on average, and
/// the sum is twice that with less scatter of its own; where the model is wrong, `M` is what counts.
fn uncertainty(normals: &[Normal], prior: &[f64]) -> Option<f64> {
    let (p, k) = (prior.len(), normals.len());
    if p == 0 || k <= p + 1 {
        return None;
    }
    let information = information(normals, prior);
    let mean = normals.iter().map(|w| &w.gradient / k as f64).sum::<DVector<f64>>();
    let mut scatter = information.clone();
    let few = k as f64 / (k - p) as f64;
    for w in normals {
        let off = &w.gradient - &mean;
        scatter += few * &off * off.transpose();
    }
    let log_det = |m: DMatrix<f64>| -> Option<f64> {
        Some(2.0 * Cholesky::new(m)?.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>())
    };
    Some((0.5 * log_det(scatter)? - log_det(information)?) / p as f64)
}

/// `H`: what the windows and the prior tell, in scaled units.
fn information(normals: &[Normal], prior: &[f64]) -> DMatrix<f64> {
    let prior = DMatrix::from_diagonal(&DVector::from_column_slice(prior));
    normals.iter().fold(prior, |sum, w| sum + &w.gram)
}

/// Whether the data tell much more of every unknown than the prior does.
fn certain(normals: &[Normal], prior: &[f64], share: f64) -> bool {
    Cholesky::new(information(normals, prior)).is_some_and(|c| {
        let covariance = c.inverse();
        prior.iter().enumerate().all(|(j, weight)| covariance[(j, j)] * weight < share * share)
    })
}
