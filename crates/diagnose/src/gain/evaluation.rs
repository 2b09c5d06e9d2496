//! Equations of motion along data, with states and rates from smoothing splines.

use std::f64::consts::PI;
use std::ops::Range;

use bracketry_sim::{Bandwidth, Hold, SmoothingSpline};
use bracketry_symbolic::{Expr, Node, Symbol, Tape};
use bracketry_system::System;

use super::motion::{Origin, origins};
use super::rest::Rest;
use crate::effect::{Change, Effect, Path};
use crate::error::DiagnoseError;
use crate::extend::equations;
use crate::library::{Structure, TIME_INPUT};
use crate::record::Record;
use crate::settings::EquationSettings;
use crate::signal::{Measured, Signal};
use crate::study::{Estimate, lagged, stretches};

/// One stretch of a record without a gap, with the equations evaluated at all of its samples.
pub(super) struct Evaluated {
    /// Index of the record.
    pub(super) record: usize,
    /// Its first sample.
    pub(super) from: usize,
    /// Samples of the stretch, counted from its first, that are far enough from its ends.
    pub(super) kept: Range<usize>,
    times: Vec<f64>,
    /// Bandwidth, Hz.
    pub(super) bandwidth: f64,
    /// The equations.
    pub(super) rows: Vec<EvaluatedRow>,
    /// The states that measured columns give.
    pub(super) states: Vec<Option<Vec<f64>>>,
    /// Inputs, then their derivatives, as they reach the equations.
    pub(super) inputs: Vec<Vec<f64>>,
    /// By coordinate what a unit of its force adds: the state in whose equation, and the values.
    pub(super) forces: Vec<Vec<(usize, Vec<f64>)>>,
}

/// One equation along a stretch.
pub(super) struct EvaluatedRow {
    /// The state whose time derivative it gives.
    pub(super) state: usize,
    /// The only input in it.
    pub(super) input: Option<usize>,
    /// The right-hand side; where dry friction holds, the value within its bounds that is nearest to `rate`.
    pub(super) model: Vec<f64>,
    /// The time derivative of the state.
    pub(super) rate: Vec<f64>,
    /// ∂f/∂u of the only input, else 1.
    pub(super) gain: Vec<f64>,
    /// Standard deviation of `rate` by noise of the sensor, once it is smoothed to the bandwidth.
    pub(super) noise: f64,
}

impl Evaluated {
    /// Values at all samples, NaN where there is none, smoothed to the bandwidth; `None` if too few are there.
    pub(super) fn smooth(&self, values: &[f64]) -> Option<Vec<f64>> {
        Some(SmoothingSpline::fit(&self.times, values, Bandwidth::Cutoff(self.bandwidth))?.values)
    }

    /// Time of a sample of the stretch, s.
    pub(super) fn time(&self, sample: usize) -> f64 {
        self.times[sample]
    }
}

/// The equations of a model, with the effects in their signal paths.
pub(super) struct Equations {
    system: System,
    tape: Tape,
    rows: Vec<Row>,
    /// What the coordinates of the model are like, if it was asked for.
    pub(super) mechanics: Option<Structure>,
    /// By coordinate the entries of its force: the state in whose equation they stand, and their place among the outputs of
    /// the tape.
    forces: Vec<Vec<(usize, usize)>>,
    /// Where dry friction holds.
    rest: Option<Rest>,
    /// Delay and lag of each input.
    inputs: Vec<(f64, f64)>,
    /// Name, and delay, offset, drift, and time constant of a filter, of measured columns.
    columns: Vec<(String, [f64; 4])>,
    pub(super) settings: EquationSettings,
}

/// An equation that can be evaluated on data.
struct Row {
    state: usize,
    /// The only input in it, by index, with the place of ∂f/∂u among the outputs of the tape.
    gain: Option<(usize, usize)>,
    needs: Vec<Symbol>,
}

