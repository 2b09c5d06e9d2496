//! Fits by multiple shooting: records cut into windows, the model fitted to them.

use super::compiled::{Compiled, Sources};
use super::fit::{Estimate, Fit, solve};
use super::initial::Guess;
use super::linearization::Normal;
use super::runner::{Failure, Runner};
use super::slot::{Slot, WindowFit};
use super::unknown::is_natural_constant;
use super::window::{Window, WindowLength, Windows, cut, longest_window, stretches};
use crate::effect::{Effect, HiddenState};
use crate::effort::Counter;
use crate::error::DiagnoseError;
use crate::record::Record;
use crate::settings::StudySettings;
use bracketry_numerics::statistics::median;
use bracketry_system::System;
use rayon::prelude::*;
use std::sync::Arc;

/// Records cut into windows, with the model to be fitted to them.
#[derive(Clone)]
pub struct Study {
    pub(super) system: System,
    pub(super) sources: Arc<Sources>,
    pub(super) settings: StudySettings,
    pub(super) windows: Vec<Window>,
    /// Lengths of windows that were tried.
    pub(super) lengths: Vec<WindowLength>,
    pub(super) parameters: Vec<usize>,
    /// Per record and measured column.
    pub(super) noise: Vec<Vec<f64>>,
    /// Per record.
    pub(super) guesses: Vec<Guess>,
}

impl Study {
    /// Cuts the records into windows and picks the parameters to refit: all that occur in the model but natural constants (the
    /// acceleration of gravity) and those that the settings name.
    ///
    /// # Errors
    /// [`DiagnoseError`] for no data, data of another model, or too few samples.
    pub fn new(system: &System, records: &[Record], settings: &StudySettings) -> Result<Self, DiagnoseError> {
        Self::counted(system, records, settings, &Counter::default())
    }

    /// As [`Study::new`], with its effort counted beside that of others.
    pub(crate) fn counted(
        system: &System,
        records: &[Record],
        settings: &StudySettings,
        counter: &Counter,
    ) -> Result<Self, DiagnoseError> {
        check(system, records, settings)?;
        let guesses = records.iter().map(|r| Guess::new(system, r, settings.windows.fewest_samples)).collect();
        let noise = records.iter().map(|r| r.measured.iter().map(|m| m.noise).collect()).collect();
        let study = Self {
            parameters: refitted(system, &settings.fixed),
            system: system.clone(),
            sources: Arc::new(Sources::new(records, counter)),
            settings: settings.clone(),
            windows: Vec::new(),
            lengths: Vec::new(),
            noise,
            guesses,
        };
        study.with_windows(settings.window.unwrap_or_else(|| longest_window(records, &settings.windows)))
    }

    /// The same study with windows of another length, as near to `seconds` as whole windows allow.
    ///
    /// # Errors
    /// [`DiagnoseError::TooShort`] if no stretch of data is long enough for a window.
    pub fn with_windows(&self, seconds: f64) -> Result<Self, DiagnoseError> {
        let windows = cut(&self.sources.records, seconds, self.settings.windows.fewest_samples);
        if windows.is_empty() {
            return Err(self.too_short());
        }
        Ok(Self { windows, ..self.clone() })
    }

    /// What counts its effort.
    pub(crate) fn counter(&self) -> &Counter {
        &self.sources.counter
    }

    /// The windows.
    pub fn windows(&self) -> &[Window] {
        &self.windows
    }

    /// Number and length of the windows.
    pub(crate) fn windows_used(&self) -> Windows {
        let length = |w: &Window| {
            let times = &self.sources.records[w.record].times;
            times[w.to - 1] - times[w.from]
        };
        let seconds = median(self.windows.iter().map(length).collect()).unwrap_or(0.0);
        Windows { count: self.windows.len(), seconds }
    }

    /// The parameters that are refitted, by their index in the system.
    pub fn parameters(&self) -> &[usize] {
        &self.parameters
    }

    /// The records.
    pub fn records(&self) -> &[Record] {
        &self.sources.records
    }

    /// The model.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Standard deviation of the noise by which residuals are divided: per record and measured column, in the column's unit.
    pub fn noise(&self) -> &[Vec<f64>] {
        &self.noise
    }

