//! The force error: what the equations leave over when states and accelerations come from the data.

use std::f64::consts::PI;

use bracketry_sim::Hold;
use bracketry_symbolic::{Node, Symbol, Tape};
use bracketry_system::System;

use super::motion::{Origin, origins};
use crate::effect::{Change, Effect, Path};
use crate::error::DiagnoseError;
use crate::extend::equations;
use crate::library::TIME_INPUT;
use crate::read::{Bandwidth, SmoothingSpline};
use crate::record::{Record, Signal};
use crate::study::{Estimate, lagged, stretches};

/// Samples per period of the fastest motion that counts: about 48 Hz at 1 kHz. A force error grows with its bandwidth; with this one the
/// published errors of the EMPS benchmark (Janot, Gautier and Brunot 2019; filtered differently) are met on both of its runs.
const SAMPLES_PER_PERIOD: f64 = 21.0;
/// Most of the acceleration's size that may be noise of the sensor.
const MOST_NOISE: f64 = 0.02;
/// The states on the right-hand side are smoothed less than what is left over, by this factor, so that friction stays steep.
const WIDER: f64 = 2.5;
/// Ratio of the bandwidths that are tried one after the other.
const NARROWER: f64 = 0.84;
/// Periods of the bandwidth that are left out at each end, where splines are less exact.
const LOST_PERIODS: f64 = 3.0;
/// Share of the root mean square of ∂f/∂u below which the input hardly acts.
const WEAK: f64 = 0.1;
/// Fewest periods of the bandwidth in a stretch.
const FEWEST_PERIODS: f64 = 12.0;

/// Why there may be no force residual, for notes.
pub(crate) const NO_FORCE: &str =
    "no equation has all its states measured, in an even stretch long enough for derivatives above their noise";

/// What one equation leaves over in one stretch of a record, over time.
#[derive(Clone, Debug)]
pub struct ForceResidual {
    /// Index of the record.
    pub record: usize,
    /// The state whose time derivative the equation gives.
    pub equation: String,
    /// The input in whose unit the values are; `None`: they are time derivatives of the state.
    pub input: Option<String>,
    /// Sample of each value.
    pub samples: Vec<usize>,
    /// Applied minus needed: `(f − x')/(∂f/∂u)`, or `f − x'`.
    pub values: Vec<f64>,
    /// What they are compared with: the input, or `x'`.
    pub reference: Vec<f64>,
    /// The state itself.
    pub state: Vec<f64>,
    /// Bandwidth, Hz.
    pub bandwidth: f64,
}

impl ForceResidual {
    /// The part at some samples.
    pub(super) fn only(mut self, samples: impl Fn(usize) -> bool) -> Self {
        let kept: Vec<bool> = self.samples.iter().map(|&k| samples(k)).collect();
        for list in [&mut self.values, &mut self.reference, &mut self.state] {
            let mut inside = kept.iter();
            list.retain(|_| inside.next() == Some(&true));
        }
        self.samples.retain(|&k| samples(k));
        self
    }
}

/// What the equations of a model leave over in records, by record, stretch without a gap and equation, with states and
/// accelerations from smoothing splines. `effects` and `values` (parameters and coefficients by name) change the model; without
/// them it is taken as it stands.
///
/// Equations that need states which no measured column gives, directly or as a derivative, and stretches that are too short
/// or too noisy, are left out; so are samples at which the input hardly acts, `|∂f/∂u|` below a tenth of its root mean square.
///
/// # Errors
/// [`DiagnoseError`] for effects that do not fit the model.
pub fn force_residuals(
    system: &System,
    effects: &[Effect],
    values: &[Estimate],
    records: &[Record],
) -> Result<Vec<ForceResidual>, DiagnoseError> {
    let equations = Equations::new(system, effects, values)?;
    Ok(records.iter().enumerate().flat_map(|(index, record)| equations.residuals(index, record)).collect())
}

