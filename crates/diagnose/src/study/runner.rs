//! The simulation of one window, for any values of the unknowns.

use super::column_path::ColumnPath;
use super::compiled::{Compiled, Target};
use super::signal_path::through_path;
use super::tracked::TrackedPoint;
use super::trajectory::Trajectory;
use super::window::{Window, stretches};
use crate::effect::Path;
use crate::error::DiagnoseError;
use crate::record::Record;
use crate::signal::Quantity;
use bracketry_sim::{Model, Outcome, SimulationSettings, Stepper, Switched};

/// Why a window cannot be simulated.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Failure {
    pub(super) t: f64,
    pub(super) reason: String,
}

impl Failure {
    /// Before the first simulation.
    pub(super) fn not_simulated() -> Self {
        Self { t: f64::NAN, reason: "it was not simulated".to_owned() }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "at t = {} s: {}", self.t, self.reason)
    }
}

/// When a measured column is to be read off the simulation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    t: f64,
    pub(super) column: usize,
    pub(super) sample: usize,
}

/// What columns show on time and late by a delay, over their noise, column by column.
pub(super) struct Delayed {
    pub(super) delay: f64,
    pub(super) now: Vec<f64>,
    pub(super) late: Vec<f64>,
}

/// The paths of the signals, for some values of the unknowns.
#[derive(Clone, Debug, PartialEq)]
struct SignalPaths {
    /// Delay and lag of each input.
    inputs: Vec<(f64, f64)>,
    columns: Vec<ColumnPath>,
    /// A tracked point off the center of mass, and where it is.
    tracked: Option<(TrackedPoint, [f64; 2])>,
}

/// Simulates one window.
pub(super) struct Runner<'a> {
    records: &'a [Record],
    pub(super) record: &'a Record,
    pub(super) compiled: &'a Compiled,
    pub(super) window: Window,
    /// First and last sample whose inputs may be used.
    usable: (usize, usize),
    pub(super) stepper: Stepper<Model>,
    /// What was simulated last.
    pub(super) trajectory: Trajectory,
    paths: Option<SignalPaths>,
    pub(super) schedule: Vec<Reading>,
    start: f64,
    /// Measured values over their noise, column by column; 0 where lost.
    pub(super) target: Vec<f64>,
    /// Whether a value was measured.
    pub(super) present: Vec<bool>,
    /// 1/σ of each column.
    pub(super) weights: Vec<f64>,
    /// What the filters of the columns show at first, over the noise; `None`: what suits the measurements best.
    pub(super) filter_starts: Option<Vec<f64>>,
}

impl<'a> Runner<'a> {
    pub(super) fn new(
        records: &'a [Record],
        compiled: &'a Compiled,
        window: Window,
        noise: &[f64],
    ) -> Result<Self, DiagnoseError> {
        let record = &records[window.record];
        let usable = stretches(record)
            .into_iter()
            .find(|&(from, to)| (from..to).contains(&window.from))
            .map_or((window.from, window.to - 1), |(from, to)| (from, to - 1));
        let weights: Vec<f64> = noise.iter().map(|s| 1.0 / s).collect();
        let mut target = Vec::new();
        let mut present = Vec::new();
        for (m, w) in record.measured.iter().zip(&weights) {
            for &y in &m.values[window.from..window.to] {
                present.push(y.is_finite());
                target.push(if y.is_finite() { y * w } else { 0.0 });
            }
        }
        let model = compiled.models[window.record].clone();
        let t0 = record.times[window.from];
        let solver = &compiled.settings.solver;
        let mut settings = SimulationSettings::default().with_tolerance(solver.tolerance.0, solver.tolerance.1);
        settings.max_steps = solver.most_steps;
        settings.stop = compiled.stop.clone();
        let start = vec![0.0; model.dim()];
        let stepper = Stepper::new(model, t0, &start, &settings)?;
        let schedule = Vec::with_capacity(target.len());
        Ok(Self {
            records,
            record,
            compiled,
            window,
            usable,
            stepper,
            trajectory: Trajectory::default(),
            paths: None,
            schedule,
            start: t0,
            target,
            present,
            weights,
            filter_starts: None,
        })
    }

    pub(super) fn samples(&self) -> usize {
        self.window.to - self.window.from
    }

