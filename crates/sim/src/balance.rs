//! Energy balance and invariants along a trajectory.

use crate::friction::Filippov;
use crate::{InputError, Inputs, Model, Switched, Trajectory};
use bracketry_numerics::collocation::GAUSS_5;
use bracketry_symbolic::{Expr, Names, Pool};
use bracketry_system::{InputDerivative, System};
use rustc_hash::FxHashMap;

/// Change of the work of a step, relative to all work so far, at which its quadrature is fine enough.
const QUADRATURE: f64 = 1e-13;
/// Most parts of a step for the quadrature.
const MOST_PARTS: usize = 64;

/// Keeps account of the energy of a model: what is stored against the power that flows in, and of quantities that
/// should not change.
///
/// ```
/// use bracketry_sim::{simulate, Balance, Inputs, Model, SimulationSettings};
/// use bracketry_system::System;
/// let text = r#"
///     states = ["x", "v"]
///     inputs = ["a"]
///     parameters = { f = 1 }
///     dynamics = { x = "v", v = "a - x - f*sign(v)" }
/// "#;
/// let system = System::parse("block.toml", text).unwrap();
/// let inputs = Inputs::new().expression("a", "3*sin(t)");
/// let run = simulate(Model::new(&system, &inputs).unwrap(), 0.0, &[1.0, 0.0], 20.0, &SimulationSettings::default()).unwrap();
/// // Per mass: stored (v² + x²)/2, power of the drive and of friction.
/// let mut balance = Balance::new(&system, &inputs, "(v^2 + x^2)/2", "(a - f*sign(v))*v", &[]).unwrap();
/// assert!(balance.of(&run.trajectory).relative_error() < 1e-8);
/// ```
#[derive(Debug, Clone)]
pub struct Balance {
    model: Model,
    measures: usize,
}

/// The account of one trajectory: see [`Balance::of`].
#[derive(Debug, Clone, PartialEq)]
pub struct Account {
    /// The times at which steps start, and the end, in seconds.
    pub times: Vec<f64>,
    /// The stored energy at these times.
    pub stored: Vec<f64>,
    /// The work done since the start: the integral of the power.
    pub work: Vec<f64>,
    /// The work done and taken up: the integral of the power's size.
    pub turnover: f64,
    /// By invariant, its values at these times.
    pub invariants: Vec<Vec<f64>>,
    /// By invariant, its largest deviation from its first value, within steps too.
    pub drifts: Vec<f64>,
}

impl Account {
    /// By how much stored energy and work differ at most since the start.
    pub fn error(&self) -> f64 {
        let Some(&first) = self.stored.first() else { return 0.0 };
        self.stored.iter().zip(&self.work).map(|(e, w)| (e - first - w).abs()).fold(0.0, f64::max)
    }

    /// [`Account::error`] relative to the energy that has been exchanged or stored.
    pub fn relative_error(&self) -> f64 {
        let size = self.stored.iter().fold(self.turnover, |m, e| m.max(e.abs()));
        if size > 0.0 { self.error() / size } else { 0.0 }
    }
}

/// The names of a model, with time and input derivatives.
struct Scope {
    names: FxHashMap<String, Expr>,
    inputs: Vec<String>,
    derivatives: Vec<InputDerivative>,
}

impl Names for Scope {
    fn lookup(&mut self, _pool: &mut Pool, name: &str) -> Option<Expr> {
        self.names.get(name).copied()
    }

    fn derivative(&mut self, pool: &mut Pool, name: &str, order: u32) -> Option<Expr> {
        let input = self.inputs.iter().position(|u| u == name)?;
        if let Some(known) = self.derivatives.iter().find(|d| d.input == input && d.order == order) {
            return Some(pool.sym(known.symbol));
        }
        let text = if order == 1 { format!("der({name})") } else { format!("der({name}, {order})") };
        let symbol = pool.symbol(&text);
        self.derivatives.push(InputDerivative { input, order, symbol });
        Some(pool.sym(symbol))
    }

    fn known(&self) -> Vec<String> {
        self.names.keys().cloned().collect()
    }
}

