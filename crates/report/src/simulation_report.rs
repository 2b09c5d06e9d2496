//! What a simulation gave: its report, its table and its figure.

use std::fmt;

use bracketry_plot::{Drawing, Panel, PlotError, Series, TimeSeries};
use bracketry_sim::{Mode, Outcome};
use bracketry_symbolic::Node;
use bracketry_system::{System, counted, readable};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::friction_bands::{friction_bands, friction_colors};
use crate::{Run, SampledScenario, Scenario};

/// Rounding on a sticking surface, which is not worth an axis of its own.
const ROUNDING: f64 = 1e-13;
/// Plot panels of outputs are drawn up to this many.
const MAX_OUTPUT_PANELS: usize = 6;

/// A change of mode of a switching function.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeChange {
    /// Time in seconds.
    pub t: f64,
    /// The switching function.
    pub switch: String,
    /// The mode before: `+1`, `-1`, `slide` or `stick`.
    pub from: &'static str,
    /// The mode after.
    pub to: &'static str,
}

/// What a simulation gave, in short.
#[derive(Clone, Debug, Serialize)]
pub struct SimulationReport {
    /// Name of the model.
    pub model: String,
    /// Where it began, s.
    #[serde(skip)]
    pub t_start: f64,
    /// Where it ended, s.
    pub t_final: f64,
    /// State at the end, by name, in the order of the model.
    pub x_final: Map<String, Value>,
    /// Whether the end was reached.
    pub finished: bool,
    /// Where and why it stopped before its end.
    pub stopped: Option<String>,
    /// Changes of mode, in order.
    pub events: Vec<ModeChange>,
    /// Accepted steps of the integrator.
    pub steps: usize,
    /// Columns of the table that are no input that the model uses.
    pub ignored_columns: Vec<String>,
    /// Inputs that nothing drives.
    pub inputs_at_zero: Vec<String>,
    /// Derivatives of inputs whose impulses are left out.
    pub impulses_left_out: Vec<String>,
    /// Inputs that these are derivatives of.
    #[serde(skip)]
    jumping: Vec<String>,
    /// Inputs that leave their range, as sentences.
    #[serde(skip)]
    beyond: Vec<String>,
}

impl SimulationReport {
    /// The report of a run of `given` on `system`.
    pub fn new(system: &System, given: &SampledScenario, run: &Run) -> Self {
        let last = run.trajectory.final_state();
        let stopped = match &run.outcome {
            Outcome::Finished => None,
            Outcome::Stopped { reason, t, .. } => {
                let why = run.breakdown.as_ref().map_or_else(|| reason.to_string(), ToString::to_string);
                Some(format!("stopped at t = {} s: {why}", readable(*t)))
            }
        };
        Self {
            model: system.name.clone(),
            t_start: run.trajectory.start(),
            t_final: run.trajectory.end(),
            x_final: system.state_names().into_iter().zip(last.iter().map(|v| Value::from(*v))).collect(),
            finished: stopped.is_none(),
            stopped,
            events: run.mode_changes(),
            steps: run.statistics.steps,
            ignored_columns: given.ignored.clone(),
            inputs_at_zero: given.held_at_zero.clone(),
            impulses_left_out: run.impulses_left_out.iter().map(|(n, order)| format!("der({n},{order})")).collect(),
            jumping: run.impulses_left_out.iter().map(|(n, _)| n.clone()).collect(),
            beyond: beyond_ranges(system, run),
        }
    }
}

impl fmt::Display for SimulationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {} s simulated in {}, {}",
            self.model,
            readable(self.t_final - self.t_start),
            counted(self.steps, "step", "steps"),
            counted(self.events.len(), "change of mode", "changes of mode")
        )?;
        for name in &self.inputs_at_zero {
            writeln!(f, "  nothing drives the input `{name}`: it is zero")?;
        }
        for (input, derivative) in self.jumping.iter().zip(&self.impulses_left_out) {
            writeln!(f, "  warning: `{input}` jumps or has kinks: impulses of {derivative} are left out")?;
        }
        for sentence in &self.beyond {
            writeln!(f, "  warning: {sentence}")?;
        }
        for name in &self.ignored_columns {
            writeln!(f, "  column `{name}` is no input that the model uses and was ignored")?;
        }
        let width = self.x_final.keys().map(|name| name.chars().count()).max().unwrap_or(0).max(10);
        for (name, value) in &self.x_final {
            let value = value.as_f64().unwrap_or(f64::NAN);
            writeln!(f, "  {name:>width$} = {}", readable(value))?;
        }
        match &self.stopped {
            Some(stopped) => writeln!(f, "{stopped}"),
            None => Ok(()),
        }
    }
}