    /// Mean time between samples, s.
    pub(super) fn sampling(&self) -> f64 {
        let times = &self.record.times[self.window.from..self.window.to];
        (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64
    }

    fn paths(&self, theta: &[f64]) -> SignalPaths {
        let mut paths = SignalPaths {
            inputs: vec![(0.0, 0.0); self.record.inputs.len()],
            columns: vec![ColumnPath::default(); self.record.measured.len()],
            tracked: None,
        };
        for (value, target) in theta.iter().zip(&self.compiled.targets) {
            match target {
                Target::Equations => {}
                Target::Tracked(point, number) => {
                    paths.tracked.get_or_insert((*point, [0.0; 2])).1[*number] = *value;
                }
                Target::Input(path, inputs) => {
                    for &i in inputs {
                        match path {
                            Path::ActuatorLag => paths.inputs[i].1 += value,
                            Path::InputDelay
                            | Path::SensorDelay
                            | Path::SensorLag
                            | Path::DigitalFilter
                            | Path::SensorBias
                            | Path::SensorDrift => paths.inputs[i].0 += value,
                        }
                    }
                }
                Target::Column(path, names) => {
                    for (column, m) in paths.columns.iter_mut().zip(&self.record.measured) {
                        if names.contains(&m.name) {
                            column.add(*path, *value);
                        }
                    }
                }
            }
        }
        paths
    }

    /// Gives the unknowns their values; tables and schedule are made anew only where they change.
    pub(super) fn set(&mut self, theta: &[f64]) -> Result<(), Failure> {
        let paths = self.paths(theta);
        let model = self.stepper.system_mut();
        for ((value, unknown), target) in theta.iter().zip(&self.compiled.unknowns).zip(&self.compiled.targets) {
            if *target == Target::Equations {
                model.set_live(&unknown.name, *value);
            }
        }
        let old = self.paths.as_ref();
        let delays = |w: &SignalPaths| w.columns.iter().map(|c| c.delay).collect::<Vec<_>>();
        if old.is_none_or(|old| delays(old) != delays(&paths)) {
            self.make_schedule(&paths);
        }
        let start = self.record.times[self.window.from] - paths.columns.iter().map(|c| c.delay).fold(0.0, f64::max);
        let moved = start != self.start;
        self.start = start;
        for d in &self.compiled.driven {
            let (delay, lag) = paths.inputs[d.input];
            if !moved && self.paths.as_ref().is_some_and(|old| old.inputs[d.input] == (delay, lag)) {
                continue;
            }
            let signal = d.signal(self.window.record, self.records);
            // Up to one sample past the window, for straight lines and the value held last.
            let last = self.window.to.min(self.usable.1);
            // The model's own delay comes on top.
            let needed = start - self.stepper.system().samples_delay(&d.name);
            let history = self.compiled.settings.solver.lag_history;
            let samples =
                through_path(&self.record.times, signal, (self.usable.0, last), needed, (delay, lag), history)
                    .map_err(|e| Failure { t: start, reason: e.to_string() })?;
            self.stepper.system_mut().set_samples(&d.name, d.order, samples);
        }
        self.paths = Some(paths);
        Ok(())
    }

    /// A tracked point off the center of mass, and where it is.
    pub(super) fn tracked(&self) -> Option<(TrackedPoint, [f64; 2])> {
        self.paths.as_ref()?.tracked
    }

    fn make_schedule(&mut self, paths: &SignalPaths) {
        self.schedule.clear();
        for sample in 0..self.samples() {
            for (column, path) in paths.columns.iter().enumerate() {
                let delay = path.delay;
                self.schedule.push(Reading { t: self.record.times[self.window.from + sample] - delay, column, sample });
            }
        }
        // Stable, so that columns of one time stay together.
        self.schedule.sort_by(|a, b| a.t.total_cmp(&b.t));
    }

    /// Simulates from `x0` at the window's start (earlier by the longest sensor delay) and writes what the columns would
    /// show, over their noise, column by column; 0 where the measurement was lost.
    pub(super) fn simulate(&mut self, theta: &[f64], x0: &[f64], out: &mut [f64]) -> Result<(), Failure> {
        self.trajectory.forget();
        if self.compiled.differentiable {
            self.stepper.follow(std::mem::take(&mut self.trajectory.path));
        }
        let before = self.stepper.statistics();
        let simulated = self.run(theta, x0, out);
        self.compiled.counter.simulation(before, self.stepper.statistics());
        if self.compiled.differentiable {
            self.trajectory.path = self.stepper.take_path();
            self.trajectory.of = simulated.is_ok().then(|| (theta.to_vec(), x0.to_vec()));
        }
        simulated
    }

    fn run(&mut self, theta: &[f64], x0: &[f64], out: &mut [f64]) -> Result<(), Failure> {
        self.begin(theta, x0)?;
        let reached = self.read(out);
        self.trajectory.shown.clear();
        self.trajectory.shown.extend_from_slice(out);
        self.trajectory.filter_starts = self.through_paths(&self.columns(), out);
        reached
    }

    /// Simulates and writes what the columns would show without filters and offsets, as far as it comes.
    fn read(&mut self, out: &mut [f64]) -> Result<(), Failure> {
        let m = self.samples();
        let tracked = self.tracked();
        let mut outputs = None;
        for k in 0..self.schedule.len() {
            let Reading { t, column, sample } = self.schedule[k];
            self.reach(t)?;
            self.trajectory.marks.push(self.stepper.followed());
            if let Some((point, _)) = tracked {
                let x = self.stepper.state();
                self.trajectory.turns.push((x[point.angle], x[point.spin]));
            }
            let value = self.shown(t, column, &mut outputs)?;
            out[column * m + sample] = value * self.weights[column];
        }
        Ok(())
    }

    /// What the columns would show if none were late, and if all were late by `delay`, both from `x0` at the window's start less
    /// the delay, as the unknowns have it: one simulation for the delays of all columns.
    pub(super) fn simulate_late(&mut self, theta: &[f64], x0: &[f64], delay: f64) -> Result<Delayed, Failure> {
        self.trajectory.forget();
        let before = self.stepper.statistics();
        let simulated = self.run_late(theta, x0, delay);
        self.compiled.counter.simulation(before, self.stepper.statistics());
        simulated
    }

    fn run_late(&mut self, theta: &[f64], x0: &[f64], delay: f64) -> Result<Delayed, Failure> {
        self.begin(theta, x0)?;
        let m = self.samples();
        let times = &self.record.times[self.window.from..self.window.to];
        let mut readings: Vec<(f64, usize, bool)> =
            times.iter().enumerate().flat_map(|(sample, t)| [(t - delay, sample, true), (*t, sample, false)]).collect();
        readings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let columns = vec![0.0; self.target.len()];
        let mut both = Delayed { delay, now: columns.clone(), late: columns };
        let mut outputs = None;
        for (t, sample, late) in readings {
            self.reach(t)?;
            let out = if late { &mut both.late } else { &mut both.now };
            for column in 0..self.weights.len() {
                out[column * m + sample] = self.shown(t, column, &mut outputs)? * self.weights[column];
            }
        }
        let columns = self.columns();
        self.through_paths(&columns, &mut both.now);
        self.through_paths(&columns, &mut both.late);
        Ok(both)
    }

    /// Goes to the start with an initial state.
    fn begin(&mut self, theta: &[f64], x0: &[f64]) -> Result<(), Failure> {
        self.set(theta)?;
        let start = self.start;
        self.stepper.set_state(start, x0).map_err(|e| Failure { t: start, reason: e.to_string() })
    }

    /// The paths of the measured columns, for the values of the unknowns that were set last.
    pub(super) fn columns(&self) -> Vec<ColumnPath> {
        self.paths.iter().flat_map(|w| w.columns.iter().copied()).collect()
    }

    /// Simulates until a time.
    fn reach(&mut self, t: f64) -> Result<(), Failure> {
        if t > self.stepper.time()
            && let Outcome::Stopped { reason, t, .. } = self.stepper.advance(t)
        {
            return Err(Failure { t, reason: reason.to_string() });
        }
        Ok(())
    }

    /// What a column shows at the present time `t`; `outputs` are those computed last, with their time.
    fn shown(&mut self, t: f64, column: usize, outputs: &mut Option<(f64, Vec<f64>)>) -> Result<f64, Failure> {
        let value = match self.record.measured[column].quantity {
            Quantity::State(i) => {
                let x = self.stepper.state();
                let shift =
                    self.tracked().map_or(0.0, |(point, d)| point.shift(i, (x[point.angle], x[point.spin]), d).value);
                x[i] + shift
            }
            Quantity::Output(i) => {
                if outputs.as_ref().is_none_or(|(of, _)| *of != t) {
                    let x = self.stepper.state().to_vec();
                    *outputs = Some((t, self.stepper.system_mut().output_values(t, &x)));
                }
                outputs.as_ref().map_or(f64::NAN, |(_, y)| y[i])
            }
        };
        if value.is_finite() {
            return Ok(value);
        }
        Err(Failure { t, reason: "the simulated measurement is not finite".into() })
    }

    /// As [`Self::simulate`], and the number of steps that it took; `None` where it ended early.
    pub(super) fn steps(&mut self, theta: &[f64], x0: &[f64], out: &mut [f64]) -> Option<usize> {
        let before = self.stepper.statistics();
        self.simulate(theta, x0, out).ok()?;
        let after = self.stepper.statistics();
        Some(after.steps + after.rejected - before.steps - before.rejected)
    }
}
