//! Sizes of states and inputs: those of a problem file, and what to expect where it gives none.

use super::reader::{Parsed, Reader, Variable};
use crate::closed_loop::{Plant, RungeKuttaPlant};
use crate::dynamics::{Dynamics, SymbolicDynamics};
use crate::integrator::{Integrator, Interval};
use crate::ocp::{CostPoint, Ocp, Substeps};
use crate::problem::{Note, ProblemError};
use crate::transcription::Shooter;
use bracketry_numerics::eigen;
use bracketry_system::Table;
use nalgebra::{Complex, DMatrix};

/// Product of step and fastest rate of the dynamics up to which a trial run takes one step.
const RESOLVED: f64 = 1.0;
/// The same for the problem itself: the Runge–Kutta method of order 4 is stable up to 2.78.
const STABLE: f64 = 2.5;
/// Width of smoothing at which friction adds nothing to the rates.
const WITHOUT_FRICTION: f64 = 1e9;
/// Product of interval and rate of every mode beyond which nothing of the motion is left at the next sample.
const LONG: f64 = 10.0;
/// Share of the fastest rate below which a mode is one of rest, such as a position without force.
const AT_REST: f64 = 1e-6;
/// Share of what others change in a state below which its size is rounding.
const ROUNDING: f64 = 1e-8;
/// Size of an input without a range below which its guess counts as zero.
const NO_INPUT: f64 = 1e-12;
/// Most steps of an interval.
const MOST_STEPS: f64 = 1e3;

/// What trial runs tell beside typical sizes.
pub(super) struct Expected {
    /// What the horizon costs along the trial runs, per unit of time step.
    pub(super) cost_level: f64,
    /// Steps of an interval for which the Runge–Kutta method of order 4 is stable.
    pub(super) explicit_steps: usize,
    /// What is to be said of an interval that is much longer than every motion of the model.
    pub(super) long_interval: Option<Note>,
}

impl Reader<'_> {
    /// Typical sizes: the largest of initial value, bounds and the model's point, and how far trial runs under constant
    /// inputs (those of the guess, then each at its bounds) take a state within one interval, or, up to 1, within the horizon.
    ///
    /// Where the file does not say how many integration steps an interval gets, an explicit method gets enough to be stable
    /// for the fastest mode along the guess.
    pub(super) fn expected_sizes(
        &self,
        x0: &[f64],
        guess: &[Vec<f64>],
        ocp: &mut Ocp,
    ) -> Result<Expected, ProblemError> {
        let (n, m) = (ocp.model_states(), ocp.inputs());
        let point = self.system.point_values();
        let finite = |values: &[f64]| values.iter().filter(|v| v.is_finite()).fold(0.0, |s: f64, v| s.max(v.abs()));
        let constant = |ocp: &Ocp, j: usize| ocp.constant_inputs.contains(&j);
        for j in (0..m).filter(|&j| !constant(ocp, j)).collect::<Vec<_>>() {
            let (min, max) = ocp.input_bounds[j];
            let half = (max - min) / 2.0;
            if half.is_finite() && half > 0.0 {
                ocp.input_trust[j] = half;
            } else {
                let guessed = guess.iter().fold(0.0, |s: f64, u| s.max(u[j].abs()));
                let known = finite(&[min, max]).max(guessed).max(point.as_ref().map_or(0.0, |p| p.1[j].abs()));
                ocp.input_trust[j] = if known > NO_INPUT { known } else { 1.0 };
            }
        }
        let mut sizes: Vec<f64> = (0..n)
            .map(|i| {
                let b = ocp.state_bounds[i];
                finite(&[b.min, b.max, x0[i], point.as_ref().map_or(0.0, |p| p.0[i])])
            })
            .collect();
        let mut dynamics = SymbolicDynamics::new(self.system)?;
        let mut rates = dynamics.clone();
        // The rates of smoothed friction are those of its width, with which the steps of a solution change.
        rates.set_smoothing(WITHOUT_FRICTION);
        let mut rate = fastest_rate(&mut rates, 0.0, x0, &guess[0]);
        let long_interval = long_interval(ocp.dt, &eigenvalues(&mut rates, 0.0, x0, &guess[0]));
        if let Some((x, u)) = &point {
            rate = rate.max(fastest_rate(&mut rates, 0.0, x, u));
        }
        dynamics.set_smoothing(sizes.iter().fold(1e-2, |w: f64, s| w.max(0.1 * s)));
        let steps = steps_for(ocp.longest() * fastest_rate(&mut dynamics, 0.0, x0, &guess[0]) / RESOLVED);
        let mut advance = trial_step(dynamics, ocp, steps);
        let mut trials = vec![guess.to_vec()];
        // Constants are not driven to the ends of their ranges.
        for (j, b) in ocp.input_bounds.iter().enumerate().filter(|(j, _)| !constant(ocp, *j)) {
            for end in [b.0, b.1].into_iter().filter(|end| end.is_finite()) {
                let mut u = guess[0].clone();
                u[j] = end;
                trials.push(vec![u; guess.len()]);
            }
        }
        for (trial, inputs) in trials.iter().enumerate() {
            let mut x = x0.to_vec();
            for (k, u) in inputs.iter().enumerate() {
                let before = x.clone();
                if !advance(k, &mut x, u) || x.iter().any(|v| !v.is_finite()) {
                    break;
                }
                // Under constant inputs at their bounds a state may soon be where no loop takes it.
                if trial == 0 || k == 0 {
                    rate = rate.max(fastest_stable_rate(&mut rates, ocp.time(0, k), &x, u));
                }
                for i in 0..n {
                    let near = if k == 0 { (x[i] - before[i]).abs() } else { 0.0 };
                    sizes[i] = sizes[i].max(near).max(x[i].abs().min(1.0));
                }
            }
        }
        drop_rounding(&mut rates, (x0, &guess[0]), ocp, &mut sizes);
        let explicit = steps_for(ocp.longest() * rate / STABLE);
        // An implicit method is stable for any step.
        if let Substeps::AtLeast(s) = ocp.substeps
            && ocp.integrator == Integrator::Rk4
        {
            ocp.substeps = Substeps::AtLeast(s.max(explicit));
        }
        for (scale, size) in ocp.state_scale.iter_mut().zip(sizes) {
            *scale = if size > 0.0 { size } else { 1.0 };
        }
        for (i, p) in ocp.previous_inputs.iter().enumerate() {
            ocp.state_scale[n + i] = ocp.input_trust[p.input];
        }
        Ok(Expected { cost_level: cost_level(ocp, x0, &guess[0]), explicit_steps: explicit, long_interval })
    }

    /// The tables `[scale]` and `[trust]`.
    pub(super) fn scales(&self, table: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        if let Some(t) = self.doc.sub_table(table, "scale")? {
            for key in t.keys() {
                let i = self.state(key.get_ref(), key.span())?;
                ocp.state_scale[i] = self.positive(t, key.get_ref(), None)?;
                if let Some(size) = ocp.state_size.get_mut(i) {
                    *size = ocp.state_scale[i];
                }
            }
        }
        if let Some(t) = self.doc.sub_table(table, "trust")? {
            for key in t.keys() {
                let value = self.positive(t, key.get_ref(), None)?;
                match self.variable(key.get_ref(), key.span())? {
                    Variable::State(i) => ocp.state_trust[i] = value,
                    Variable::Input(j) => ocp.input_trust[j] = value,
                }
            }
        }
        Ok(())
    }
}