impl Balance {
    /// Prepares the account of a system with these inputs: the energy stored and the power that flows in, and
    /// invariants, as expressions of states, inputs and their derivatives, parameters, definitions and time `t`. Signs
    /// and unit vectors of the equations have their actual values in them, also where they stick.
    ///
    /// # Errors
    /// [`InputError`] if an expression cannot be read, or the inputs do not fit.
    pub fn new(
        system: &System,
        inputs: &Inputs,
        stored: &str,
        power: &str,
        invariants: &[&str],
    ) -> Result<Self, InputError> {
        let mut system = system.clone();
        let mut scope = Scope {
            names: system.definitions.iter().cloned().collect(),
            inputs: system.input_names(),
            derivatives: system.input_derivatives.clone(),
        };
        let time = system.pool.symbol(crate::model::TIME);
        let live: Vec<String> = inputs.live.iter().map(|(name, _)| name.clone()).collect();
        let live: Vec<_> = live.iter().map(|name| system.pool.symbol(name)).collect();
        scope.names.insert("t".to_owned(), system.pool.sym(time));
        let parameters: Vec<_> = system.parameters.iter().map(|p| p.symbol).collect();
        for symbol in system.states.iter().chain(&system.inputs).chain(&parameters).chain(&live) {
            let e = system.pool.sym(*symbol);
            scope.names.insert(system.pool.name(*symbol).to_owned(), e);
        }
        for text in [stored, power].iter().chain(invariants) {
            let e = system
                .pool
                .parse_with(text, &mut scope)
                .map_err(|source| InputError::Quantity { text: (*text).to_owned(), source })?;
            system.outputs.push(((*text).to_owned(), e));
        }
        system.input_derivatives = scope.derivatives;
        let measures = 2 + invariants.len();
        Ok(Self { model: Model::with_measures(&system, inputs, measures)?, measures })
    }

    /// Keeps account along a trajectory of the same system with the same inputs: the work by Gauss–Legendre quadrature of
    /// the power on every step, none of which contains an event.
    pub fn of(&mut self, trajectory: &Trajectory) -> Account {
        let mut step = Step { field: Filippov::new(self.model.clone()), trajectory };
        step.field.modes.copy_from_slice(trajectory.initial_modes());
        let mut changes = trajectory.mode_changes().iter().peekable();
        let times: Vec<f64> = trajectory.times().collect();
        let count = self.measures - 2;
        let mut account = Account {
            times: times.clone(),
            stored: Vec::with_capacity(times.len()),
            work: Vec::with_capacity(times.len()),
            turnover: 0.0,
            invariants: vec![Vec::with_capacity(times.len()); count],
            drifts: vec![0.0; count],
        };
        let mut work = 0.0;
        let mut firsts: Vec<f64> = Vec::new();
        let mut values = vec![0.0; self.measures];
        for (i, &t) in times.iter().enumerate() {
            let end = times.get(i + 1).copied();
            if end.is_some() {
                step.field.system.enter_segment(t);
            }
            while let Some(change) = changes.next_if(|e| e.t <= t) {
                step.field.modes[change.switch] = change.to;
            }
            step.field.any().apply_modes();
            step.measure(t, &mut values);
            account.stored.push(values[0]);
            account.work.push(work);
            if firsts.is_empty() {
                firsts.extend_from_slice(&values[2..]);
            }
            for (list, v) in account.invariants.iter_mut().zip(&values[2..]) {
                list.push(*v);
            }
            widen(&mut account.drifts, &firsts, &values);
            let Some(end) = end else { break };
            let mut parts = 1;
            let mut last = step.work(t, end, parts, &mut values);
            // Sticking steps may be longer than the inputs' periods.
            while parts < MOST_PARTS {
                parts *= 2;
                let finer = step.work(t, end, parts, &mut values);
                let change = (finer.0 - last.0).abs();
                last = finer;
                if change <= QUADRATURE * (last.1 + account.turnover) {
                    break;
                }
            }
            work += last.0;
            account.turnover += last.1;
            for (node, _) in GAUSS_5 {
                step.measure(t + node * (end - t), &mut values);
                widen(&mut account.drifts, &firsts, &values);
            }
        }
        account
    }
}

/// Measures within one step.
struct Step<'a> {
    field: Filippov<Model>,
    trajectory: &'a Trajectory,
}

impl Step<'_> {
    fn measure(&mut self, t: f64, values: &mut [f64]) {
        let (mut x, mut dx) = (vec![0.0; self.trajectory.dim()], vec![0.0; self.trajectory.dim()]);
        self.trajectory.sample_into(t, &mut x);
        self.field.any().release_directions();
        if let Some(directions) = self.trajectory.directions(t, self.field.s.len()) {
            self.field.any().set_directions(&directions);
        }
        self.field.any().evaluate((t, &x), &mut dx);
        self.field.system.measure(t, &x, &self.field.s, values);
    }

    /// The integrals of the power and of its size over a step, by the rule on `parts` equal parts.
    fn work(&mut self, from: f64, to: f64, parts: usize, values: &mut [f64]) -> (f64, f64) {
        let width = (to - from) / parts as f64;
        let (mut work, mut size) = (0.0, 0.0);
        for part in 0..parts {
            for (node, weight) in GAUSS_5 {
                self.measure(from + (part as f64 + node) * width, values);
                work += weight * width * values[1];
                size += weight * width * values[1].abs();
            }
        }
        (work, size)
    }
}

fn widen(drifts: &mut [f64], firsts: &[f64], values: &[f64]) {
    for ((drift, first), v) in drifts.iter_mut().zip(firsts).zip(&values[2..]) {
        *drift = drift.max((v - first).abs());
    }
}
