//! Models that are discrete in time: x(t + period) = f(x, u), with `sign(0) = 0`. Nothing is integrated.

use crate::{Outcome, Simulation, Statistics, StopReason, Trajectory};
use bracketry_symbolic::{CompileError, Tape};
use bracketry_system::System;

/// A compiled model that is discrete in time.
#[derive(Clone, Debug)]
pub struct DiscreteModel {
    period: f64,
    map: Tape,
    states: usize,
    arguments: Vec<f64>,
    work: Vec<f64>,
}

impl DiscreteModel {
    /// Compiles a model; none if it is continuous in time.
    ///
    /// ```
    /// use bracketry_sim::DiscreteModel;
    /// use bracketry_system::{Accepted, System};
    /// let text = "time = 'discrete'\nperiod = 0.5\nstates = ['x']\ninputs = ['u']\ndynamics = { x = 'x/2 + u' }";
    /// let system = System::parse_accepting("filter", text, Accepted { discrete: true, ..Accepted::default() }).unwrap();
    /// let mut filter = DiscreteModel::of(&system).unwrap().unwrap();
    /// let mut x = [4.0];
    /// filter.step(&mut x, &[1.0]);
    /// assert_eq!((x[0], filter.period()), (3.0, 0.5));
    /// ```
    ///
    /// # Errors
    /// If the equations use something else than states, inputs and parameters.
    pub fn of(system: &System) -> Result<Option<Self>, CompileError> {
        let Some(period) = system.period else { return Ok(None) };
        let arguments = system.arguments();
        let map = system.compile(&arguments, &system.dynamics)?;
        let states = system.states.len();
        Ok(Some(Self { period, map, states, arguments: vec![0.0; arguments.len()], work: Vec::new() }))
    }

    /// Time of one step, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.states
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.arguments.len() - self.states
    }

    /// The next state under these inputs.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn step(&mut self, x: &mut [f64], u: &[f64]) {
        let (state, inputs) = self.arguments.split_at_mut(self.states);
        state.copy_from_slice(x);
        inputs.copy_from_slice(u);
        self.map.eval(&self.arguments, &mut self.work, x);
    }

    /// The states of `steps` steps from `x0` at `start`, under the inputs that `inputs` gives for a step's number and time. It ends
    /// before a state that is not finite.
    pub fn iterate(
        &mut self,
        start: f64,
        x0: &[f64],
        steps: usize,
        mut inputs: impl FnMut(usize, f64) -> Vec<f64>,
    ) -> Simulation {
        let time = |k: usize| start + k as f64 * self.period;
        let (mut times, mut states) = (vec![start], vec![x0.to_vec()]);
        let mut outcome = Outcome::Finished;
        let mut x = x0.to_vec();
        let times_of: Vec<f64> = (0..=steps).map(time).collect();
        for k in 0..steps {
            let before = x.clone();
            let u = inputs(k, times_of[k]);
            self.step(&mut x, &u);
            if x.iter().any(|v| !v.is_finite()) {
                outcome = Outcome::Stopped { reason: StopReason::NonFinite, t: times_of[k], state: before };
                break;
            }
            times.push(times_of[k + 1]);
            states.push(x.clone());
        }
        let statistics = Statistics { steps: times.len() - 1, rhs: times.len() - 1, ..Statistics::default() };
        Simulation { trajectory: Trajectory::held(&times, &states), outcome, statistics }
    }
}
