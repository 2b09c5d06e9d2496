//! The model with its parameters and disturbances as states and its process noise as inputs.

use super::problem::{DisturbanceChannel, EstimationProblem};
use crate::dynamics::{Dynamics, SymbolicDynamics};
use crate::error::MpcError;
use crate::integrator::Interval;
use crate::ocp::Substeps;
use crate::transcription::{STABLE_STEP, Shooter};
use bracketry_native::{Function, Workspace};
use bracketry_symbolic::{Expr, Names, Pool, Rational, Symbol, Tape};
use bracketry_system::{Parameter, SwitchKind, SwitchedForm, System};
use nalgebra::{DMatrix, DVector};

/// Size of a smoothed sign below which friction is taken to stick.
const STUCK: f64 = 0.95;

/// One interval: its end and the derivatives of the end with respect to the start and to the standardized noise.
#[derive(Clone, Debug)]
pub(crate) struct LinearizedInterval {
    pub(crate) end: DVector<f64>,
    /// ∂F/∂x.
    pub(crate) f: DMatrix<f64>,
    /// ∂F/∂w for noise of unit variance: G Gᵀ is the covariance that the interval adds.
    pub(crate) g: DMatrix<f64>,
    /// Which states (parameters and disturbances) cannot be seen because the friction that they act against sticks.
    pub(crate) hidden: Vec<bool>,
}

impl LinearizedInterval {
    /// Room for an interval of a model.
    pub(crate) fn of(model: &Augmented) -> Self {
        let (n, k) = (model.size(), model.noise.len());
        Self { end: DVector::zeros(n), f: DMatrix::zeros(n, n), g: DMatrix::zeros(n, k), hidden: vec![false; n] }
    }
}

/// A friction force: its smoothed signs, and the rows of the dynamics that it holds while it sticks.
struct Friction {
    signs: std::ops::Range<usize>,
    holds: Vec<bool>,
}

/// Augmented state z = (x, p, d), known inputs u, standardized noise w.
pub(crate) struct Augmented {
    /// Number of model states.
    pub(crate) states: usize,
    pub(crate) parameters: usize,
    /// Number of known inputs.
    pub(crate) inputs: usize,
    /// State that every noise input drives, with the standard deviation of its value over an interval.
    pub(crate) noise: Vec<(usize, f64)>,
    pub(crate) start: DVector<f64>,
    pub(crate) start_std: DVector<f64>,
    pub(crate) bounds: Vec<(f64, f64)>,
    /// Variance and period of every output.
    pub(crate) sensors: Vec<(f64, Option<f64>)>,
    dt: f64,
    width: f64,
    substeps: Substeps,
    implicit: bool,
    dynamics: SymbolicDynamics,
    shooter: Shooter,
    outputs: Function,
    signs: Function,
    friction: Vec<Friction>,
    /// Rows of the dynamics that parameter or disturbance j acts on.
    acts_on: Vec<Vec<bool>>,
    work: Workspace,
    arguments: Vec<f64>,
    jacobian: Vec<f64>,
    inputs_and_noise: Vec<f64>,
    values: Vec<f64>,
    time_and_states: Vec<f64>,
    sign_values: Vec<f64>,
    /// Which friction sticks at both ends of an interval.
    stuck: Vec<bool>,
    /// Rows of the dynamics that it holds.
    held: Vec<bool>,
    /// The end of an interval at half the width of smoothing.
    half: Vec<f64>,
}

/// The names of an output expression.
struct OutputNames<'a> {
    system: &'a System,
}

impl Names for OutputNames<'_> {
    fn lookup(&mut self, pool: &mut Pool, name: &str) -> Option<Expr> {
        if let Some(p) = self.system.parameters.iter().find(|p| self.system.symbol_name(p.symbol) == name) {
            return Some(pool.rational(p.value.clone()));
        }
        if name == "t" || self.system.state_index(name).is_some() {
            return Some(pool.var(name));
        }
        self.system.outputs.iter().find(|(n, _)| n == name).map(|(_, e)| *e)
    }
    fn known(&self) -> Vec<String> {
        let mut names = self.system.state_names();
        names.extend(self.system.parameter_names());
        names.extend(self.system.outputs.iter().map(|(n, _)| n.clone()));
        names.push("t".into());
        names
    }
}

