//! A control system compiled for simulation.

use super::drive::drive;
use super::driving::Driving;
use super::inputs::{InputError, Inputs, Samples};
use super::switch_expressions::{Differentiate, ModelSwitch};
use super::tapes::{Derivatives, Tapes};
use crate::Switched;
use bracketry_symbolic::Tape;
use bracketry_system::System;
use std::sync::Arc;

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
    driving: Driving,
    /// `t`, states, slots, signs.
    arguments: Vec<f64>,
    /// Shared by clones.
    tapes: Arc<Tapes>,
    affine_results: Vec<f64>,
    jacobian_results: Vec<f64>,
    /// The gradients of the switching functions; where they have one value, it stands here.
    gradients: Vec<f64>,
    constant_gradients: bool,
    work: Vec<f64>,
    impulses: Vec<(String, u32)>,
}

impl Model {
    /// Compiles a system with its parameters at their values and the given inputs.
    ///
    /// # Errors
    /// [`InputError`] if the inputs do not fit the system or cannot be read.
    ///
    /// ```
    /// use bracketry_sim::{simulate, Inputs, Model, SimulationSettings};
    /// use bracketry_system::System;
    /// let text = r#"
    ///     states = ["x", "v"]
    ///     inputs = ["a"]
    ///     parameters = { mu = 0.3, g = 9.81 }
    ///     dynamics = { x = "v", v = "a - mu*g*sign(v)" }
    /// "#;
    /// let system = System::parse("block.toml", text).unwrap();
    /// let model = Model::new(&system, &Inputs::new().expression("a", "6*sin(10*t)")).unwrap();
    /// let run = simulate(model, 0.0, &[0.0, 0.0], 1.0, &SimulationSettings::default()).unwrap();
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
        if system.period.is_some() {
            return Err(InputError::DiscreteTime);
        }
        let mut driven = drive(system, inputs)?;
        let form = driven.system.set_valued_form();
        let (tapes, switches) = Tapes::compile(&mut driven, &form, measures, differentiate)?;
        let mut model = Self {
            n: driven.system.states.len(),
            switches,
            components: form.switches.len(),
            input_names: system.input_names(),
            driving: driven.driving,
            arguments: vec![0.0; tapes.field.n_inputs()],
            affine_results: vec![0.0; tapes.affine.as_ref().map_or(0, Tape::n_outputs)],
            gradients: vec![0.0; tapes.gradients.n_outputs()],
            constant_gradients: tapes.gradients.code().is_empty()
                && tapes.gradients.outputs().iter().all(|&r| r as usize >= tapes.gradients.n_inputs()),
            jacobian_results: Vec::new(),
            tapes: Arc::new(tapes),
            work: Vec::new(),
            impulses: driven.impulses,
        };
        model.load(0.0);
        if model.constant_gradients {
            let last = model.arguments.len() - model.components;
            model.tapes.gradients.eval(&model.arguments[..last], &mut model.work, &mut model.gradients);
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
    /// delay, the value acts that much later than the time at which the simulation goes on; one that is set before it starts
    /// has been there for ever.
    ///
    /// # Errors
    /// [`InputError::WrongLength`].
    pub fn set_inputs(&mut self, u: &[f64]) -> Result<(), InputError> {
        self.driving.set_inputs(u)
    }

    /// Sets the values at which inputs with a delay were held before the start, 0 unless they are set: one value per input. To be
    /// called before the simulation starts.
    ///
    /// # Errors
    /// [`InputError::WrongLength`].
    pub fn set_past_inputs(&mut self, u: &[f64]) -> Result<(), InputError> {
        self.driving.set_past_inputs(u)
    }

    /// Sets one held input, as [`Model::set_inputs`]; false if there is none of that name.
    pub fn set_input(&mut self, name: &str, value: f64) -> bool {
        let input = self.input_names.iter().position(|n| n == name);
        input.is_some_and(|input| self.driving.set_input(input, value))
    }

    /// Sets a live number; false if there is none of that name.
    pub fn set_live(&mut self, name: &str, value: f64) -> bool {
        self.driving.set_live(name, value)
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
        self.driving.set_samples(input, order, samples)
    }

    /// By how much the samples of an input act later than they are given, s; 0 for an input that none drive.
    pub fn samples_delay(&self, input: &str) -> f64 {
        self.driving.samples_delay(input)
    }

    /// The inputs at `t` after their delays, as they drive the model in the segment that starts at or before `t`.
    pub fn input_values(&mut self, t: f64) -> Vec<f64> {
        self.enter_segment(t);
        self.point(t, None);
        let mut values = vec![0.0; self.tapes.inputs.n_outputs()];
        let last = self.arguments.len() - self.components;
        self.tapes.inputs.eval(&self.arguments[..last], &mut self.work, &mut values);
        values
    }

    /// The outputs at `t` in state `x`, with `sign(0) = 0` and unit vectors 0 where they have no direction.
    pub fn output_values(&mut self, t: f64, x: &[f64]) -> Vec<f64> {
        self.enter_segment(t);
        self.point(t, Some(x));
        let mut values = vec![0.0; self.tapes.outputs.n_outputs()];
        let last = self.arguments.len() - self.components;
        self.tapes.outputs.eval(&self.arguments[..last], &mut self.work, &mut values);
        values
    }

    /// Writes the measures at `t` in state `x` for signs and directions `s`.
    pub(crate) fn measure(&mut self, t: f64, x: &[f64], s: &[f64], values: &mut [f64]) {
        self.point_with_signs(t, x, s);
        self.tapes.measures.eval(&self.arguments, &mut self.work, values);
    }

    /// By how many live numbers the field is differentiated, and whether by states before.
    pub(crate) fn differentiated(&self) -> Option<(usize, bool)> {
        self.tapes.derivatives.as_ref().map(|d| (d.numbers, d.by_state))
    }

    /// Whether live numbers by which the field is differentiated move switching functions.
    pub(crate) fn surfaces_move(&self) -> bool {
        self.tapes.derivatives.as_ref().is_some_and(|d| d.surfaces_move)
    }

    /// Writes `∂f/∂x` where asked for, `∂f/∂s`, the field's derivatives by live numbers, and those of σ, each by columns.
    pub(crate) fn derivatives(&mut self, t: f64, x: &[f64], s: &[f64], values: &mut [f64]) {
        self.point_with_signs(t, x, s);
        if let Some(Derivatives { tape, .. }) = &self.tapes.derivatives {
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
        self.point_with_signs(t, x, s);
        let samples_of = samples_of.map_or(&self.driving, |other| &other.driving);
        self.driving.load_means(samples_of, from, to, &mut self.arguments[1 + self.n..]);
        self.tapes.field.eval(&self.arguments, &mut self.work, dx);
    }

    /// Whether samples drive another model alike.
    pub(crate) fn driven_like(&self, other: &Model) -> bool {
        self.n == other.n && self.driving.is_like(&other.driving) && self.components == other.components
    }

    /// Writes time and state into the arguments, and slots that move with time.
    fn point(&mut self, t: f64, x: Option<&[f64]>) {
        self.arguments[0] = t;
        if let Some(x) = x {
            self.arguments[1..=self.n].copy_from_slice(x);
        }
        self.driving.follow(t, &mut self.arguments[1 + self.n..]);
    }

    /// As [`Model::point`], and the signs.
    fn point_with_signs(&mut self, t: f64, x: &[f64], s: &[f64]) {
        self.point(t, Some(x));
        let first = self.arguments.len() - self.components;
        self.arguments[first..].copy_from_slice(s);
    }

    /// Writes the slots.
    fn load(&mut self, t: f64) {
        self.driving.load(t, &mut self.arguments[1 + self.n..]);
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
        self.point_with_signs(t, x, s);
        self.tapes.field.eval(&self.arguments, &mut self.work, dx);
    }

    fn affine(&mut self, t: f64, x: &[f64], s: &[f64], dx: &mut [f64], by_sign: &mut [f64]) -> bool {
        self.point_with_signs(t, x, s);
        let Some(affine) = &self.tapes.affine else {
            return false;
        };
        affine.eval(&self.arguments, &mut self.work, &mut self.affine_results);
        let (field, derivatives) = self.affine_results.split_at(self.n);
        dx.copy_from_slice(field);
        by_sign.copy_from_slice(derivatives);
        true
    }

    fn jacobian(&mut self, t: f64, x: &[f64], s: &[f64], jacobian: &mut [f64]) -> bool {
        self.point_with_signs(t, x, s);
        let Some(derivatives) = self.tapes.jacobian.get() else {
            return false;
        };
        self.jacobian_results.resize(derivatives.entries.len(), 0.0);
        derivatives.tape.eval(&self.arguments, &mut self.work, &mut self.jacobian_results);
        for (&(i, j), v) in derivatives.entries.iter().zip(&self.jacobian_results) {
            jacobian[i * self.n + j] = *v;
        }
        true
    }

    fn switching(&mut self, t: f64, x: &[f64], sigma: &mut [f64]) {
        self.point(t, Some(x));
        let last = self.arguments.len() - self.components;
        self.tapes.surfaces.eval(&self.arguments[..last], &mut self.work, sigma);
    }

    fn switching_gradient(&mut self, t: f64, x: &[f64], gradient: &mut [f64], partial_t: &mut [f64]) {
        if !self.constant_gradients {
            self.point(t, Some(x));
            let last = self.arguments.len() - self.components;
            self.tapes.gradients.eval(&self.arguments[..last], &mut self.work, &mut self.gradients);
        }
        let (by_state, by_time) = self.gradients.split_at(gradient.len());
        gradient.copy_from_slice(by_state);
        partial_t.copy_from_slice(by_time);
    }

    fn enter_segment(&mut self, t: f64) -> f64 {
        let end = self.driving.enter(t);
        self.load(t);
        end
    }
}