impl Equations {
    /// The equations of a changed model; with `forces` along which directions forces act in them, too.
    pub(super) fn new(
        system: &System,
        effects: &[Effect],
        values: &[Estimate],
        forces: bool,
        settings: &EquationSettings,
    ) -> Result<Self, DiagnoseError> {
        let mut system = equations(system, effects, values)?;
        // The model's own delays; a delay that is no number is refused where the model is simulated.
        let mut inputs: Vec<(f64, f64)> =
            system.delay_values().into_iter().map(|delay| (delay.unwrap_or(0.0), 0.0)).collect();
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
                    (Path::SensorDelay, _) => columns.push((name.clone(), [value, 0.0, 0.0, 0.0])),
                    (Path::SensorBias, _) => columns.push((name.clone(), [0.0, value, 0.0, 0.0])),
                    (Path::SensorDrift, _) => columns.push((name.clone(), [0.0, 0.0, value, 0.0])),
                    (Path::SensorLag | Path::DigitalFilter, _) => {
                        columns.push((name.clone(), [0.0, 0.0, 0.0, value]));
                    }
                    (Path::InputDelay | Path::ActuatorLag, None) => {}
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
        let mechanics = forces.then(|| Structure::of_model(&mut system));
        let entries = mechanics.iter().flat_map(|m| &m.coordinates).map(|coordinate| {
            let entry = |(row, e): &(usize, Expr)| {
                expressions.push(*e);
                (*row, expressions.len() - 1)
            };
            coordinate.force.iter().map(entry).collect()
        });
        let forces = entries.collect();
        let arguments = system.arguments();
        let tape = system
            .compile(&arguments, &expressions)
            .map_err(|e| DiagnoseError::Term { text: system.name.clone(), message: e.to_string() })?;
        let rest = Rest::new(&mut system, &arguments)?;
        Ok(Self { system, tape, rows, mechanics, forces, rest, inputs, columns, settings: settings.clone() })
    }

    /// Name of a state.
    pub(super) fn state_name(&self, state: usize) -> String {
        self.system.symbol_name(self.system.states[state]).to_owned()
    }

    /// Name of an input.
    pub(super) fn input_name(&self, input: usize) -> String {
        self.system.symbol_name(self.system.inputs[input]).to_owned()
    }

