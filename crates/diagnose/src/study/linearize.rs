//! Sensitivities of a fitted model by candidates.

use super::compiled::{Compiled, Target};
use super::fit::{Fit, Slot};
use super::linearization::{Column, Linearization};
use super::multiple_shooting::{Study, theta_of};
use super::normal::{Point, difference, full, sensitivities, step_of};
use super::runner::Runner;
use crate::effect::{Change, Coefficient, Effect, Role};
use crate::error::DiagnoseError;
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Trials of one candidate: the values of all its coefficients.
fn trials(effect: &Effect) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![Vec::new()];
    for c in &effect.coefficients {
        let values: &[f64] = if c.trials.is_empty() { std::slice::from_ref(&c.nominal) } else { &c.trials };
        all = all
            .iter()
            .flat_map(|head| values.iter().map(move |&v| head.iter().copied().chain([v]).collect()))
            .collect();
    }
    all
}

/// One column of a candidate: from where to where the unknowns of the candidate move.
struct Secant {
    column: Column,
    from: Vec<f64>,
    coefficient: usize,
    to: f64,
}

/// The columns of a candidate: every amplitude moves from its nominal value, at every trial of the shapes.
fn secants(
    candidate: usize,
    effect: &Effect,
    trials: &[Vec<f64>],
    step: impl Fn(usize, &Coefficient) -> f64,
) -> Vec<Secant> {
    let mut secants = Vec::new();
    for (trial, values) in trials.iter().enumerate() {
        for (coefficient, c) in effect.coefficients.iter().enumerate().filter(|(_, c)| c.role == Role::Amplitude) {
            let from = effect
                .coefficients
                .iter()
                .zip(values)
                .map(|(c, v)| if c.role == Role::Shape { *v } else { c.nominal })
                .collect();
            let to = if c.trials.is_empty() { c.nominal + step(coefficient, c) } else { values[coefficient] };
            if to != c.nominal {
                secants.push(Secant {
                    column: Column::Candidate { candidate, coefficient, trial },
                    from,
                    coefficient,
                    to,
                });
            }
        }
    }
    secants
}

/// Columns of a candidate in one window, each with why it could not be simulated.
type Columns = Vec<Result<Vec<f64>, String>>;

impl Study {
    /// The normal equations of the fit's unknowns and of all amplitudes of the candidates, at the values of the fit, per window.
    ///
    /// A candidate's column is a secant: from the nominal amplitude to one a little beside it, or to each of the amplitude's trials
    /// (delays); at each combination of trials of the shapes.
    ///
    /// # Errors
    /// [`DiagnoseError`] for effects and candidates that do not fit the model, or if no window can be simulated.
    pub fn linearize(
        &self,
        fit: &Fit,
        candidates: &[Effect],
        windows: &[usize],
    ) -> Result<Linearization, DiagnoseError> {
        let compiled = self.compiled(&fit.effects)?;
        let theta = theta_of(fit);
        let mut slots = self.slots(&compiled, windows, Some(fit))?;
        slots.par_iter_mut().for_each(|slot| slot.resume(&compiled, &theta));
        self.some_window(&slots)?;
        let jacobians: Vec<Option<DMatrix<f64>>> = slots
            .par_iter_mut()
            .map(|slot| {
                let point = slot.state.as_ref().ok()?;
                let jacobian = sensitivities(&mut slot.runner, &compiled, &theta, point, &slot.scales, true).ok()?;
                // For the candidates; finite differences may have left another trajectory behind.
                slot.runner.map(&theta, &point.x0).ok()?;
                Some(jacobian)
            })
            .collect();
        let trials: Vec<Vec<Vec<f64>>> = candidates.iter().map(trials).collect();
        let work: Vec<(Vec<Secant>, Vec<Columns>)> = candidates
            .par_iter()
            .enumerate()
            .map(|(i, candidate)| self.candidate(fit, (i, candidate), &trials[i], &slots, &theta))
            .collect::<Result<_, _>>()?;

        let mut columns = Vec::new();
        let mut scales: Vec<f64> = compiled.unknowns.iter().map(|u| u.scale).collect();
        for i in 0..self.parameters.len() {
            columns.push(Column::Parameter(i));
        }
        for (effect, e) in fit.effects.iter().enumerate() {
            columns.extend((0..e.coefficients.len()).map(|coefficient| Column::Coefficient { effect, coefficient }));
        }
        let known = columns.len();
        for secant in work.iter().flat_map(|(secants, _)| secants) {
            columns.push(secant.column);
            if let Column::Candidate { candidate, coefficient, .. } = secant.column {
                scales.push(candidates[candidate].coefficients[coefficient].scale);
            }
        }
        let mut prior = vec![0.0; columns.len()];
        let mut pull = vec![0.0; columns.len()];
        for (j, u) in compiled.unknowns.iter().enumerate() {
            prior[j] = (u.scale / u.prior).powi(2);
            pull[j] = (u.nominal - theta[j]) / u.scale;
        }
        let mut result =
            Linearization { columns, scales, prior, pull, trials, windows: Vec::new(), failures: Vec::new() };
        for (place, (slot, jacobian)) in slots.iter().zip(&jacobians).enumerate() {
            let (Ok(point), Some(known_jacobian)) = (&slot.state, jacobian) else { continue };
            let n = slot.scales.len();
            let mut all = known_jacobian.clone().resize_horizontally(n + result.columns.len(), 0.0);
            let candidate_columns = work.iter().flat_map(|(_, columns)| &columns[place]);
            for (k, column) in candidate_columns.enumerate() {
                match column {
                    Ok(values) => {
                        all.column_mut(n + known + k).copy_from_slice(values);
                        let scale = result.scales[known + k];
                        all.column_mut(n + known + k).scale_mut(scale);
                    }
                    Err(reason) => {
                        result.failures.push((result.columns[known + k], slot.index, reason.clone()));
                    }
                }
            }
            if let Some(normal) = slot.normal(&full(&slot.runner, point, &all)) {
                result.windows.push(normal);
            }
        }
        Ok(result)
    }

