//! Models with algebraic variables: x' = f(x, z, u), 0 = g(x, z, u), of index 1. The variables are solved for wherever the rates are
//! evaluated.

use crate::algebraic_root::{AlgebraicRoot, NoRoot};
use crate::model::{InputError, Inputs, Model};
use crate::switched::Switched;
use bracketry_system::System;

/// A compiled model with algebraic variables.
///
/// ```
/// use bracketry_sim::{ImplicitModel, Inputs, SimulationSettings, simulate};
/// use bracketry_system::{Accepted, System};
/// // x' = −z with z + z³ = x: (1 + 3z²) z' = −z, so that ln z + 3z²/2 falls by t.
/// let text = "states = ['x']\ndynamics = { x = '-z' }\nalgebraic = { z = 'z + z^3 - x' }";
/// let system = System::parse_accepting("m", text, Accepted { algebraic: true, ..Accepted::default() }).unwrap();
/// let model = ImplicitModel::new(&system, &Inputs::new()).unwrap();
/// // From z = 1 to z = 1/2.
/// let time = 2f64.ln() + 1.5 * (1.0 - 0.25);
/// let run = simulate(model, 0.0, &[2.0], time, &SimulationSettings::default()).unwrap();
/// assert!((run.trajectory.final_state()[0] - 0.625).abs() < 1e-8);
/// ```
#[derive(Clone, Debug)]
pub struct ImplicitModel {
    /// The model in which the variables are the last states, with g as their rates.
    whole: Model,
    n: usize,
    root: AlgebraicRoot,
    xz: Vec<f64>,
    rates: Vec<f64>,
    derivatives: Vec<f64>,
}

/// Parts of the time at which a motion is followed beyond its end.
const BEYOND: [f64; 4] = [1e-12, 1e-9, 1e-6, 1e-3];

impl ImplicitModel {
    /// Compiles a system with algebraic variables.
    ///
    /// # Errors
    /// As [`Model::new`].
    pub fn new(system: &System, inputs: &Inputs) -> Result<Self, InputError> {
        let (n, q) = (system.states.len(), system.algebraic.len());
        let whole = Model::differentiable(&system.with_algebraic_states(), inputs, &[])?;
        let guess = system.algebraic.iter().map(|z| system.value(z.guess).unwrap_or(0.0)).collect();
        Ok(Self {
            whole,
            n,
            root: AlgebraicRoot::new(guess),
            xz: vec![0.0; n + q],
            rates: vec![0.0; n + q],
            derivatives: vec![0.0; (n + q) * (n + q)],
        })
    }

    /// Solves for the algebraic variables at `t` in state `x`; (x, z) and the rates are those there.
    fn solve(&mut self, t: f64, x: &[f64]) -> Result<(), NoRoot> {
        let Self { whole, n, root, xz, rates, derivatives, .. } = self;
        let (n, w) = (*n, xz.len());
        xz[..n].copy_from_slice(x);
        let z = root.solve(|z, g, jacobian| {
            xz[n..].copy_from_slice(z);
            whole.rhs(t, xz, &[], rates);
            g.copy_from_slice(&rates[n..]);
            // Column by column.
            whole.derivatives(t, xz, &[], derivatives);
            let q = w - n;
            for i in 0..q {
                for j in 0..q {
                    jacobian[i * q + j] = derivatives[(n + j) * w + n + i];
                }
            }
        })?;
        xz[n..].copy_from_slice(&z);
        whole.rhs(t, xz, &[], rates);
        Ok(())
    }

    /// Why the algebraic equations have no solution at `t` in state `x`, or a little beyond in the direction of the motion.
    pub(crate) fn failure_beyond(&mut self, t: f64, x: &[f64]) -> Option<NoRoot> {
        self.enter_segment(t);
        if let Err(failure) = self.solve(t, x) {
            return Some(failure);
        }
        let rates = self.rates[..self.n].to_vec();
        BEYOND.into_iter().find_map(|step| {
            let step = step * t.abs().max(1e-3);
            let there: Vec<f64> = x.iter().zip(&rates).map(|(x, v)| x + step * v).collect();
            self.solve(t + step, &there).err()
        })
    }

    /// The inputs at `t`.
    pub(crate) fn input_values(&mut self, t: f64) -> Vec<f64> {
        self.whole.input_values(t)
    }

    /// The outputs at `t` in state `x`; no numbers where the equations have no solution.
    pub(crate) fn output_values(&mut self, t: f64, x: &[f64]) -> Vec<f64> {
        self.enter_segment(t);
        let solved = self.solve(t, x).is_ok();
        let mut values = self.whole.output_values(t, &self.xz);
        if !solved {
            values.fill(f64::NAN);
        }
        values
    }
}

impl Switched for ImplicitModel {
    fn dim(&self) -> usize {
        self.n
    }

    /// None: the reader of model files refuses switching functions beside such variables.
    fn switches(&self) -> usize {
        0
    }

    fn rhs(&mut self, t: f64, x: &[f64], _s: &[f64], dx: &mut [f64]) {
        match self.solve(t, x) {
            Ok(()) => dx.copy_from_slice(&self.rates[..self.n]),
            Err(_) => dx.fill(f64::NAN),
        }
    }

    fn switching(&mut self, _t: f64, _x: &[f64], _sigma: &mut [f64]) {}

    fn switching_gradient(&mut self, _t: f64, _x: &[f64], _gradient: &mut [f64], _partial_t: &mut [f64]) {}

    fn enter_segment(&mut self, t: f64) -> f64 {
        self.whole.enter_segment(t)
    }
}
