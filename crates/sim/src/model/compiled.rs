//! A control system compiled for simulation.

use super::drive::{Driven, Source, drive};
use super::inputs::{Hold, InputError, Inputs, Samples};
use super::switch_expressions::{
    Differentiate, ModelSwitch, derivatives, model_switches, plain_surfaces, surface_gradients,
    with_derivatives_by_signs, without_set_values,
};
use crate::Switched;
use bracketry_symbolic::{Expr, Symbol, Tape};
use bracketry_system::System;

/// Derivatives of the field, compiled.
#[derive(Debug, Clone)]
struct Derivatives {
    /// By states, where asked for, by signs, by live numbers: `n` each. Then those of the switching functions by live numbers.
    tape: Tape,
    /// How many live numbers.
    numbers: usize,
    /// Whether those by states are there.
    by_state: bool,
    /// Whether some of those of the switching functions are not zero.
    surfaces_move: bool,
}

/// A held input that acts later than it is set.
#[derive(Debug, Clone)]
struct Queue {
    slot: usize,
    /// The values that act, from when on.
    table: usize,
    /// What was set last, until the simulation goes on.
    set: Option<f64>,
}

/// A compiled [`System`] with its inputs: a [`Switched`] system.
///
/// Expressions that drive inputs are substituted, with their symbolic derivatives; held values, samples and live numbers
/// are arguments of the compiled functions.
#[derive(Debug, Clone)]
pub struct Model {
    n: usize,
    switches: Vec<ModelSwitch>,
    /// Components of all switches.
    components: usize,
    input_names: Vec<String>,
    /// The slot of each held input.
    held: Vec<Option<usize>>,
    /// The slot of each live number.
    live: Vec<(String, usize)>,
    sources: Vec<Source>,
    tables: Vec<Samples>,
    /// By how much each is shifted, s.
    delays: Vec<f64>,
    /// What was set of delayed held inputs and has not been given its time yet.
    queues: Vec<Queue>,
    /// Whether a time has been entered.
    entered: bool,
    /// Input and order of derivative of each table.
    tabulated: Vec<(String, u32)>,
    /// The current interval of each table.
    intervals: Vec<usize>,
    /// Slots that change within a segment, and their tables.
    moving: Vec<(usize, usize)>,
    /// `t`, states, slots, signs.
    arguments: Vec<f64>,
    field: Tape,
    /// The field and its derivatives by the signs, if it is affine in them.
    affine: Option<Tape>,
    affine_results: Vec<f64>,
    surfaces: Tape,
    gradients: Tape,
    /// Whether the gradients have one value, which stands in `results`.
    constant_gradients: bool,
    inputs: Tape,
    outputs: Tape,
    measures: Tape,
    /// The field's derivatives.
    derivatives: Option<Derivatives>,
    work: Vec<f64>,
    results: Vec<f64>,
    impulses: Vec<(String, u32)>,
}

impl Model {
    /// Compiles a system with its parameters at their values and the given inputs.
    ///
    /// # Errors
    /// [`InputError`] if the inputs do not fit the system or cannot be read.
    ///
    /// ```
    /// use bracketry_sim::{simulate, Inputs, Model, Settings};
    /// use bracketry_system::System;
    /// let text = r#"
    ///     states = ["x", "v"]
    ///     inputs = ["a"]
    ///     parameters = { mu = 0.3, g = 9.81 }
    ///     dynamics = { x = "v", v = "a - mu*g*sign(v)" }
    /// "#;
    /// let system = System::parse("block.toml", text).unwrap();
    /// let model = Model::new(&system, &Inputs::new().expression("a", "6*sin(10*t)")).unwrap();
    /// let run = simulate(model, 0.0, &[0.0, 0.0], 1.0, &Settings::default()).unwrap();
    /// let first = run.trajectory.mode_changes()[0];
    /// assert!((first.t - (0.3f64 * 9.81 / 6.0).asin() / 10.0).abs() < 1e-10);
    /// ```
    pub fn new(system: &System, inputs: &Inputs) -> Result<Self, InputError> {
        Self::compile(system, inputs, 0, None)
    }