/// The augmented equations without process noise, and what is known of their states beforehand.
struct Equations {
    system: System,
    outputs: Vec<Expr>,
    start: Vec<f64>,
    start_std: Vec<f64>,
    walks: Vec<f64>,
}

impl Equations {
    fn of(problem: &EstimationProblem) -> Result<Self, MpcError> {
        problem.check()?;
        let mut system = problem.system.clone();
        // A coefficient that becomes a state may have any sign there; friction stays friction.
        system.mark_dry_friction();
        let mut start = problem.initial.clone();
        let mut start_std = problem.initial_std.clone();
        let mut walks = problem.process_noise.clone();
        for p in &problem.parameters {
            let Some(at) = system.parameters.iter().position(|q| system.pool.name(q.symbol) == p.name) else {
                let known = system.parameters.iter().map(|q| system.pool.name(q.symbol).to_owned()).collect();
                return Err(MpcError::NoSuchName { what: "parameter", name: p.name.clone(), known });
            };
            let parameter = system.parameters.remove(at);
            system.states.push(parameter.symbol);
            start.push(parameter.value.to_f64().value());
            start_std.push(p.std);
            walks.push(p.walk);
        }
        let mut output_disturbances = Vec::new();
        for (j, d) in problem.disturbances.iter().enumerate() {
            let symbol = system.pool.symbol(&format!("disturbance#{j}"));
            let value = system.pool.sym(symbol);
            match &d.channel {
                DisturbanceChannel::Input(name) => {
                    let Some(i) = system.input_index(name) else {
                        let known = system.input_names();
                        return Err(MpcError::NoSuchName { what: "input", name: name.clone(), known });
                    };
                    let u = system.pool.sym(system.inputs[i]);
                    let disturbed = system.pool.add(u, value);
                    let map = [(u, disturbed)].into_iter().collect();
                    system.dynamics = system.pool.substitute_all(&system.dynamics, &map);
                }
                DisturbanceChannel::State(name) => {
                    let Some(i) = problem.system.state_index(name) else {
                        let known = problem.system.state_names();
                        return Err(MpcError::NoSuchName { what: "state", name: name.clone(), known });
                    };
                    system.dynamics[i] = system.pool.add(system.dynamics[i], value);
                }
                DisturbanceChannel::Output(index) => {
                    if *index >= problem.outputs.len() {
                        let (found, expected) = (problem.outputs.len(), index + 1);
                        return Err(MpcError::Length { what: "the list of measured outputs", found, expected });
                    }
                    output_disturbances.push((*index, value));
                }
            }
            system.states.push(symbol);
            start.push(0.0);
            start_std.push(d.std);
            walks.push(d.walk);
        }
        let zero = system.pool.int(0);
        system.dynamics.resize(system.states.len(), zero);

        let mut expressions = Vec::new();
        for o in &problem.outputs {
            let mut pool = std::mem::take(&mut system.pool);
            let parsed = {
                system.pool = pool.clone();
                pool.parse_with(&o.expression, &mut OutputNames { system: &system })
            };
            system.pool = pool;
            expressions.push(parsed?);
        }
        for (index, d) in output_disturbances {
            expressions[index] = system.pool.add(expressions[index], d);
        }
        Ok(Self { system, outputs: expressions, start, start_std, walks })
    }
}

impl EstimationProblem {
    /// The controller's model, with the estimated parameters and then the disturbances as its last parameters.
    pub(crate) fn controller_model(&self) -> Result<System, MpcError> {
        Ok(Augmented::disturbed(self)?.0)
    }

    /// The model for a controller, with the estimated parameters and then the disturbances as live parameters:
    /// [`Controller::set_parameters`](crate::Controller::set_parameters) gives it the estimates.
    ///
    /// # Errors
    /// If the problem contradicts itself or names something that the model does not have.
    pub fn controller_dynamics(&self) -> Result<SymbolicDynamics, MpcError> {
        let system = self.controller_model()?;
        let names = self.live_parameters();
        SymbolicDynamics::with_live_parameters(&system, &names.iter().map(String::as_str).collect::<Vec<_>>())
    }
}