    /// The columns of one candidate in all windows.
    fn candidate(
        &self,
        fit: &Fit,
        (index, candidate): (usize, &Effect),
        trials: &[Vec<f64>],
        slots: &[Slot<'_>],
        theta: &[f64],
    ) -> Result<(Vec<Secant>, Vec<Columns>), DiagnoseError> {
        let effects: Vec<Effect> = fit.effects.iter().chain([candidate]).cloned().collect();
        let amplitudes: Vec<&Coefficient> =
            candidate.coefficients.iter().filter(|c| c.role == Role::Amplitude).collect();
        let names: Vec<String> = amplitudes.iter().map(|c| c.name.clone()).collect();
        let smooth = amplitudes.iter().all(|c| c.trials.is_empty());
        let propagated = smooth && !matches!(candidate.change, Change::Path { .. } | Change::TrackedPoint { .. });
        let by = if propagated { names.as_slice() } else { &[] };
        let compiled = Compiled::with_derivatives(
            &self.system,
            &self.sources,
            &self.parameters,
            &effects,
            Some(by),
            &self.settings,
        )?;
        let sampling = slots.first().map_or(1e-3, |s| s.runner.sampling());
        let first = theta.len();
        let secants = secants(index, candidate, trials, |coefficient, c| {
            step_of(&compiled.unknowns[first + coefficient], c.nominal, compiled.step(first + coefficient, sampling))
        });
        let columns: Vec<Result<Columns, DiagnoseError>> = slots
            .par_iter()
            .map(|slot| {
                let Ok(point) = &slot.state else { return Ok(Vec::new()) };
                let records = &self.sources.records;
                let noise = &self.noise[slot.runner.window.record];
                let mut runner = Runner::new(records, &compiled, slot.runner.window, noise, slot.scales.len())?;
                let mut columns = Columns::with_capacity(secants.len());
                for of_trial in secants.chunk_by(|a, b| a.from == b.from) {
                    let by_amplitudes =
                        if propagated && of_trial.len() == names.len() && slot.runner.trajectory.is_mapped() {
                            let values: Vec<f64> = theta.iter().chain(&of_trial[0].from).copied().collect();
                            slot.runner.by_amplitudes(&mut runner, &values, names.len()).unwrap_or(None)
                        } else {
                            None
                        };
                    match by_amplitudes {
                        Some(all) => columns.extend(all.into_iter().map(Ok)),
                        None => columns.extend(of_trial.iter().map(|s| {
                            by_samples(&slot.runner, &mut runner, &compiled, theta, s)
                                .map_or_else(|| column(&mut runner, &compiled, theta, point, s), Ok)
                        })),
                    }
                }
                Ok(columns)
            })
            .collect();
        Ok((secants, columns.into_iter().collect::<Result<_, _>>()?))
    }
}

/// A secant of a delay or a lag of inputs in natural units, to first order in the change of the inputs; none of anything else, or
/// where the linear maps along the window are missing.
fn by_samples(
    base: &Runner<'_>,
    candidate: &mut Runner<'_>,
    compiled: &Compiled,
    theta: &[f64],
    secant: &Secant,
) -> Option<Vec<f64>> {
    let unknown = theta.len() + secant.coefficient;
    if !matches!(compiled.targets[unknown], Target::Input(..)) || !base.trajectory.is_mapped() {
        return None;
    }
    let mut values: Vec<f64> = theta.iter().chain(&secant.from).copied().collect();
    let step = secant.to - values[unknown];
    values[unknown] = secant.to;
    let mut column = base.by_samples(candidate, &values).ok()??;
    for v in &mut column {
        *v /= step;
    }
    Some(column)
}

/// A secant in natural units.
fn column(
    runner: &mut Runner<'_>,
    compiled: &Compiled,
    theta: &[f64],
    point: &Point,
    secant: &Secant,
) -> Result<Vec<f64>, String> {
    let mut out = vec![0.0; runner.target.len()];
    let unknown = theta.len() + secant.coefficient;
    if matches!(compiled.targets[unknown], Target::Column(..)) && runner.offset_column(unknown, &mut out) {
        return Ok(out);
    }
    let mut values: Vec<f64> = theta.iter().chain(&secant.from).copied().collect();
    let nominal = values[unknown];
    values[unknown] = secant.to;
    let mut moved = vec![0.0; runner.target.len()];
    runner.simulate(&values, &point.x0, &mut moved).map_err(|f| f.to_string())?;
    difference(&moved, &point.simulated, secant.to - nominal, &mut out);
    Ok(out)
}
