//! Sensitivities of a fitted model by candidates.

use super::compiled::{Compiled, Target};
use super::fit::Fit;
use super::linearization::{Column, Linearization, Normal};
use super::multiple_shooting::{Study, theta_of};
use super::normal::{Point, difference, full, sensitivities, step_of};
use super::runner::{Delayed, Runner};
use super::slot::Slot;
use crate::effect::{Change, Coefficient, Effect, Path, Role};
use crate::error::DiagnoseError;
use rayon::prelude::*;

/// Windows that are linearized at once: enough to keep processors busy, few enough to hold the columns of all candidates in each.
const AT_ONCE: usize = 8;

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

/// A column of a candidate in one window, or why it could not be simulated.
type OfWindow = Result<Vec<f64>, String>;

/// A candidate beside a fit, compiled.
struct Tried {
    compiled: Compiled,
    secants: Vec<Secant>,
    /// Number of its amplitudes.
    amplitudes: usize,
    /// Whether its model has derivatives by them.
    propagated: bool,
}

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
        let mut normals = Vec::new();
        let mut result = self.linearize_each(fit, candidates, windows, |_, normal| normals.push(normal))?;
        result.windows = normals;
        Ok(result)
    }

    /// As [`Study::linearize`], with the windows given to `each` in their order, after the columns, and not kept: with hundreds of
    /// columns they would take most of the memory.
    pub(crate) fn linearize_each(
        &self,
        fit: &Fit,
        candidates: &[Effect],
        windows: &[usize],
        mut each: impl FnMut(&[Column], Normal),
    ) -> Result<Linearization, DiagnoseError> {
        self.counter().linearization();
        let candidates = &self.within_windows(candidates);
        let compiled = self.compiled(&fit.effects)?;
        let theta = theta_of(fit);
        let mut slots = self.slots(&compiled, windows, Some(fit))?;
        slots.par_iter_mut().for_each(|slot| slot.resume(&compiled, &theta));
        self.some_window(&slots)?;
        let trials: Vec<Vec<Vec<f64>>> = candidates.iter().map(trials).collect();
        let sampling = slots.first().map_or(1e-3, |s| s.runner.sampling());
        let tried: Vec<Tried> = candidates
            .par_iter()
            .enumerate()
            .map(|(i, candidate)| self.tried(fit, (i, candidate), &trials[i], sampling))
            .collect::<Result<_, _>>()?;

        let mut columns: Vec<Column> = (0..self.parameters.len()).map(Column::Parameter).collect();
        let mut scales: Vec<f64> = compiled.unknowns.iter().map(|u| u.scale).collect();
        for (effect, e) in fit.effects.iter().enumerate() {
            columns.extend((0..e.coefficients.len()).map(|coefficient| Column::Coefficient { effect, coefficient }));
        }
        let known = columns.len();
        for (effect, secant) in candidates.iter().zip(&tried).flat_map(|(e, t)| t.secants.iter().map(move |s| (e, s))) {
            columns.push(secant.column);
            scales.push(effect.coefficients[secant.coefficient].scale);
        }
        let mut prior = vec![0.0; columns.len()];
        let mut pull = vec![0.0; columns.len()];
        for (j, u) in compiled.unknowns.iter().enumerate() {
            prior[j] = (u.scale / u.prior).powi(2);
            pull[j] = (u.nominal - theta[j]) / u.scale;
        }
        let mut failures = Vec::new();
        for together in slots.chunks_mut(AT_ONCE) {
            let of_chunk: Vec<Result<Option<InWindow>, DiagnoseError>> = together
                .par_iter_mut()
                .map(|slot| self.in_window(slot, &compiled, &theta, &tried, &scales[known..]))
                .collect();
            for of_window in of_chunk {
                let Some(InWindow { normal, failed }) = of_window? else { continue };
                failures.extend(failed.into_iter().map(|(k, reason)| (columns[known + k], normal.window, reason)));
                each(&columns, normal);
            }
        }
        Ok(Linearization { columns, scales, prior, pull, trials, windows: Vec::new(), failures })
    }

    /// A candidate beside a fit.
    fn tried(
        &self,
        fit: &Fit,
        (index, candidate): (usize, &Effect),
        trials: &[Vec<f64>],
        sampling: f64,
    ) -> Result<Tried, DiagnoseError> {
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
        let first = fit.values.len();
        let secants = secants(index, candidate, trials, |coefficient, c| {
            step_of(&compiled.unknowns[first + coefficient], c.nominal, compiled.step(first + coefficient, sampling))
        });
        Ok(Tried { compiled, secants, amplitudes: names.len(), propagated })
    }

    /// The normal equations of one window; none where it cannot be simulated.
    fn in_window(
        &self,
        slot: &mut Slot<'_>,
        compiled: &Compiled,
        theta: &[f64],
        tried: &[Tried],
        scales: &[f64],
    ) -> Result<Option<InWindow>, DiagnoseError> {
        let Ok(point) = &slot.state else { return Ok(None) };
        let known = sensitivities(&mut slot.runner, compiled, theta, point, &slot.scales, true);
        // For the candidates; finite differences may have left another trajectory behind.
        let (Ok(known), Ok(_)) = (known, slot.runner.map(theta, &point.x0)) else { return Ok(None) };
        let first = known.ncols();
        let mut all = known.resize_horizontally(first + scales.len(), 0.0);
        let mut failed = Vec::new();
        let mut place = 0;
        let mut late = Vec::new();
        for candidate in tried {
            for column in self.columns(candidate, slot, point, theta, &mut late)? {
                match column {
                    Ok(values) => {
                        let mut out = all.column_mut(first + place);
                        out.copy_from_slice(&values);
                        out.scale_mut(scales[place]);
                    }
                    Err(reason) => failed.push((place, reason)),
                }
                place += 1;
            }
        }
        let normal = slot.normal(&full(&slot.runner, point, &all));
        Ok(normal.map(|normal| InWindow { normal, failed }))
    }

    /// The columns of one candidate in one window.
    fn columns(
        &self,
        tried: &Tried,
        slot: &Slot<'_>,
        point: &Point,
        theta: &[f64],
        late: &mut Vec<Delayed>,
    ) -> Result<Vec<OfWindow>, DiagnoseError> {
        let Tried { compiled, secants, amplitudes, propagated } = tried;
        if let Some(columns) = filters(slot, compiled, point, theta, secants) {
            return Ok(columns);
        }
        let noise = &self.noise[slot.runner.window.record];
        let records = &self.sources.records;
        let mut runner = Runner::new(records, compiled, slot.runner.window, noise)?;
        let mut columns = Vec::with_capacity(secants.len());
        for of_trial in secants.chunk_by(|a, b| a.from == b.from) {
            let mapped = *propagated && of_trial.len() == *amplitudes && slot.runner.trajectory.is_mapped();
            let by_amplitudes = if mapped {
                let values: Vec<f64> = theta.iter().chain(&of_trial[0].from).copied().collect();
                slot.runner.by_amplitudes(&mut runner, &values, *amplitudes).unwrap_or(None)
            } else {
                None
            };
            match by_amplitudes {
                Some(all) => columns.extend(all.into_iter().map(Ok)),
                None => columns.extend(of_trial.iter().map(|s| {
                    by_samples(&slot.runner, &mut runner, compiled, theta, s)
                        .map_or_else(|| column(&mut runner, compiled, theta, point, s, late), Ok)
                })),
            }
        }
        Ok(columns)
    }
}