impl Augmented {
    /// The augmented equations without process noise, and the measured outputs.
    pub(crate) fn symbolic(problem: &EstimationProblem) -> Result<(System, Vec<Expr>), MpcError> {
        let equations = Equations::of(problem)?;
        Ok((equations.system, equations.outputs))
    }

    /// The equations with estimated parameters and disturbances as parameters, in the order of
    /// [`EstimationProblem::live_parameters`], and the measured outputs.
    pub(crate) fn disturbed(problem: &EstimationProblem) -> Result<(System, Vec<Expr>), MpcError> {
        let (mut system, outputs) = Self::symbolic(problem)?;
        let n = problem.system.states.len();
        for symbol in system.states.split_off(n) {
            let known = problem.system.parameters.iter().find(|p| p.symbol == symbol).cloned();
            let (min, max, unit, about) = (None, None, None, None);
            system.parameters.push(known.unwrap_or(Parameter { symbol, value: Rational::ZERO, min, max, unit, about }));
        }
        system.dynamics.truncate(n);
        Ok((system, outputs))
    }

    pub(crate) fn new(problem: &EstimationProblem) -> Result<Self, MpcError> {
        let Equations { mut system, outputs: expressions, start, start_std, walks } = Equations::of(problem)?;
        let (states, inputs) = (problem.system.states.len(), problem.system.inputs.len());
        let form = system.set_valued_form();
        let (friction, acts_on) = hiding(&mut system, &form, states);
        let signs = sign_function(&mut system, &form)?;

        let mut noise = Vec::new();
        for (i, &walk) in walks.iter().enumerate() {
            if walk > 0.0 {
                let w = system.pool.symbol(&format!("noise#{i}"));
                let value = system.pool.sym(w);
                system.dynamics[i] = system.pool.add(system.dynamics[i], value);
                system.inputs.push(w);
                noise.push((i, walk / problem.dt.sqrt()));
            }
        }
        let mut dynamics = SymbolicDynamics::new(&system)?;
        dynamics.set_smoothing(problem.smoothing);
        let time = system.pool.symbol("t");
        let time_and_states: Vec<Symbol> = std::iter::once(time).chain(system.states.iter().copied()).collect();
        let mut all = expressions.clone();
        all.extend(system.pool.jacobian(&expressions, &system.states.clone()).into_iter().flatten());
        let outputs = Function::new(system.compile(&time_and_states, &all)?);
        let n = system.states.len();
        let mut arguments = vec![0.0; signs.n_inputs()];
        if let Some(last) = arguments.last_mut() {
            *last = problem.smoothing;
        }
        Ok(Self {
            states,
            parameters: problem.parameters.len(),
            inputs,
            start: DVector::from_vec(start),
            start_std: DVector::from_vec(start_std),
            bounds: problem.all_bounds(),
            sensors: problem.outputs.iter().map(|o| (o.std * o.std, o.period)).collect(),
            dt: problem.dt,
            substeps: problem.substeps,
            implicit: problem.integrator.is_implicit(),
            shooter: Shooter::new(&dynamics, problem.integrator),
            dynamics,
            values: vec![0.0; outputs.n_outputs()],
            time_and_states: vec![0.0; 1 + n],
            outputs,
            sign_values: vec![0.0; signs.n_outputs()],
            arguments,
            width: problem.smoothing,
            stuck: vec![false; friction.len()],
            held: vec![false; n],
            half: vec![0.0; n],
            signs,
            friction,
            acts_on,
            work: Workspace::default(),
            jacobian: vec![0.0; n * (n + inputs + noise.len())],
            inputs_and_noise: vec![0.0; inputs + noise.len()],
            noise,
        })
    }

    /// Number of augmented states.
    pub(crate) fn size(&self) -> usize {
        self.start.len()
    }

    /// Which entries of row i of ∂F/∂z can differ from zero.
    pub(crate) fn flow_pattern(&self, i: usize) -> Vec<bool> {
        let width = self.size() + self.inputs + self.noise.len();
        self.shooter.closure()[i * width..i * width + self.size()].to_vec()
    }