    /// As [`Model::new`], with derivatives of the field by the states, the signs and some of the live numbers, for
    /// [`Model::tangent`].
    ///
    /// # Errors
    /// As [`Model::new`], and [`InputError::UnknownLive`].
    pub fn differentiable(system: &System, inputs: &Inputs, by: &[String]) -> Result<Self, InputError> {
        Self::compile(system, inputs, 0, Some(Differentiate { by_state: true, by }))
    }

    /// As [`Model::new`], with derivatives of the field by some of the live numbers alone, for [`Model::along`].
    ///
    /// # Errors
    /// As [`Model::differentiable`].
    pub fn with_influences(system: &System, inputs: &Inputs, by: &[String]) -> Result<Self, InputError> {
        Self::compile(system, inputs, 0, Some(Differentiate { by_state: false, by }))
    }

    /// As [`Model::new`]; the last `measures` outputs of the system become measures instead, which see the set-valued parts
    /// of the equations at their actual values.
    pub(crate) fn with_measures(system: &System, inputs: &Inputs, measures: usize) -> Result<Self, InputError> {
        Self::compile(system, inputs, measures, None)
    }

    fn compile(
        system: &System,
        inputs: &Inputs,
        measures: usize,
        differentiate: Option<Differentiate<'_>>,
    ) -> Result<Self, InputError> {
        let input_names = system.input_names();
        let mut driven = drive(system, inputs)?;
        let form = driven.system.set_valued_form();
        let n = driven.system.states.len();
        let last = driven.outputs.len() - input_names.len();
        let measures: Vec<Expr> = driven.outputs.drain(last - measures..last).collect();
        let actual: Vec<Symbol> = form.switches.iter().map(|s| s.sign).collect();
        let measures = without_set_values(&mut driven.system, &measures, &actual);
        driven.outputs = without_set_values(&mut driven.system, &driven.outputs, &[]);
        let surfaces = plain_surfaces(&mut driven.system, &form.switches)?;
        let gradients = surface_gradients(&mut driven, &form.switches)?;
        let affine = with_derivatives_by_signs(&mut driven.system, &form.switches, &form.dynamics);
        let derivatives = match differentiate {
            Some(wanted) => derivatives(&mut driven, &form, wanted)?,
            None => None,
        };

        let mut smooth_arguments = vec![driven.time];
        smooth_arguments.extend(&driven.system.states);
        smooth_arguments.extend(&driven.slots);
        let mut arguments = smooth_arguments.clone();
        arguments.extend(form.switches.iter().map(|s| s.sign));

        let model_switches = model_switches(&mut driven, &form)?;
        let Driven { mut system, values, outputs, .. } = driven;
        let zero = system.pool.int(0);
        let mut compile = |arguments: &[Symbol], expressions: &[Expr]| {
            let expressions = system.pool.substitute_all(expressions, &values);
            Tape::compile(&system.pool, arguments, &expressions)
        };
        let field = compile(&arguments, &form.dynamics)?;
        let affine = affine.map(|expressions| compile(&arguments, &expressions)).transpose()?;
        let surfaces = compile(&smooth_arguments, &surfaces)?;
        let gradients = compile(&smooth_arguments, &gradients)?;
        let (measured, driving) = outputs.split_at(outputs.len() - input_names.len());
        let inputs_tape = compile(&smooth_arguments, driving)?;
        let outputs_tape = compile(&smooth_arguments, measured)?;
        let measures = compile(&arguments, &measures)?;
        let derivatives = match (derivatives, differentiate) {
            (Some(all), Some(Differentiate { by_state, by })) => {
                let surfaces_move = all[all.len() - form.switches.len() * by.len()..].iter().any(|e| *e != zero);
                Some(Derivatives { tape: compile(&arguments, &all)?, numbers: by.len(), by_state, surfaces_move })
            }
            _ => None,
        };
        let mut model = Self {
            n,
            input_names,
            delays: driven.delays,
            queues: driven.queues.iter().map(|&(slot, table)| Queue { slot, table, set: None }).collect(),
            entered: false,
            held: driven.held,
            live: driven.live,
            intervals: vec![0; driven.tables.len()],
            moving: moving(&driven.sources, &driven.tables),
            arguments: vec![0.0; arguments.len()],
            results: vec![0.0; gradients.n_outputs()],
            constant_gradients: gradients.code().is_empty()
                && gradients.outputs().iter().all(|&r| r as usize >= gradients.n_inputs()),
            affine_results: vec![0.0; affine.as_ref().map_or(0, Tape::n_outputs)],
            impulses: driven.impulses,
            sources: driven.sources,
            tables: driven.tables,
            tabulated: driven.tabulated,
            components: form.switches.len(),
            switches: model_switches,
            field,
            affine,
            surfaces,
            gradients,
            inputs: inputs_tape,
            outputs: outputs_tape,
            measures,
            derivatives,
            work: Vec::new(),
        };
        model.load(0.0);
        if model.constant_gradients {
            let last = model.arguments.len() - model.components;
            model.gradients.eval(&model.arguments[..last], &mut model.work, &mut model.results);
        }
        Ok(model)
    }