/// What the model says an input cannot do, and it does.
fn beyond_ranges(system: &System, run: &Run) -> Vec<String> {
    let mut sentences = Vec::new();
    for range in &system.input_ranges {
        let Some(k) = system.inputs.iter().position(|i| *i == range.input) else { continue };
        let values = run.inputs.iter().map(|u| u[k]);
        let bounds = [(&range.min, "below", -1.0), (&range.max, "above", 1.0)];
        for (bound, side, sign) in bounds.iter().filter_map(|(b, side, sign)| Some((b.as_ref()?, side, sign))) {
            let bound = bound.to_f64().value();
            let farthest = values.clone().max_by(|a, b| (sign * a).total_cmp(&(sign * b)));
            if let Some(farthest) = farthest.filter(|v| sign * (v - bound) > ROUNDING * bound.abs().max(1.0)) {
                sentences.push(format!(
                    "`{}` goes to {}, {side} the {} of its range in the model",
                    system.symbol_name(range.input),
                    readable(farthest),
                    readable(bound)
                ));
            }
        }
    }
    sentences
}

/// A mode in a word.
fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Positive => "+1",
        Mode::Negative => "-1",
        Mode::Sliding => "slide",
        Mode::Sticking => "stick",
    }
}

/// The outputs that have no column of their own yet, by index, with the names of their columns.
fn output_columns(system: &System) -> Vec<(usize, String)> {
    let symbols = || system.states.iter().chain(&system.inputs);
    let mut columns = Vec::new();
    for (k, (name, e)) in system.outputs.iter().enumerate() {
        let same = symbols().any(|s| system.symbol_name(*s) == name && system.pool.node(*e) == Node::Sym(*s));
        let taken = name == "t" || symbols().any(|s| system.symbol_name(*s) == name);
        if !same {
            columns.push((k, if taken { format!("output {name}") } else { name.clone() }));
        }
    }
    columns
}

/// The inputs that something is known of, by index: not those of which only derivatives are given.
fn input_columns(system: &System, scenario: &Scenario) -> Vec<(usize, String)> {
    let names = system.input_names().into_iter().enumerate();
    names.filter(|(_, name)| !scenario.inputs.only_derivatives(name)).collect()
}

impl Run {
    /// Changes of mode, in order.
    pub fn mode_changes(&self) -> Vec<ModeChange> {
        let transitions = self.trajectory.transitions().iter();
        transitions
            .map(|e| ModeChange {
                t: e.t,
                switch: self.switches[e.switch].clone(),
                from: mode_name(e.from),
                to: mode_name(e.to),
            })
            .collect()
    }

    /// Times, states, inputs and those outputs that are none of these, as a table with its header.
    pub fn table(&self, system: &System, scenario: &Scenario) -> (Vec<String>, Vec<Vec<f64>>) {
        let (inputs, outputs) = (input_columns(system, scenario), output_columns(system));
        let mut header = vec!["t".to_owned()];
        header.extend(system.state_names());
        header.extend(inputs.iter().chain(&outputs).map(|(_, name)| name.clone()));
        let values = self.states.iter().zip(self.inputs.iter().zip(&self.outputs));
        let rows = self.times.iter().zip(values).map(|(t, (x, (u, y)))| {
            let driven = inputs.iter().map(|(k, _)| u[*k]);
            let measured = outputs.iter().map(|(k, _)| y[*k]);
            std::iter::once(*t).chain(x.iter().copied()).chain(driven).chain(measured).collect()
        });
        (header, rows.collect())
    }

    /// States, inputs and outputs over time, with the modes of friction.
    ///
    /// # Errors
    /// [`PlotError`] for numbers that no axis holds.
    pub fn figure(&self, system: &System, scenario: &Scenario) -> Result<Drawing, PlotError> {
        let mut chart = friction_colors(TimeSeries::new()).title(system.name.clone());
        let panel = |label: String, k: usize, rows: &[Vec<f64>]| {
            let values: Vec<f64> = rows.iter().map(|r| r[k]).collect();
            Panel::new(label).rounding(ROUNDING).series(Series::new("", self.times.clone(), values))
        };
        // An output that is a state or an input has its name beside that one's, and no panel of its own.
        let inputs = input_columns(system, scenario);
        let drawn = |node: Node| {
            let mut symbols = system.states.iter().chain(inputs.iter().map(|(k, _)| &system.inputs[*k]));
            symbols.any(|s| node == Node::Sym(*s))
        };
        let (renamed, outputs): (Vec<_>, Vec<_>) =
            output_columns(system).into_iter().partition(|(k, _)| drawn(system.pool.node(system.outputs[*k].1)));
        let alias = |symbol| {
            let same = renamed.iter().filter(|(k, _)| system.pool.node(system.outputs[*k].1) == Node::Sym(symbol));
            same.fold(String::new(), |names, (_, name)| format!("{names} = {name}"))
        };
        for (k, name) in system.state_names().into_iter().enumerate() {
            let panel = panel(format!("{name}{}", alias(system.states[k])), k, &self.states);
            chart = chart.panel(friction_bands(panel, &self.trajectory, &self.switches, &name));
        }
        for (k, name) in inputs {
            let label = format!("input {name}{}", alias(system.inputs[k]));
            chart = chart.panel(panel(label, k, &self.inputs));
        }
        if outputs.len() <= MAX_OUTPUT_PANELS {
            for (k, name) in outputs {
                chart = chart.panel(panel(name, k, &self.outputs));
            }
        }
        chart.draw()
    }
}