    /// Which friction sticks at this state.
    pub(crate) fn stuck(&mut self, t: f64, z: &[f64], u: &[f64]) -> &[bool] {
        self.stuck.fill(true);
        self.keep_stuck(t, z, u);
        &self.stuck
    }

    /// Keeps of the friction that sticks what sticks at this state too.
    fn keep_stuck(&mut self, t: f64, z: &[f64], u: &[f64]) {
        if self.friction.is_empty() {
            return;
        }
        let n = self.size();
        self.arguments[0] = t;
        self.arguments[1..=n].copy_from_slice(z);
        self.arguments[1 + n..1 + n + self.inputs].copy_from_slice(u);
        self.signs.call(&self.arguments, &mut self.work, &mut self.sign_values);
        let size = |f: &Friction| self.sign_values[f.signs.clone()].iter().map(|s| s * s).sum::<f64>().sqrt();
        self.stuck.iter_mut().zip(&self.friction).for_each(|(stuck, f)| *stuck &= size(f) < STUCK);
    }

    /// Which parameters and disturbances cannot be seen because of the friction that sticks: those that act on nothing but
    /// what it holds.
    fn hide(&mut self, hidden: &mut [bool]) {
        let held = &mut self.held;
        held.fill(false);
        for (f, _) in self.friction.iter().zip(&self.stuck).filter(|(_, stuck)| **stuck) {
            held.iter_mut().zip(&f.holds).for_each(|(h, &row)| *h |= row);
        }
        let held = &self.held;
        let unseen =
            |rows: &Vec<bool>| rows.iter().any(|&row| row) && rows.iter().zip(held).all(|(&row, &held)| held || !row);
        hidden[..self.states].fill(false);
        hidden[self.states..].iter_mut().zip(&self.acts_on).for_each(|(h, rows)| *h = unseen(rows));
    }

    /// The flow over one interval with its derivatives; `w` is standardized noise. Parameters that stay hidden throughout
    /// neither act nor walk: the creep of smoothed friction, which depends on them, does not exist. Without `hide` nothing
    /// is taken to be hidden.
    pub(crate) fn interval(&mut self, t: f64, z: &[f64], u: &[f64], w: &[f64], hide: bool) -> LinearizedInterval {
        let mut interval = LinearizedInterval::of(self);
        self.linearize(t, z, u, w, hide, &mut interval);
        interval
    }

    /// [`Augmented::interval`] in the room for one.
    pub(crate) fn linearize(
        &mut self,
        t: f64,
        z: &[f64],
        u: &[f64],
        w: &[f64],
        hide: bool,
        into: &mut LinearizedInterval,
    ) {
        let (n, m) = (self.size(), self.inputs);
        let columns = n + m + self.noise.len();
        self.inputs_and_noise[..m].copy_from_slice(u);
        for (slot, (w, (_, std))) in self.inputs_and_noise[m..].iter_mut().zip(w.iter().zip(&self.noise)) {
            *slot = w * std;
        }
        let end = into.end.as_mut_slice();
        end.copy_from_slice(z);
        let substeps = self.substeps(t, z);
        let interval = Interval { t, dt: self.dt, substeps, u: &self.inputs_and_noise };
        self.shooter.advance_with_sensitivity(&mut self.dynamics, interval, end, &mut self.jacobian);
        self.stuck.fill(hide);
        self.keep_stuck(t, z, u);
        self.keep_stuck(t + self.dt, end, u);
        self.hide(&mut into.hidden);
        if self.stuck.contains(&true) {
            self.take_out_creep(t, z, substeps, end);
        }
        let (hidden, entry) = (&into.hidden, |i: usize, j: usize| self.jacobian[i * columns + j]);
        for i in 0..n {
            for j in 0..n {
                into.f[(i, j)] = if hidden[j] && i != j { 0.0 } else { entry(i, j) };
            }
            for (k, &(state, std)) in self.noise.iter().enumerate() {
                into.g[(i, k)] = if hidden[state] { 0.0 } else { entry(i, n + m + k) * std };
            }
        }
    }