/// The force error, `‖residual‖/‖reference‖` over all samples of an equation; of several equations the root mean square.
/// `None` if no equation could be evaluated.
pub fn force_error(residuals: &[ForceResidual]) -> Option<f64> {
    let mut names: Vec<&str> = residuals.iter().map(|r| r.equation.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let square = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
    let mut sum = 0.0;
    for name in &names {
        let of = residuals.iter().filter(|r| r.equation == *name);
        let (left, whole) = of.fold((0.0, 0.0), |(a, b), r| (a + square(&r.values), b + square(&r.reference)));
        sum += left / whole;
    }
    let error = (sum / names.len() as f64).sqrt();
    error.is_finite().then_some(error)
}

/// The equations of a model, with what is on the way of their signals.
struct Equations {
    system: System,
    tape: Tape,
    rows: Vec<Row>,
    /// Delay and lag of each input.
    inputs: Vec<(f64, f64)>,
    /// Name, delay and offset of measured columns.
    columns: Vec<(String, f64, f64)>,
}

/// An equation that can be evaluated on data.
struct Row {
    state: usize,
    /// The only input in it, by index, with the place of ∂f/∂u among the outputs of the tape.
    gain: Option<(usize, usize)>,
    needs: Vec<Symbol>,
}

impl Equations {
    fn new(system: &System, effects: &[Effect], values: &[Estimate]) -> Result<Self, DiagnoseError> {
        let mut system = equations(system, effects, values)?;
        let mut inputs = vec![(0.0, 0.0); system.inputs.len()];
        let mut columns = Vec::new();
        for effect in effects {
            let (Change::Path { path, signals }, Some(c)) = (&effect.change, effect.coefficients.first()) else {
                continue;
            };
            let value = values.iter().find(|e| e.name == c.name).map_or(c.nominal, |e| e.value);
            for name in signals {
                match (path, system.input_index(name)) {
                    (Path::InputDelay, Some(i)) => inputs[i].0 += value,
                    (Path::ActuatorLag, Some(i)) => inputs[i].1 += value,
                    (Path::SensorDelay, _) => columns.push((name.clone(), value, 0.0)),
                    (Path::SensorBias, _) => columns.push((name.clone(), 0.0, value)),
                    _ => {}
                }
            }
        }
        let mut expressions = system.dynamics.clone();
        let mut rows = Vec::new();
        for state in 0..system.states.len() {
            let f = system.dynamics[state];
            if matches!(system.pool.node(f), Node::Sym(s) if system.states.contains(&s)) {
                continue;
            }
            let needs = system.pool.symbols_of(&[f]);
            let used: Vec<usize> = (0..system.inputs.len()).filter(|&i| needs.contains(&system.inputs[i])).collect();
            let gain = match used.as_slice() {
                [only] => {
                    let by_input = system.pool.diff(f, system.inputs[*only]);
                    expressions.push(by_input);
                    Some((*only, expressions.len() - 1))
                }
                _ => None,
            };
            rows.push(Row { state, gain, needs });
        }
        let arguments = system.arguments();
        let tape = system
            .compile(&arguments, &expressions)
            .map_err(|e| DiagnoseError::Term { text: system.name.clone(), message: e.to_string() })?;
        Ok(Self { system, tape, rows, inputs, columns })
    }

    /// What the equations leave over in a record, by stretch and equation; equations that need what was not measured, and
    /// stretches with uneven sampling or too much noise, are left out.
    fn residuals(&self, index: usize, record: &Record) -> Vec<ForceResidual> {
        // Effects may use derivatives that the record does not have.
        let mut derivatives = record.input_derivatives.clone();
        for d in self.system.input_derivatives.iter().skip(derivatives.len()) {
            let Some(signal) = record.differentiated_input(d.input, d.order) else { return Vec::new() };
            derivatives.push(signal);
        }
        let origins = origins(&self.system, record);
        let has = |s: &Symbol| self.system.states.iter().position(|x| x == s).is_none_or(|i| origins[i].is_some());
        let rows: Vec<(&Row, Origin)> = self
            .rows
            .iter()
            .filter(|row| row.needs.iter().all(has))
            .filter_map(|row| Some((row, origins[row.state]?)))
            .filter(|(_, origin)| origin.order < 2)
            .collect();
        if rows.is_empty() {
            return Vec::new();
        }
        stretches(record)
            .into_iter()
            .filter(|(from, to)| to - from > 3)
            .flat_map(|(from, to)| {
                let stretch =
                    Stretch { from, to, dt: (record.times[to - 1] - record.times[from]) / (to - from - 1) as f64 };
                self.in_stretch(index, record, &derivatives, &stretch, &origins, &rows).unwrap_or_default()
            })
            .collect()
    }

    fn in_stretch(
        &self,
        index: usize,
        record: &Record,
        derivatives: &[Signal],
        stretch: &Stretch,
        origins: &[Option<Origin>],
        rows: &[(&Row, Origin)],
    ) -> Option<Vec<ForceResidual>> {
        let range = stretch.from..stretch.to;
        let times = &record.times[range.clone()];
        let bandwidth = rows
            .iter()
            .map(|(_, origin)| {
                let m = &record.measured[origin.column];
                bandwidth(times, &m.values[range.clone()], m.noise, origin.order + 1, stretch.dt)
            })
            .try_fold(f64::INFINITY, |least, b| Some(least.min(b?)))?;
        let smooth = |values: &[f64], cutoff: f64| SmoothingSpline::fit(times, values, Bandwidth::Cutoff(cutoff));
        let lost = (LOST_PERIODS / (bandwidth * stretch.dt)).ceil() as usize;
        let kept = lost..times.len().checked_sub(lost).filter(|&end| end > lost)?;

        // Value, first and second derivative of every column, without its delay and offset.
        let columns: Vec<Vec<[f64; 3]>> = record
            .measured
            .iter()
            .map(|m| {
                let ways = self.columns.iter().filter(|way| way.0 == m.name);
                let (delay, offset) = ways.fold((0.0, 0.0), |sum, way| (sum.0 + way.1, sum.1 + way.2));
                let spline = smooth(&m.values[range.clone()], WIDER * bandwidth)?;
                Some(times.iter().map(|t| spline.at(t + delay)).map(|[x, d, dd]| [x - offset, d, dd]).collect())
            })
            .collect::<Option<_>>()?;
        let signals = self.signals(record, derivatives, stretch);
        let mut arguments = vec![0.0; origins.len() + signals.len()];
        let mut work = Vec::new();
        let mut results = vec![0.0; self.tape.n_outputs()];
        // What is missing, its reference, and ∂f/∂u.
        let mut left = vec![[const { Vec::new() }; 3]; rows.len()];
        for k in 0..times.len() {
            let states = origins.iter().map(|o| o.map_or(0.0, |o| columns[o.column][k][o.order]));
            arguments.iter_mut().zip(states.chain(signals.iter().map(|u| u[k]))).for_each(|(slot, v)| *slot = v);
            self.tape.eval(&arguments, &mut work, &mut results);
            for (lists, (row, origin)) in left.iter_mut().zip(rows) {
                let rate = columns[origin.column][k][origin.order + 1];
                let (gain, reference) = row.gain.map_or((1.0, rate), |(i, place)| (results[place], signals[i][k]));
                for (list, value) in lists.iter_mut().zip([results[row.state] - rate, reference, gain]) {
                    list.push(value);
                }
            }
        }
        let weak: Vec<Vec<bool>> = left.iter().map(|lists| weak(&lists[2])).collect();
        for ([values, _, gains], weak) in left.iter_mut().zip(&weak) {
            for ((value, gain), weak) in values.iter_mut().zip(gains.iter()).zip(weak) {
                *value = if *weak { f64::NAN } else { *value / gain };
            }
        }
        let made = rows.iter().zip(left).zip(weak).filter_map(|(((row, origin), [values, reference, _]), weak)| {
            let kept: Vec<usize> = kept.clone().filter(|&k| !weak[k]).collect();
            let at = |list: &[f64]| kept.iter().map(|&k| list[k]).collect::<Vec<f64>>();
            Some(ForceResidual {
                record: index,
                equation: self.system.symbol_name(self.system.states[row.state]).to_owned(),
                input: row.gain.map(|(i, _)| self.system.symbol_name(self.system.inputs[i]).to_owned()),
                samples: kept.iter().map(|k| stretch.from + k).collect(),
                values: at(&smooth(&values, bandwidth)?.values),
                reference: at(&smooth(&reference, bandwidth)?.values),
                state: kept.iter().map(|&k| columns[origin.column][k][origin.order]).collect(),
                bandwidth,
            })
        });
        Some(made.filter(|r| r.values.iter().chain(&r.reference).all(|v| v.is_finite())).collect())
    }

    /// Inputs, then input derivatives, at the samples of a stretch as they reach the equations.
    fn signals(&self, record: &Record, derivatives: &[Signal], stretch: &Stretch) -> Vec<Vec<f64>> {
        let inputs = self.system.inputs.iter().enumerate().map(|(i, &u)| match record.inputs.get(i) {
            Some(signal) => self.arriving(i, signal, record, stretch),
            None if self.system.symbol_name(u) == TIME_INPUT => record.times[stretch.from..stretch.to].to_vec(),
            None => vec![0.0; stretch.to - stretch.from],
        });
        let derivatives = self.system.input_derivatives.iter().zip(derivatives);
        inputs.chain(derivatives.map(|(d, signal)| self.arriving(d.input, signal, record, stretch))).collect()
    }

    /// An input as it reaches the equations, at the samples: lagged, delayed, and if it is held between samples at its mean over
    /// the sampling time around each sample, as smoothed derivatives see it.
    fn arriving(&self, input: usize, signal: &Signal, record: &Record, stretch: &Stretch) -> Vec<f64> {
        let range = stretch.from..stretch.to;
        let (delay, lag) = self.inputs[input];
        let mut values = signal.values[range.clone()].to_vec();
        if lag > 0.0 {
            values = lagged(&record.times[range], &values, signal.hold, lag);
        }
        let half = if signal.hold == Hold::Previous { 0.5 } else { 0.0 };
        shifted(&values, delay / stretch.dt + half)
    }
}

/// Where an input hardly acts: there the force that is missing cannot be told.
fn weak(gains: &[f64]) -> Vec<bool> {
    let rms = (gains.iter().map(|g| g * g).sum::<f64>() / gains.len() as f64).sqrt();
    gains.iter().map(|g| g.abs() < WEAK * rms).collect()
}

/// Samples without a gap, and their mean distance in seconds.
struct Stretch {
    from: usize,
    to: usize,
    dt: f64,
}

/// The signal later by `by` samples, straight lines between samples; the ends last on.
fn shifted(values: &[f64], by: f64) -> Vec<f64> {
    if by == 0.0 {
        return values.to_vec();
    }
    let (whole, part) = (by.floor() as isize, by - by.floor());
    let last = values.len() as isize - 1;
    let at = |k: isize| values[k.clamp(0, last) as usize];
    (0..=last).map(|k| (1.0 - part) * at(k - whole) + part * at(k - whole - 1)).collect()
}

/// The largest bandwidth up to [`SAMPLES_PER_PERIOD`] at which noise of the sensor makes up no more than [`MOST_NOISE`] of the
/// derivative of the given order. White noise of density `2σ²dt` through the spline's gain `1/(1 + (f/B)⁶)` gives a
/// derivative of order p the variance `2σ²dt (2π)²ᵖ B²ᵖ⁺¹ (1 − a)π/(6 sin πa)` with `a = (2p + 1)/6`.
fn bandwidth(times: &[f64], values: &[f64], noise: f64, order: usize, dt: f64) -> Option<f64> {
    let p = order as i32;
    let a = f64::from(2 * p + 1) / 6.0;
    let gain = (1.0 - a) * PI / (6.0 * (PI * a).sin());
    let mut b = 1.0 / (SAMPLES_PER_PERIOD * dt);
    let narrowest = FEWEST_PERIODS / (dt * times.len() as f64);
    while b > narrowest {
        let spline = SmoothingSpline::fit(times, values, Bandwidth::Cutoff(b))?;
        let derivative = if order == 1 { &spline.first } else { &spline.second };
        let mean_square = derivative.iter().map(|v| v * v).sum::<f64>() / derivative.len() as f64;
        let of_noise = 2.0 * noise * noise * dt * (2.0 * PI).powi(2 * p) * b.powi(2 * p + 1) * gain;
        if of_noise <= MOST_NOISE * MOST_NOISE * mean_square {
            return Some(b);
        }
        b *= NARROWER;
    }
    None
}