/// Sets to zero the size of a state that is all rounding, as with sin(π): one far below what inputs and other states, each of its size, change in it
/// within an interval. Bounds are meant as they are.
fn drop_rounding(dynamics: &mut SymbolicDynamics, (x0, u0): (&[f64], &[f64]), ocp: &Ocp, sizes: &mut [f64]) {
    let n = sizes.len();
    let entries = jacobian(dynamics, 0.0, x0, u0);
    let interval = if ocp.integrator == Integrator::Map { 1.0 } else { ocp.longest() };
    let is_rounding = |i: usize, sizes: &[f64]| {
        let b = &ocp.state_bounds[i];
        let bounded = [b.min, b.max].iter().any(|b| b.is_finite() && *b != 0.0);
        let of = |j: usize| {
            if j >= n {
                ocp.input_trust[j - n]
            } else if sizes[j] > 0.0 {
                sizes[j]
            } else {
                1.0
            }
        };
        let others = entries.iter().filter(|e| e.0 == i && e.1 != i);
        let reach = others.map(|&(_, j, v)| (v * of(j)).abs() * interval).fold(0.0, f64::max);
        !bounded && sizes[i] > 0.0 && sizes[i] < ROUNDING * reach
    };
    // What moves by rounding alone moves others so.
    while let Some(i) = (0..n).find(|&i| is_rounding(i, sizes)) {
        sizes[i] = 0.0;
    }
}

/// A note on an interval within which every mode but those at rest ends, or an unstable one leaves every bound behind.
fn long_interval(dt: f64, modes: &[Complex<f64>]) -> Option<Note> {
    let fastest = modes.iter().fold(0.0, |r: f64, l| r.max(l.norm()));
    let slowest = modes.iter().map(|l| l.norm()).filter(|r| *r > AT_REST * fastest).fold(f64::INFINITY, f64::min);
    let growth = modes.iter().fold(0.0, |r: f64, l| r.max(l.re));
    let rate = if slowest.is_finite() { slowest.max(growth) } else { growth };
    (dt * rate > LONG).then(|| Note::LongInterval { dt, time_constant: 1.0 / rate })
}

/// Number of the interval, state, input: advances the state; whether that worked.
type TrialStep = Box<dyn FnMut(usize, &mut [f64], &[f64]) -> bool>;