    /// What smoothed friction holds creeps with a speed proportional to the width: extrapolation to the width 0.
    fn take_out_creep(&mut self, t: f64, z: &[f64], substeps: usize, end: &mut [f64]) {
        let mut half = std::mem::take(&mut self.half);
        half.copy_from_slice(z);
        self.dynamics.set_smoothing(self.width / 2.0);
        let interval = Interval { t, dt: self.dt, substeps: 2 * substeps, u: &self.inputs_and_noise };
        self.shooter.advance(&mut self.dynamics, interval, &mut half);
        self.dynamics.set_smoothing(self.width);
        end.iter_mut().zip(&half).for_each(|(whole, half)| *whole = 2.0 * half - *whole);
        self.half = half;
    }

    fn substeps(&mut self, t: f64, z: &[f64]) -> usize {
        match self.substeps {
            Substeps::Fixed(s) => s,
            Substeps::AtLeast(s) if self.implicit => s,
            Substeps::AtLeast(s) => {
                let rate = self.dynamics.relaxation_rate(t, z, &self.inputs_and_noise);
                s.max((self.dt * rate / STABLE_STEP).ceil().min(1e4) as usize)
            }
        }
    }

    /// Outputs h(z) and ∂h/∂z.
    pub(crate) fn outputs(&mut self, t: f64, z: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let (n, p) = (self.size(), self.sensors.len());
        let (h, c) = self.measure(t, z);
        (DVector::from_column_slice(h), DMatrix::from_row_slice(p, n, c))
    }

    /// Outputs h(z), and ∂h/∂z row by row.
    pub(crate) fn measure(&mut self, t: f64, z: &[f64]) -> (&[f64], &[f64]) {
        self.time_and_states[0] = t;
        self.time_and_states[1..].copy_from_slice(z);
        self.outputs.call(&self.time_and_states, &mut self.work, &mut self.values);
        self.measured()
    }

    /// What [`Augmented::measure`] gave last.
    pub(crate) fn measured(&self) -> (&[f64], &[f64]) {
        self.values.split_at(self.sensors.len())
    }

    /// y − h, to the nearest turn for angles.
    pub(crate) fn residual(&self, output: usize, y: f64, h: f64) -> f64 {
        match self.sensors[output].1 {
            Some(period) => (y - h) - period * ((y - h) / period).round(),
            None => y - h,
        }
    }
}

/// The friction forces with the rows they hold, and the rows that every parameter and disturbance acts on.
fn hiding(system: &mut System, form: &SwitchedForm, states: usize) -> (Vec<Friction>, Vec<Vec<bool>>) {
    let acts = |pool: &Pool, s: Symbol| form.dynamics.iter().map(|&f| pool.depends_on(f, s)).collect::<Vec<bool>>();
    let pool = &system.pool;
    let single = form.signs().len();
    let ranges = (0..single).map(|i| i..i + 1).chain(form.unit_vectors.iter().map(|v| v.switches.clone()));
    let friction = ranges
        .filter(|r| r.clone().all(|i| form.switches[i].kind == SwitchKind::Jump))
        .map(|signs| {
            let mut holds = vec![false; form.dynamics.len()];
            for i in signs.clone() {
                let rows = acts(pool, form.switches[i].sign);
                holds.iter_mut().zip(rows).for_each(|(h, row)| *h |= row);
            }
            Friction { signs, holds }
        })
        .collect();
    (friction, system.states[states..].iter().map(|&s| acts(pool, s)).collect())
}

/// The smoothed signs as functions of time, states, inputs and width.
fn sign_function(system: &mut System, form: &SwitchedForm) -> Result<Function, MpcError> {
    let width_symbol = system.pool.symbol("smoothing#width");
    let width = system.pool.sym(width_symbol);
    let map = system.smooth_signs(form, width);
    let signs: Vec<Expr> = form.switches.iter().map(|s| system.pool.sym(s.sign)).collect();
    let smooth = system.pool.substitute_all(&signs, &map);
    let time = system.pool.symbol("t");
    let mut arguments = vec![time];
    arguments.extend(system.states.iter().chain(&system.inputs));
    arguments.push(width_symbol);
    let tape: Tape = system.compile(&arguments, &smooth)?;
    Ok(Function::new(tape))
}