    /// Fits the parameters, the coefficients of `effects` and the initial states of the given windows. Unknowns start at the
    /// values of `start` with their name, else at their nominal value.
    ///
    /// # Errors
    /// [`DiagnoseError`] for an effect that does not fit the model, or if no window can be simulated.
    pub fn fit(&self, effects: &[Effect], windows: &[usize], start: Option<&Fit>) -> Result<Fit, DiagnoseError> {
        Ok(self.fit_with_normals(effects, windows, start, f64::INFINITY)?.0)
    }

    /// As [`Study::fit`], ended early where its sum of squares will not come down to `reach`.
    pub(crate) fn fit_toward(
        &self,
        effects: &[Effect],
        windows: &[usize],
        start: &Fit,
        reach: f64,
    ) -> Result<Fit, DiagnoseError> {
        Ok(self.fit_with_normals(effects, windows, Some(start), reach)?.0)
    }

    /// As [`Study::fit`], with the normal equations at the solution and the weights of the priors, in scaled units.
    pub(super) fn fit_with_normals(
        &self,
        effects: &[Effect],
        windows: &[usize],
        start: Option<&Fit>,
        reach: f64,
    ) -> Result<(Fit, Vec<Normal>, Vec<f64>), DiagnoseError> {
        self.counter().fit();
        let compiled = self.compiled(effects)?;
        let theta: Vec<f64> = compiled
            .unknowns
            .iter()
            .map(|u| start.and_then(|s| s.estimate(&u.name)).map_or(u.start, |e| e.value).max(u.min).min(u.max))
            .collect();
        let mut slots = self.slots(&compiled, windows, start)?;
        let solver = &self.settings.solver;
        let share = if compiled.unknowns.is_empty() { solver.settled_share } else { solver.rough_share };
        settle_all(&mut slots, &compiled, &theta, share);
        self.some_window(&slots)?;
        let solution = solve(&mut slots, &compiled, &theta, (self.settings.iterations, reach));
        self.some_window(&slots)?;
        let values = compiled
            .unknowns
            .iter()
            .enumerate()
            .map(|(j, u)| Estimate {
                name: u.name.clone(),
                nominal: u.nominal,
                value: solution.theta[j],
                std: solution.covariance[(j, j)].max(0.0).sqrt(),
            })
            .collect();
        let fit = Fit {
            effects: effects.to_vec(),
            values,
            covariance: solution.covariance,
            windows: slots.iter().map(Slot::report).collect(),
            unidentified: solution.unidentified,
            limited: solution.limited,
            status: solution.status,
        };
        let weights = compiled.unknowns.iter().map(|u| (u.scale / u.prior).powi(2)).collect();
        Ok((fit, solution.normals, weights))
    }

    /// Fits the initial states of the given windows and keeps everything else at its value in `fit`. Windows that cannot be
    /// simulated say so.
    ///
    /// # Errors
    /// [`DiagnoseError`] for effects that do not fit the model.
    pub fn evaluate(&self, fit: &Fit, windows: &[usize]) -> Result<Vec<WindowFit>, DiagnoseError> {
        self.evaluate_until(fit, windows, self.settings.solver.settled_share)
    }

    /// As [`Study::evaluate`], until a step takes less than `share` of the sum of squares away.
    pub(crate) fn evaluate_until(
        &self,
        fit: &Fit,
        windows: &[usize],
        share: f64,
    ) -> Result<Vec<WindowFit>, DiagnoseError> {
        let compiled = self.compiled(&fit.effects)?;
        let mut slots = self.slots(&compiled, windows, Some(fit))?;
        settle_all(&mut slots, &compiled, &theta_of(fit), share);
        Ok(slots.iter().map(Slot::report).collect())
    }

    /// The model with effects, compiled.
    pub(super) fn compiled(&self, effects: &[Effect]) -> Result<Compiled, DiagnoseError> {
        Compiled::new(&self.system, &self.sources, &self.parameters, &self.within_windows(effects), &self.settings)
    }