    /// Names of the switches: switching functions as printed expressions, of unit vectors all components (`vx, vy`).
    pub fn switch_names(&self) -> impl Iterator<Item = &str> {
        self.switches.iter().map(|s| s.name.as_str())
    }

    /// Input derivatives that the model uses, by input and order, whose impulses are left out because the input jumps or
    /// has kinks (`sign`, `abs`, `min`, `max` in its expression).
    pub fn impulses_left_out(&self) -> &[(String, u32)] {
        &self.impulses
    }

    /// Names of the inputs, in order.
    pub fn input_names(&self) -> &[String] {
        &self.input_names
    }

    /// Sets all held inputs: one value per input of the model; those of driven inputs are ignored. Where an input has a
    /// delay, the value acts that much later than the time at which the simulation goes on; one that is set before it begins
    /// has been there for ever.
    ///
    /// # Errors
    /// [`InputError::WrongLength`].
    pub fn set_inputs(&mut self, u: &[f64]) -> Result<(), InputError> {
        if u.len() != self.held.len() {
            return Err(InputError::WrongLength { expected: self.held.len(), found: u.len() });
        }
        for (slot, value) in self.held.clone().iter().zip(u) {
            self.set_slot(*slot, *value);
        }
        Ok(())
    }

    /// Sets one held input, as [`Model::set_inputs`]; false if there is none of that name.
    pub fn set_input(&mut self, name: &str, value: f64) -> bool {
        let slot = self.input_names.iter().position(|n| n == name).and_then(|i| self.held[i]);
        self.set_slot(slot, value)
    }

    /// Sets a live number; false if there is none of that name.
    pub fn set_live(&mut self, name: &str, value: f64) -> bool {
        let slot = self.live.iter().find(|(n, _)| n == name).map(|(_, slot)| *slot);
        self.set_slot(slot, value)
    }

    /// Replaces the samples of an input (`order` 0) or of one of its derivatives, as for the next stretch of a measured run;
    /// false if no samples with the same hold drive it.
    ///
    /// ```
    /// use bracketry_sim::{Hold, Inputs, Model, Samples};
    /// use bracketry_system::System;
    /// let system = System::parse("mass.toml", "states = ['v']\ninputs = ['u']\n[dynamics]\nv = 'u'").unwrap();
    /// let constant = |u| Samples::new(vec![0.0], vec![u], Hold::Previous).unwrap();
    /// let mut model = Model::new(&system, &Inputs::new().samples("u", constant(1.0))).unwrap();
    /// assert!(model.set_samples("u", 0, constant(2.0)));
    /// assert_eq!(model.input_values(0.0), [2.0]);
    /// ```
    pub fn set_samples(&mut self, input: &str, order: u32, samples: Samples) -> bool {
        let table = self.tabulated.iter().position(|(name, o)| name == input && *o == order);
        let delay = table.map_or(0.0, |i| self.delays[i]);
        match table.map(|i| &mut self.tables[i]) {
            Some(table) if table.hold == samples.hold => {
                *table = samples.delayed(delay);
                true
            }
            _ => false,
        }
    }

