//! Steady states for a reference under the estimated disturbance.

use super::augmented::Augmented;
use super::problem::EstimationProblem;
use crate::dynamics::SymbolicDynamics;
use crate::error::{MpcError, check_length};
use crate::ocp::{CostFunction, Ocp, TerminalTarget};
use crate::sqp::{SolveStatus, Sqp, SqpSettings};
use crate::trajectory::PlannedTrajectory;
use bracketry_symbolic::Rational;
use bracketry_system::Parameter;

/// Weight of a unit of acceleration where there should be none, over that of a unit of a missed reference.
const REST: f64 = 1e3;
/// Weight of squares that choose among many steady states the smallest.
const SMALL: f64 = 1e-6;

/// How far the target goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TargetStatus {
    /// The reference is met by a steady state within the bounds.
    Reached,
    /// No steady state within the bounds meets the reference; this one comes closest.
    Nearest {
        /// Largest miss of a reference.
        miss: f64,
    },
    /// No steady state was found at all.
    NotSteady {
        /// Largest derivative of a state that is left.
        residual: f64,
        /// How the search ended.
        status: SolveStatus,
    },
}

/// A steady state and what holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct SteadyTarget {
    /// States.
    pub x: Vec<f64>,
    /// Inputs.
    pub u: Vec<f64>,
    /// How far it goes.
    pub status: TargetStatus,
}

/// The steady-state target calculation of offset-free control:
///
/// ```text
/// min ‖g(x; p) − r‖₁   s.t.   f(x, u; p) + d = 0,   x and u in their bounds
/// ```
///
/// for the estimated parameters p and disturbances d. Dry friction gives nothing at rest: u is the middle of the inputs that
/// hold the state.
///
/// Source: Muske and Rawlings 1993; Pannocchia and Rawlings 2003.
pub struct TargetCalculator {
    sqp: Sqp,
    guess: PlannedTrajectory,
    states: usize,
    references: usize,
    /// Number of parameters and disturbances.
    live: usize,
}

impl TargetCalculator {
    /// A calculator for the model of an estimation problem. `controlled` are the indices of the measured outputs g that have a
    /// reference, `input_bounds` the bounds of the inputs; those of the states are the problem's.
    ///
    /// # Errors
    /// If the problem contradicts itself or has no output with such an index.
    pub fn new(
        problem: &EstimationProblem,
        controlled: &[usize],
        input_bounds: &[(f64, f64)],
    ) -> Result<Self, MpcError> {
        let n = problem.system.states.len();
        let m = problem.system.inputs.len();
        check_length("the input bounds of the target", input_bounds.len(), m)?;
        let (mut system, outputs) = Augmented::disturbed(problem)?;
        if let Some(&index) = controlled.iter().find(|&&i| i >= outputs.len()) {
            let (found, expected) = (outputs.len(), index + 1);
            return Err(MpcError::Length { what: "the list of measured outputs", found, expected });
        }
        let live = problem.live_parameters();
        let mut names = live.clone();
        let decisions: Vec<_> = system.states.iter().chain(&system.inputs).copied().collect();
        let mut rows = system.dynamics.clone();
        for (i, &index) in controlled.iter().enumerate() {
            let g = outputs[index];
            let symbol = system.pool.symbol(&format!("reference#{i}"));
            system.parameters.push(Parameter {
                symbol,
                value: Rational::ZERO,
                min: None,
                max: None,
                unit: None,
                about: None,
            });
            names.push(format!("reference#{i}"));
            let r = system.pool.sym(symbol);
            rows.push(system.pool.sub(g, r));
        }
        // One step of length 1 from 0 makes the residuals the end state, and their exact penalty its target.
        system.states = (0..rows.len()).map(|i| system.pool.symbol(&format!("residual#{i}"))).collect();
        system.inputs = decisions;
        system.dynamics = rows;
        system.outputs.clear();
        let mut ocp = Ocp::new(system.states.len(), n + m, 1, 1.0);
        ocp.input_bounds = problem.bounds.iter().chain(input_bounds).copied().collect();
        let weight = |i: usize| if i < n { REST } else { 1.0 };
        ocp.targets = (0..system.states.len())
            .map(|i| TerminalTarget { state: i, value: 0.0, linear: weight(i), quadratic: 0.0 })
            .collect();
        let small = system.pool.parse(&format!("{SMALL}"))?;
        let mut cost = system.pool.int(0);
        for &s in &system.inputs {
            let v = system.pool.sym(s);
            let square = system.pool.powi(v, 2);
            let term = system.pool.mul(small, square);
            cost = system.pool.add(cost, term);
        }
        let time = system.pool.symbol("t");
        let (states, inputs) = (system.states.clone(), system.inputs.clone());
        ocp.stage = Some(CostFunction::compile(&mut system.pool, time, &states, &inputs, &[], cost)?);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let dynamics = SymbolicDynamics::with_live_parameters(&system, &names)?;
        let settings = SqpSettings { smoothing: vec![problem.smoothing], ..SqpSettings::default() };
        let mut start = problem.initial.clone();
        start.extend(vec![0.0; m]);
        Ok(Self {
            guess: PlannedTrajectory::constant(1, &vec![0.0; ocp.states()], &start),
            sqp: Sqp::new(Box::new(dynamics), ocp, settings)?,
            states: n,
            references: controlled.len(),
            live: live.len(),
        })
    }

    /// The target for these references, under these parameters and disturbances (one after the other).
    ///
    /// # Errors
    /// If a length is wrong; everything else is a status.
    pub fn target(&mut self, reference: &[f64], parameters: &[f64]) -> Result<SteadyTarget, MpcError> {
        check_length("the references", reference.len(), self.references)?;
        check_length("the parameters", parameters.len(), self.live)?;
        let mut values = parameters.to_vec();
        values.extend_from_slice(reference);
        self.sqp.set_parameters(&values)?;
        let rest = vec![0.0; self.guess.states()];
        let solution = self.sqp.solve(&rest, &self.guess)?;
        let worst =
            |miss: &[f64]| miss.iter().fold(0.0, |w: f64, m| if m.is_nan() { f64::NAN } else { w.max(m.abs()) });
        let (residual, miss) = (worst(&solution.miss[..self.states]), worst(&solution.miss[self.states..]));
        let scale = 1.0 + reference.iter().fold(0.0, |s: f64, r| s.max(r.abs()));
        let status = if residual.is_nan() || residual > 1e-4 {
            TargetStatus::NotSteady { residual, status: solution.status }
        } else if miss > 1e-5 * scale {
            TargetStatus::Nearest { miss }
        } else {
            TargetStatus::Reached
        };
        if solution.trajectory.is_finite() {
            self.guess = solution.trajectory;
        }
        let decision = self.guess.u(0);
        Ok(SteadyTarget { x: decision[..self.states].to_vec(), u: decision[self.states..].to_vec(), status })
    }
}