    /// Effects with filters of columns that are faster than the windows: others show hardly anything but their own starts, which are free.
    pub(super) fn within_windows(&self, effects: &[Effect]) -> Vec<Effect> {
        let most = self.settings.windows.slowest_filter * self.windows_used().seconds;
        let mut effects = effects.to_vec();
        for effect in &mut effects {
            if !effect.is_filter() {
                continue;
            }
            for c in &mut effect.coefficients {
                c.max = c.max.min(most);
                c.trials.retain(|trial| *trial <= most);
                if c.trials.is_empty() {
                    c.trials.push(most);
                }
            }
        }
        effects
    }

    /// Windows ready to be simulated, with the initial states of `start` where it has them.
    pub(super) fn slots<'a>(
        &'a self,
        compiled: &'a Compiled,
        windows: &[usize],
        start: Option<&Fit>,
    ) -> Result<Vec<Slot<'a>>, DiagnoseError> {
        windows
            .iter()
            .map(|&index| {
                let window = *self
                    .windows
                    .get(index)
                    .ok_or(DiagnoseError::NoSuchWindow { index, windows: self.windows.len() })?;
                let record = &self.sources.records[window.record];
                let guess = &self.guesses[window.record];
                let runner = Runner::new(&self.sources.records, compiled, window, &self.noise[window.record])?;
                let (guessed, scales) = self.guessed(guess, compiled, guess.at(record, window));
                let fitted = start.and_then(|s| {
                    let window = s.windows.iter().find(|w| w.window == index && w.failure.is_none())?;
                    Some(self.carried(s, &window.x0, compiled, &guessed))
                });
                let (known, start) = fitted.unwrap_or((false, guessed.clone()));
                let state = Err(Failure::not_simulated());
                Ok(Slot { index, runner, known, start, guess: guessed, scales, state })
            })
            .collect()
    }

    /// First guesses and typical sizes of the initial state, with those of the states that effects add.
    pub(super) fn guessed(&self, guess: &Guess, compiled: &Compiled, own: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
        let (mut values, mut scales) = (own, guess.scales.clone());
        for state in &compiled.hidden {
            let like = state.like.as_ref().and_then(|name| self.system.state_index(name));
            values.push(like.map_or(0.0, |i| values[i]));
            scales.push(like.map_or(state.scale, |i| scales[i]));
        }
        (values, scales)
    }

    /// The initial state of a fit, for a model that may have other states of effects, and whether the fit has all of them; `guessed` has
    /// those that it lacks.
    fn carried(&self, fit: &Fit, x0: &[f64], compiled: &Compiled, guessed: &[f64]) -> (bool, Vec<f64>) {
        let own = self.system.states.len();
        let names: Vec<&String> = fit.effects.iter().flat_map(Effect::hidden).map(|s| &s.name).collect();
        let of = |state: &HiddenState| names.iter().position(|name| **name == state.name).and_then(|i| x0.get(own + i));
        let hidden: Vec<Option<&f64>> = compiled.hidden.iter().map(of).collect();
        let known = hidden.iter().all(Option::is_some);
        let values = hidden.into_iter().zip(&guessed[own..]).map(|(known, guess)| *known.unwrap_or(guess));
        (known, x0.iter().take(own).copied().chain(values).collect())
    }

    pub(super) fn too_short(&self) -> DiagnoseError {
        let records: Vec<&str> = self.sources.records.iter().map(|r| r.name.as_str()).collect();
        DiagnoseError::TooShort { records: records.join(", "), samples: self.settings.windows.fewest_samples }
    }

    /// Refuses a length of windows in the settings that is longer than every stretch of the data, or shorter than the fewest
    /// samples of a window; [`Study::with_windows`] takes the nearest that there is.
    pub(crate) fn check_window(&self) -> Result<(), DiagnoseError> {
        let Some(length) = self.settings.window else { return Ok(()) };
        let fewest = self.settings.windows.fewest_samples;
        let mut longest = 0.0;
        let mut shortest = f64::INFINITY;
        for record in &self.sources.records {
            for (from, to) in stretches(record).into_iter().filter(|(from, to)| to - from >= fewest) {
                let duration = record.times[to - 1] - record.times[from];
                let step = duration / (to - from - 1) as f64;
                longest = f64::max(longest, duration + step);
                shortest = f64::min(shortest, step * (fewest - 1) as f64);
            }
        }
        if length < shortest || length > longest {
            return Err(DiagnoseError::WindowLength { length, shortest, longest });
        }
        Ok(())
    }

    pub(super) fn some_window(&self, slots: &[Slot<'_>]) -> Result<(), DiagnoseError> {
        if self.system.pool.stop_flag().is_raised() {
            return Err(DiagnoseError::Stopped);
        }
        if slots.iter().any(|s| s.state.is_ok()) {
            return Ok(());
        }
        let first = slots.iter().find_map(|s| s.state.as_ref().err().map(|e| (s.index, e.reason.clone())));
        let (record, from) = first.as_ref().map_or((String::new(), 0.0), |(index, _)| {
            let window = self.windows[*index];
            let record = &self.sources.records[window.record];
            (record.name.clone(), record.times[window.from])
        });
        let reason = first.map_or_else(|| "no window was given".to_owned(), |f| f.1);
        Err(DiagnoseError::NoWindow { windows: slots.len(), record, from, reason, remedy: self.remedy() })
    }

    /// What to change in a model that cannot be simulated anywhere.
    fn remedy(&self) -> String {
        let used = self.system.pool.symbols_of(&self.system.dynamics);
        let zero: Vec<String> = self
            .system
            .parameters
            .iter()
            .filter(|p| used.contains(&p.symbol) && p.value.to_f64().value() == 0.0)
            .map(|p| format!("`{}` = 0", self.system.symbol_name(p.symbol)))
            .collect();
        if zero.is_empty() {
            "check the values of the parameters and the units of the columns, or choose shorter windows".to_owned()
        } else {
            format!("if the equations divide by {}, give another value", zero.join(" or "))
        }
    }
}