    /// By how much the samples of an input act later than they are given, s; 0 for an input that none drive.
    pub fn samples_delay(&self, input: &str) -> f64 {
        self.tabulated.iter().position(|(name, _)| name == input).map_or(0.0, |table| self.delays[table])
    }

    fn set_slot(&mut self, slot: Option<usize>, value: f64) -> bool {
        let Some(slot) = slot else {
            return false;
        };
        match self.queues.iter_mut().find(|q| q.slot == slot) {
            Some(queue) => queue.set = Some(value),
            None => self.sources[slot] = Source::Held(value),
        }
        true
    }

    /// The inputs at `t` after their delays, as they drive the model in the segment that begins at or before `t`.
    pub fn input_values(&mut self, t: f64) -> Vec<f64> {
        self.enter_segment(t);
        let mut values = vec![0.0; self.inputs.n_outputs()];
        self.point(t, None);
        let last = self.arguments.len() - self.components;
        self.inputs.eval(&self.arguments[..last], &mut self.work, &mut values);
        values
    }

    /// The outputs at `t` in state `x`, with `sign(0) = 0` and unit vectors 0 where they have no direction.
    pub fn output_values(&mut self, t: f64, x: &[f64]) -> Vec<f64> {
        self.enter_segment(t);
        let mut values = vec![0.0; self.outputs.n_outputs()];
        self.point(t, Some(x));
        let last = self.arguments.len() - self.components;
        self.outputs.eval(&self.arguments[..last], &mut self.work, &mut values);
        values
    }

    /// Writes the measures at `t` in state `x` for signs and directions `s`.
    pub(crate) fn measure(&mut self, t: f64, x: &[f64], s: &[f64], values: &mut [f64]) {
        self.point(t, Some(x));
        let first = self.arguments.len() - self.components;
        self.arguments[first..].copy_from_slice(s);
        self.measures.eval(&self.arguments, &mut self.work, values);
    }

    /// By how many live numbers the field is differentiated, and whether by states before.
    pub(crate) fn differentiated(&self) -> Option<(usize, bool)> {
        self.derivatives.as_ref().map(|d| (d.numbers, d.by_state))
    }

    /// Whether live numbers by which the field is differentiated move switching functions.
    pub(crate) fn surfaces_move(&self) -> bool {
        self.derivatives.as_ref().is_some_and(|d| d.surfaces_move)
    }

    /// Writes `∂f/∂x` where asked for, `∂f/∂s`, the field's derivatives by live numbers, and those of σ, each by columns.
    pub(crate) fn derivatives(&mut self, t: f64, x: &[f64], s: &[f64], values: &mut [f64]) {
        self.point(t, Some(x));
        let first = self.arguments.len() - self.components;
        self.arguments[first..].copy_from_slice(s);
        if let Some(Derivatives { tape, .. }) = &self.derivatives {
            tape.eval(&self.arguments, &mut self.work, values);
        }
    }

    /// Writes the field with samples at their means over a span of time: the model's own, or those of another that is driven alike.
    pub(crate) fn mean_field(
        &mut self,
        (from, to): (f64, f64),
        (x, s): (&[f64], &[f64]),
        samples_of: Option<&Model>,
        dx: &mut [f64],
    ) {
        let t = 0.5 * (from + to);
        self.enter_segment(t);
        self.point(t, Some(x));
        let tables = samples_of.map_or(&self.tables, |other| &other.tables);
        for (slot, source) in self.sources.iter().enumerate() {
            let value = match source {
                Source::Held(_) => continue,
                Source::Value(table) => tables[*table].means(from, to).0,
                Source::Slope(table) => tables[*table].means(from, to).1,
            };
            self.arguments[1 + self.n + slot] = value;
        }
        let first = self.arguments.len() - self.components;
        self.arguments[first..].copy_from_slice(s);
        self.field.eval(&self.arguments, &mut self.work, dx);
    }

    /// Whether samples drive another model alike.
    pub(crate) fn driven_like(&self, other: &Model) -> bool {
        self.n == other.n && self.tabulated == other.tabulated && self.components == other.components
    }

