//! What a problem leaves free: its end time, parameters of the model, and initial states. All are constants that the plan decides on.
//!
//! In the problem that is solved for them they are inputs held over the whole horizon. With T the end time and σ = T/T_guess,
//!
//! ```text
//! dx/dτ = σ f(x, u, p, σ τ),   cost ∫ σ l(x, u, p, σ τ) dτ + m(x(T_guess), p, σ T_guess),   0 ≤ τ ≤ T_guess
//! ```
//!
//! on the grid of the guess. Their values are put into the file, which is read once more.

use crate::ocp::{Ocp, Remembered, coefficient_name, over_scaled_time};
use crate::problem::FoundValues;
use bracketry_symbolic::Rational;
use bracketry_system::{Parameter, System};

/// Name of σ.
const TIME_SCALE: &str = "end_time#scale";

/// Name of the input that stands for the initial value of a state.
pub(super) fn start_name(system: &System, state: usize) -> String {
    format!("{}#start", system.symbol_name(system.states[state]))
}

/// The values that a constant may take, and where the search for it begins.
#[derive(Clone, Debug)]
pub(super) struct FreeRange {
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) guess: f64,
}

impl FreeRange {
    /// Typical size of a change.
    fn size(&self) -> f64 {
        let half = (self.max - self.min) / 2.0;
        let half = if half.is_finite() { half } else { f64::INFINITY };
        let size = if self.guess == 0.0 { half } else { half.min(self.guess.abs()) };
        if size.is_finite() { size } else { 1.0 }
    }
}

/// What is free, in the order of the inputs that stand for it: the parameters, the initial states, then σ.
#[derive(Clone, Debug, Default)]
pub(super) struct Free {
    pub(super) parameters: Vec<(String, FreeRange)>,
    /// States, by number, whose initial value is free.
    pub(super) starts: Vec<(usize, FreeRange)>,
    pub(super) end_time: Option<FreeRange>,
}

impl Free {
    pub(super) fn is_empty(&self) -> bool {
        self.parameters.is_empty() && self.starts.is_empty() && self.end_time.is_none()
    }

    /// The ranges of the inputs that stand for what is free.
    fn inputs(&self) -> impl Iterator<Item = FreeRange> {
        let scale = self.end_time.iter().map(|r| FreeRange { min: r.min / r.guess, max: r.max / r.guess, guess: 1.0 });
        let starts = self.starts.iter().map(|(_, r)| r.clone());
        self.parameters.iter().map(|(_, r)| r.clone()).chain(starts).chain(scale)
    }

    /// The system in which they are inputs, the last ones. Parameters that vary over time are polynomials in σ, see
    /// [`ScaledRows`](crate::ocp::ScaledRows).
    pub(super) fn system(&self, system: &System, varying: &[String]) -> System {
        let mut system = system.clone();
        for (name, _) in &self.parameters {
            let pool = &system.pool;
            let symbols = system.parameters.iter().map(|p| p.symbol);
            let free: Vec<_> = symbols.filter(|s| pool.name(*s) == name).collect();
            system.parameters.retain(|p| !free.contains(&p.symbol));
            system.inputs.extend(free);
        }
        for (state, _) in &self.starts {
            let name = start_name(&system, *state);
            let start = system.pool.symbol(&name);
            system.inputs.push(start);
        }
        if self.end_time.is_some() {
            let scale = system.pool.symbol(TIME_SCALE);
            system.inputs.push(scale);
            let (scale, t) = (system.pool.sym(scale), system.pool.var("t"));
            let scaled = system.pool.mul(scale, t);
            let mut over_time = vec![(t, scaled)];
            for name in varying {
                let polynomial = over_scaled_time(&mut system.pool, name, scale);
                over_time.push((system.pool.var(name), polynomial));
                for power in [1, 2] {
                    let symbol = system.pool.symbol(&coefficient_name(name, power));
                    let value = Rational::default();
                    let coefficient = Parameter { symbol, value, min: None, max: None, unit: None, about: None };
                    system.parameters.push(coefficient);
                }
            }
            let over_time = over_time.into_iter().collect();
            let fields = system.pool.substitute_all(&system.dynamics, &over_time);
            system.dynamics = fields.into_iter().map(|f| system.pool.mul(scale, f)).collect();
            for (_, e) in system.definitions.iter_mut().chain(&mut system.outputs) {
                *e = system.pool.substitute(*e, &over_time);
            }
        }
        // A point of the model has no values for them.
        system.point = None;
        system
    }

    /// Names of the parameters.
    pub(super) fn names(&self) -> Vec<String> {
        self.parameters.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Gives the parameters of a system the values found, or those of the guess.
    pub(super) fn fix(&self, found: Option<&FoundValues>, system: &mut System) {
        for (name, range) in &self.parameters {
            let value = found.and_then(|f| f.parameters.get(name).copied()).unwrap_or(range.guess);
            system.set_parameter(name, Rational::simplest_from_f64(value).unwrap_or_default());
        }
    }

    /// The initial state with the values found, or those of the guess, in place of what is free.
    pub(super) fn start(&self, found: Option<&FoundValues>, system: &System, x0: &mut [f64]) {
        for (state, range) in &self.starts {
            let name = system.symbol_name(system.states[*state]);
            x0[*state] = found.and_then(|f| f.initial_states.get(name).copied()).unwrap_or(range.guess);
        }
    }

    /// Remembers the inputs that stand for what is free.
    pub(super) fn remember(&self, ocp: &Ocp, remembered: &mut Remembered) {
        remembered.constants.clone_from(&ocp.constant_inputs);
        remembered.inputs.extend(&remembered.constants);
        remembered.time_scale = self.end_time.as_ref().and(remembered.constants.last().copied());
    }

    /// Bounds, sizes and guesses of these inputs, the last ones of the problem.
    pub(super) fn bound(&self, ocp: &mut Ocp) {
        let first = ocp.inputs() - self.inputs().count();
        for (i, r) in self.inputs().enumerate() {
            ocp.input_bounds[first + i] = (r.min, r.max);
            ocp.constant_inputs.push(first + i);
            ocp.input_trust[first + i] = r.size();
        }
        let starts = first + self.parameters.len();
        ocp.free_starts = self.starts.iter().zip(starts..).map(|((state, _), input)| (*state, input)).collect();
    }

    /// Puts their guesses into rows of inputs, whose last entries they are.
    pub(super) fn guess(&self, rows: &mut [Vec<f64>]) {
        let guesses: Vec<f64> = self.inputs().map(|r| r.guess).collect();
        for row in rows {
            let first = row.len() - guesses.len();
            row[first..].copy_from_slice(&guesses);
        }
    }
}