/// Fits the initial states for the given values of the unknowns, until the sums of squares fall by less than `share` of them.
fn settle_all(slots: &mut [Slot<'_>], compiled: &Compiled, theta: &[f64], share: f64) {
    slots.par_iter_mut().for_each(|slot| slot.settle(compiled, theta, share));
}

pub(super) fn theta_of(fit: &Fit) -> Vec<f64> {
    fit.values.iter().map(|e| e.value).collect()
}

fn refitted(system: &System, fixed: &[String]) -> Vec<usize> {
    let mut expressions = system.dynamics.clone();
    expressions.extend(system.outputs.iter().map(|(_, e)| *e));
    let used = system.pool.symbols_of(&expressions);
    (0..system.parameters.len())
        .filter(|&i| {
            let parameter = &system.parameters[i];
            used.contains(&parameter.symbol)
                && !is_natural_constant(system, parameter)
                && !parameter.is_fixed()
                && !fixed.iter().any(|name| name == system.symbol_name(parameter.symbol))
        })
        .collect()
}

fn check(system: &System, records: &[Record], settings: &StudySettings) -> Result<(), DiagnoseError> {
    if records.is_empty() {
        return Err(DiagnoseError::NoRecords);
    }
    if let Some(length) = settings.window
        && !(length > 0.0 && length.is_finite())
    {
        return Err(DiagnoseError::Setting {
            name: "the length of the windows (--window)",
            value: length,
            requirement: "positive",
        });
    }
    for name in &settings.fixed {
        let known: Vec<&str> = system.parameters.iter().map(|p| system.symbol_name(p.symbol)).collect();
        if !known.contains(&name.as_str()) {
            return Err(DiagnoseError::UnknownName { what: "parameter", name: name.clone(), known: known.join(", ") });
        }
    }
    for record in records {
        let pairs = [
            ("inputs", system.inputs.len(), record.inputs.len()),
            ("input derivatives", system.input_derivatives.len(), record.input_derivatives.len()),
        ];
        for (what, expected, found) in pairs {
            if expected != found {
                return Err(DiagnoseError::Mismatch { record: record.name.clone(), what, expected, found });
            }
        }
        if record.measured.is_empty() {
            let mut known = system.state_names();
            known.extend(system.outputs.iter().map(|(name, _)| name.clone()));
            return Err(DiagnoseError::NothingMeasured { record: record.name.clone(), known: known.join(", ") });
        }
        for m in &record.measured {
            if !(m.noise > 0.0 && m.noise.is_finite()) {
                return Err(DiagnoseError::Setting {
                    name: "the noise of a measured column",
                    value: m.noise,
                    requirement: "positive",
                });
            }
        }
    }
    Ok(())
}