/// Advances a trial run by one interval: by the method of the problem where that is implicit, which stiff models need, or a map, else
/// by the Runge–Kutta method with this number of steps.
fn trial_step(mut dynamics: SymbolicDynamics, ocp: &Ocp, steps: usize) -> TrialStep {
    let grid: Vec<(f64, f64)> = (0..ocp.steps).map(|k| (ocp.time(0, k), ocp.length(k))).collect();
    if ocp.integrator != Integrator::Rk4 {
        let substeps = ocp.substeps.least();
        let mut shooter = Shooter::new(&dynamics, ocp.integrator);
        return Box::new(move |k, x, u| {
            let (t, dt) = grid[k];
            shooter.advance(&mut dynamics, Interval { t, dt, substeps, u }, x);
            !shooter.take_failure()
        });
    }
    let mut plant = RungeKuttaPlant::new(Box::new(dynamics), steps);
    Box::new(move |k, x, u| {
        let (t, dt) = grid[k];
        plant.step(t, x, u, dt).is_ok()
    })
}

/// N times the size of the stage cost, with the end of the horizon spread over it: the value at the start, and what moving
/// every state and input by its size changes to second order.
fn cost_level(ocp: &mut Ocp, x0: &[f64], u0: &[f64]) -> f64 {
    let (n, steps, dt) = (ocp.states(), ocp.steps as f64, ocp.dt);
    let sizes: Vec<f64> = ocp.state_scale.iter().chain(&ocp.input_trust).copied().collect();
    let r = ocp.reference(0).to_vec();
    let mut level = 0.0;
    let mut x = x0.to_vec();
    ocp.append_previous(&mut x, u0);
    let x0 = &x;
    for (cost, u, factor) in [(&mut ocp.stage, u0, steps), (&mut ocp.terminal, &[][..], 1.0 / dt)] {
        let Some(cost) = cost else { continue };
        let mut gradient = vec![0.0; n + u.len()];
        let mut hessian = vec![0.0; cost.hessian_pattern().len()];
        let r = &r[..cost.references()];
        cost.add_derivatives(CostPoint { x: x0, u, t: 0.0, r }, 1.0, &mut gradient, &mut hessian);
        let mut size = cost.value(x0, u, 0.0, r).abs();
        size += gradient.iter().zip(&sizes).map(|(g, s)| (g * s).abs()).sum::<f64>();
        for (&(i, j), h) in cost.hessian_pattern().iter().zip(&hessian) {
            if i == j {
                size += 0.5 * h * sizes[i] * sizes[i];
            }
        }
        level += factor * size;
    }
    for t in &ocp.targets {
        level += t.linear * (x0[t.state] - t.value).abs() / dt;
    }
    if level.is_finite() && level > 0.0 { level } else { 1e3 }
}

fn steps_for(steps: f64) -> usize {
    steps.ceil().clamp(1.0, MOST_STEPS) as usize
}

/// Largest modulus of the eigenvalues of ∂f/∂x; 0 where they are not to be had.
fn fastest_rate(dynamics: &mut SymbolicDynamics, t: f64, x: &[f64], u: &[f64]) -> f64 {
    eigenvalues(dynamics, t, x, u).iter().fold(0.0, |r: f64, l| r.max(l.norm()))
}

/// As [`fastest_rate`], of the modes that do not grow: an explicit method with too long a step makes them grow.
fn fastest_stable_rate(dynamics: &mut SymbolicDynamics, t: f64, x: &[f64], u: &[f64]) -> f64 {
    eigenvalues(dynamics, t, x, u).iter().filter(|l| l.re <= 0.0).fold(0.0, |r: f64, l| r.max(l.norm()))
}

/// Entries (i, j, value) of ∂f/∂(x, u).
fn jacobian(dynamics: &mut SymbolicDynamics, t: f64, x: &[f64], u: &[f64]) -> Vec<(usize, usize, f64)> {
    let pattern = dynamics.jacobian_pattern().to_vec();
    let (mut dx, mut entries) = (vec![0.0; dynamics.states()], vec![0.0; pattern.len()]);
    dynamics.field_and_jacobian(t, x, u, &mut dx, &mut entries);
    pattern.into_iter().zip(entries).map(|((i, j), v)| (i, j, v)).collect()
}

/// The eigenvalues of ∂f/∂x; none where they are not to be had.
fn eigenvalues(dynamics: &mut SymbolicDynamics, t: f64, x: &[f64], u: &[f64]) -> Vec<Complex<f64>> {
    let n = dynamics.states();
    let mut jacobian_of_states = DMatrix::zeros(n, n);
    for (i, j, v) in jacobian(dynamics, t, x, u).into_iter().filter(|e| e.1 < n) {
        jacobian_of_states[(i, j)] = v;
    }
    let found = eigen::eigenvalues(&jacobian_of_states).unwrap_or_default();
    found.into_iter().map(|(re, im)| Complex::new(re, im)).collect()
}