    /// Writes time and state into the arguments, and slots that move with time.
    fn point(&mut self, t: f64, x: Option<&[f64]>) {
        self.arguments[0] = t;
        if let Some(x) = x {
            self.arguments[1..=self.n].copy_from_slice(x);
        }
        for &(slot, table) in &self.moving {
            self.arguments[1 + self.n + slot] = self.tables[table].value(self.intervals[table], t);
        }
    }

    /// Writes the slots.
    fn load(&mut self, t: f64) {
        let first = 1 + self.n;
        for (slot, source) in self.sources.iter().enumerate() {
            self.arguments[first + slot] = match source {
                Source::Held(value) => *value,
                Source::Value(table) => self.tables[*table].value(self.intervals[*table], t),
                Source::Slope(table) => self.tables[*table].slope(self.intervals[*table]),
            };
        }
    }
}

impl Switched for Model {
    fn dim(&self) -> usize {
        self.n
    }

    fn switches(&self) -> usize {
        self.switches.len()
    }

    fn sticks(&self, switch: usize) -> bool {
        self.switches[switch].sticks
    }

    fn components(&self, switch: usize) -> usize {
        self.switches[switch].components
    }

    fn static_ratio(&self, switch: usize) -> f64 {
        self.switches[switch].static_ratio
    }

    fn rhs(&mut self, t: f64, x: &[f64], s: &[f64], dx: &mut [f64]) {
        self.point(t, Some(x));
        let first = self.arguments.len() - self.components;
        self.arguments[first..].copy_from_slice(s);
        self.field.eval(&self.arguments, &mut self.work, dx);
    }

    fn affine(&mut self, t: f64, x: &[f64], s: &[f64], dx: &mut [f64], by_sign: &mut [f64]) -> bool {
        self.point(t, Some(x));
        let first = self.arguments.len() - self.components;
        self.arguments[first..].copy_from_slice(s);
        let Some(affine) = &self.affine else {
            return false;
        };
        affine.eval(&self.arguments, &mut self.work, &mut self.affine_results);
        let (field, derivatives) = self.affine_results.split_at(self.n);
        dx.copy_from_slice(field);
        by_sign.copy_from_slice(derivatives);
        true
    }

    fn switching(&mut self, t: f64, x: &[f64], sigma: &mut [f64]) {
        self.point(t, Some(x));
        let last = self.arguments.len() - self.components;
        self.surfaces.eval(&self.arguments[..last], &mut self.work, sigma);
    }

    fn switching_gradient(&mut self, t: f64, x: &[f64], gradient: &mut [f64], partial_t: &mut [f64]) {
        if !self.constant_gradients {
            self.point(t, Some(x));
            let last = self.arguments.len() - self.components;
            self.gradients.eval(&self.arguments[..last], &mut self.work, &mut self.results);
        }
        let (by_state, by_time) = self.results.split_at(gradient.len());
        gradient.copy_from_slice(by_state);
        partial_t.copy_from_slice(by_time);
    }

    fn enter_segment(&mut self, t: f64) -> f64 {
        for queue in &mut self.queues {
            if let Some(value) = queue.set.take() {
                let from = if self.entered { t + self.delays[queue.table] } else { f64::NEG_INFINITY };
                self.tables[queue.table].go_on(t, from, value);
            }
        }
        self.entered = true;
        let mut end = f64::INFINITY;
        for (interval, table) in self.intervals.iter_mut().zip(&self.tables) {
            *interval = table.interval(t);
            if let Some(next) = table.times.get(*interval) {
                end = end.min(*next);
            }
        }
        self.load(t);
        end
    }
}

/// Slots whose value follows straight lines, and their tables.
fn moving(sources: &[Source], tables: &[Samples]) -> Vec<(usize, usize)> {
    let of = |(slot, source): (usize, &Source)| match source {
        Source::Value(table) if tables[*table].hold == Hold::Linear => Some((slot, *table)),
        _ => None,
    };
    sources.iter().enumerate().filter_map(of).collect()
}