    /// The equations along a record, by stretch; equations that need what was not measured, and stretches that are too short or too
    /// noisy, are left out.
    pub(super) fn evaluate(&self, index: usize, record: &Record) -> Vec<Evaluated> {
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
            .filter_map(|(from, to)| {
                let stretch =
                    Stretch { from, to, dt: (record.times[to - 1] - record.times[from]) / (to - from - 1) as f64 };
                self.in_stretch(index, record, &derivatives, &stretch, &origins, &rows)
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
    ) -> Option<Evaluated> {
        let range = stretch.from..stretch.to;
        let times = &record.times[range.clone()];
        let settings = &self.settings;
        let bandwidth = rows
            .iter()
            .map(|(_, origin)| {
                let m = &record.measured[origin.column];
                bandwidth(times, &m.values[range.clone()], m.noise, origin.order + 1, stretch.dt, settings)
            })
            .try_fold(f64::INFINITY, |least, b| Some(least.min(b?)))?;
        let lost = (settings.lost_periods / (bandwidth * stretch.dt)).ceil() as usize;
        let kept = lost..times.len().checked_sub(lost).filter(|&end| end > lost)?;

        let columns = self.columns(record, stretch, settings.state_bandwidth * bandwidth)?;
        let signals = self.signals(record, derivatives, stretch);
        let of = |o: &Origin| columns[o.column].iter().map(|x| x[o.order]).collect::<Vec<f64>>();
        let states: Vec<Option<Vec<f64>>> = origins.iter().map(|o| o.as_ref().map(of)).collect();
        let mut arguments = vec![0.0; origins.len() + signals.len()];
        let mut work = Vec::new();
        let mut results = vec![0.0; self.tape.n_outputs()];
        let mut evaluated: Vec<EvaluatedRow> = rows
            .iter()
            .map(|(row, origin)| EvaluatedRow {
                state: row.state,
                input: row.gain.map(|g| g.0),
                model: Vec::with_capacity(times.len()),
                rate: columns[origin.column].iter().map(|x| x[origin.order + 1]).collect(),
                gain: Vec::with_capacity(times.len()),
                noise: deviation(record.measured[origin.column].noise, origin.order + 1, bandwidth, stretch.dt),
            })
            .collect();
        let mut forces: Vec<Vec<(usize, Vec<f64>)>> =
            self.forces.iter().map(|f| f.iter().map(|(row, _)| (*row, Vec::new())).collect()).collect();
        let mut rest = self.rest.clone();
        let noise: Vec<f64> = origins
            .iter()
            .map(|o| {
                o.map_or(0.0, |o| {
                    deviation(
                        record.measured[o.column].noise,
                        o.order,
                        settings.state_bandwidth * bandwidth,
                        stretch.dt,
                    )
                })
            })
            .collect();
        for k in 0..times.len() {
            let states = states.iter().map(|values| values.as_ref().map_or(0.0, |v| v[k]));
            arguments.iter_mut().zip(states.chain(signals.iter().map(|u| u[k]))).for_each(|(slot, v)| *slot = v);
            self.tape.eval(&arguments, &mut work, &mut results);
            let ranges = rest.as_mut().and_then(|rest| rest.range(&arguments, &noise, settings));
            for (out, (row, _)) in evaluated.iter_mut().zip(rows) {
                // What dry friction holds moves as it does.
                let held = ranges.as_ref().map(|r| r[row.state]).filter(|[low, high]| low <= high);
                out.model.push(held.map_or(results[row.state], |[low, high]| out.rate[k].clamp(low, high)));
                out.gain.push(row.gain.map_or(1.0, |(_, place)| results[place]));
            }
            for (lists, places) in forces.iter_mut().zip(&self.forces) {
                for ((_, values), (_, place)) in lists.iter_mut().zip(places) {
                    values.push(results[*place]);
                }
            }
        }
        Some(Evaluated {
            record: index,
            from: stretch.from,
            kept,
            times: times.to_vec(),
            bandwidth,
            rows: evaluated,
            states,
            inputs: signals,
            forces,
        })
    }

    /// Value, first and second derivative of every measured column, without its delay, offset, drift, and filter, up to a bandwidth
    /// in Hz. Behind a filter stands y + τ y'; its second derivative, for which the spline is not smooth enough, is taken later by τ instead.
    fn columns(&self, record: &Record, stretch: &Stretch, bandwidth: f64) -> Option<Vec<Vec<[f64; 3]>>> {
        let range = stretch.from..stretch.to;
        let times = &record.times[range.clone()];
        let of_column = |m: &Measured| {
            let paths = self.columns.iter().filter(|path| path.0 == m.name);
            let [delay, offset, drift, lag] =
                paths.fold([0.0; 4], |sum, path| [0, 1, 2, 3].map(|k| sum[k] + path.1[k]));
            let spline = SmoothingSpline::fit(times, &m.values[range.clone()], Bandwidth::Cutoff(bandwidth))?;
            let start = record.times[0];
            let exact = |t: &f64| {
                let [x, d, dd] = spline.at(t + delay);
                let later = if lag > 0.0 { spline.at(t + delay + lag)[2] } else { dd };
                let (x, d) = (x - offset - drift * (t + delay - start), d - drift);
                [x + lag * d, d + lag * dd, later]
            };
            Some(times.iter().map(exact).collect())
        };
        record.measured.iter().map(of_column).collect()
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
            values = lagged(&record.times[range], &values, signal.hold, lag, values[0]);
        }
        let half = if signal.hold == Hold::Previous { 0.5 } else { 0.0 };
        shifted(&values, delay / stretch.dt + half)
    }
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

/// The largest bandwidth up to `samples_per_period` at which noise of the sensor makes up no more than `most_derivative_noise` of the
/// derivative of the given order.
fn bandwidth(
    times: &[f64],
    values: &[f64],
    noise: f64,
    order: usize,
    dt: f64,
    settings: &EquationSettings,
) -> Option<f64> {
    let mut b = 1.0 / (settings.samples_per_period * dt);
    let narrowest = settings.fewest_periods / (dt * times.len() as f64);
    while b > narrowest {
        let spline = SmoothingSpline::fit(times, values, Bandwidth::Cutoff(b))?;
        let derivative = if order == 1 { &spline.first } else { &spline.second };
        let mean_square = derivative.iter().map(|v| v * v).sum::<f64>() / derivative.len() as f64;
        if deviation(noise, order, b, dt) <= settings.most_derivative_noise * mean_square.sqrt() {
            return Some(b);
        }
        b *= settings.narrower;
    }
    None
}

/// Standard deviation of a derivative of order p by white noise of the sensor. Noise of density `2σ²dt` through the spline's gain
/// `1/(1 + (f/B)⁶)` gives it the variance `2σ²dt (2π)²ᵖ B²ᵖ⁺¹ (1 − a)π/(6 sin πa)` with `a = (2p + 1)/6`.
fn deviation(noise: f64, order: usize, bandwidth: f64, dt: f64) -> f64 {
    let p = order as i32;
    let a = f64::from(2 * p + 1) / 6.0;
    let gain = (1.0 - a) * PI / (6.0 * (PI * a).sin());
    noise * (2.0 * dt * (2.0 * PI).powi(2 * p) * bandwidth.powi(2 * p + 1) * gain).sqrt()
}