/// The normal equations of a window, with the columns of candidates that could not be simulated, by place, and why.
struct InWindow {
    normal: Normal,
    failed: Vec<(usize, String)>,
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

/// The secants of a filter of measured columns, which need no simulation; none of anything else, or where the trajectory at the point is
/// not at hand.
fn filters(
    slot: &Slot<'_>,
    compiled: &Compiled,
    point: &Point,
    theta: &[f64],
    secants: &[Secant],
) -> Option<Vec<OfWindow>> {
    let Some(Target::Column(path @ (Path::SensorLag | Path::DigitalFilter), names)) = compiled.targets.get(theta.len())
    else {
        return None;
    };
    if !slot.runner.trajectory.is_of(theta, &point.x0) {
        return None;
    }
    let of = |s: &Secant| {
        let moved = slot.runner.filtered_more(*path, names, s.to);
        let mut out = vec![0.0; moved.len()];
        difference(&moved, &point.simulated, s.to, &mut out);
        Ok(out)
    };
    Some(secants.iter().map(of).collect())
}

/// A secant in natural units.
fn column(
    runner: &mut Runner<'_>,
    compiled: &Compiled,
    theta: &[f64],
    point: &Point,
    secant: &Secant,
    late: &mut Vec<Delayed>,
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
    let delays = |target: &Target| matches!(target, Target::Column(Path::SensorDelay, _));
    if let Target::Column(Path::SensorDelay, names) = &compiled.targets[unknown]
        && !compiled.targets[..theta.len()].iter().any(delays)
    {
        // The delays of all columns have the same trajectory.
        if late.iter().all(|l| l.delay != secant.to) {
            late.push(runner.simulate_late(&values, &point.x0, secant.to).map_err(|f| f.to_string())?);
        }
        let both = late.iter().find(|l| l.delay == secant.to).ok_or_else(String::new)?;
        let samples = runner.samples();
        for (column, measured) in runner.record.measured.iter().enumerate() {
            let range = column * samples..(column + 1) * samples;
            let shown = if names.contains(&measured.name) { &both.late } else { &both.now };
            moved[range.clone()].copy_from_slice(&shown[range]);
        }
        difference(&moved, &point.simulated, secant.to - nominal, &mut out);
        return Ok(out);
    }
    runner.simulate(&values, &point.x0, &mut moved).map_err(|f| f.to_string())?;
    difference(&moved, &point.simulated, secant.to - nominal, &mut out);
    Ok(out)
}
