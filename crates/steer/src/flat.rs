//! Steering by flat outputs: polynomials between the values of the outputs and their derivatives at both ends.

use bracketry_lie::Evidence;
use bracketry_lie::analysis::ModeFields;
use bracketry_lie::feedback::{DynamicExtension, ExtensionLimits};
use bracketry_numerics::least_squares::{Damping, Settings, Status, minimize};
use bracketry_numerics::linear_equations::solve_vector;
use bracketry_sim::Hold;
use bracketry_symbolic::{Expr, Function, Symbol, Tape};
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};

use crate::chain::runge_kutta;
use crate::chained::values;
use crate::problem::{Outcome, Planned, Problem};
use crate::roll_out::distance;
use crate::signals::Signals;
use crate::steering::{Plan, SteerReason};

/// Steps of the motion, and rows of its inputs.
const STEPS: usize = 600;
/// Durations that are tried where none is asked for, s.
const DURATIONS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Limits of the dynamic extension.
const INTEGRATORS: usize = 6;
const NODES: usize = 60_000;
/// A motion whose end is farther away than this, relative to the size of the states, is not the one that was planned.
const BRANCH: f64 = 1e-2;

/// The extended system and its flat outputs, compiled.
struct Compiled {
    /// Of all states: y_i, …, y_i^(r_i − 1), one output after the other.
    derivatives: Tape,
    /// Of all states: the part of y_i^(r_i) free of inputs, then the decoupling matrix by rows.
    normal: Tape,
    /// Of all states and new inputs: rates, then the given inputs.
    motion: Tape,
    degrees: Vec<usize>,
    states: usize,
    inputs: usize,
}

/// Plans polynomials in flat outputs.
pub(crate) fn plan(problem: &Problem, mode: &ModeFields, system: &mut System) -> Outcome {
    let m = system.inputs.len();
    let mut known: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    known.retain(|&h| !system.inputs.iter().any(|&u| system.pool.depends_on(h, u)));
    let mut evidence = Evidence::default();
    let inputs = system.inputs.clone();
    let outputs = mode
        .fields
        .flat_outputs(&mut system.pool, &inputs, &known, &mut evidence)
        .map_err(SteerReason::Undecided)?
        .ok_or(SteerReason::NoFlatOutputs)?;
    let limits = ExtensionLimits { integrators: INTEGRATORS, nodes: NODES };
    let extension = mode
        .fields
        .dynamic_extension(&mut system.pool, &outputs, &inputs, limits, &mut evidence)
        .map_err(SteerReason::Undecided)?
        .filter(DynamicExtension::linearizes)
        .ok_or(SteerReason::NoFlatOutputs)?;
    let compiled = compiled(system, &extension).ok_or(SteerReason::NoFlatOutputs)?;
    let ends = [
        (&problem.options.from, problem.options.from_inputs.clone()),
        (&problem.options.to, problem.options.to_inputs.clone()),
    ];
    let mut extended = Vec::new();
    for (x, u) in ends {
        let u = u.or_else(|| resting_inputs(system, x)).unwrap_or_else(|| vec![0.0; m]);
        extended.push(compiled.with_compensator(x, &u));
    }
    let durations = problem.options.duration.map_or(DURATIONS.to_vec(), |t| vec![t]);
    let mut best = None;
    for duration in durations {
        if problem.is_over() {
            return Err(SteerReason::Stopped);
        }
        let Some(signals) = compiled.inputs_over(&extended[0], &extended[1], duration) else { continue };
        let fits = problem.ranges.left_by(&signals).is_none();
        best = Some(signals);
        if fits {
            break;
        }
    }
    let signals = best.ok_or(SteerReason::Singular)?;
    let outputs = Function::list(&system.pool, &outputs);
    let degrees = compiled.degrees.iter().map(|r| 2 * r - 1).collect();
    let plan = Plan::Flat { outputs, integrators: extension.added.len(), degrees };
    Ok(vec![Planned { signals, plan }])
}

fn compiled(system: &System, extension: &DynamicExtension) -> Option<Compiled> {
    let fields = &extension.fields;
    let degrees: Vec<usize> = extension.degrees.degrees.iter().copied().collect::<Option<_>>()?;
    let mut scratch = system.clone();
    let pool = &mut scratch.pool;
    let new: Vec<Expr> = extension.new_inputs.iter().map(|&u| pool.sym(u)).collect();
    let mut motion: Vec<Expr> = Vec::new();
    for i in 0..fields.states.len() {
        let mut rate = fields.drift[i];
        for (g, &u) in fields.controls.iter().zip(&new) {
            let term = pool.mul(g[i], u);
            rate = pool.add(rate, term);
        }
        motion.push(rate);
    }
    motion.extend(&extension.inputs);
    let all: Vec<Symbol> = fields.states.iter().chain(&extension.new_inputs).copied().collect();
    let mut normal = extension.degrees.drift.clone();
    normal.extend(extension.degrees.decoupling.iter().flatten());
    Some(Compiled {
        derivatives: scratch.compile(&fields.states, &extension.degrees.derivatives.concat()).ok()?,
        normal: scratch.compile(&fields.states, &normal).ok()?,
        motion: scratch.compile(&all, &motion).ok()?,
        degrees,
        states: fields.states.len(),
        inputs: system.inputs.len(),
    })
}

/// The inputs at which the state rests, or moves least: f + G u is smallest.
pub(crate) fn resting_inputs(system: &System, x: &[f64]) -> Option<Vec<f64>> {
    let arguments: Vec<Symbol> = system.states.iter().chain(&system.inputs).copied().collect();
    let tape = system.compile(&arguments, &system.dynamics).ok()?;
    let mut rates = |u: &DVector<f64>| {
        let at: Vec<f64> = x.iter().chain(u).copied().collect();
        Some(DVector::from_vec(values(&tape, &at)))
    };
    let found = minimize(&mut rates, &DVector::zeros(system.inputs.len()), &newton(20, 1e-6))?;
    (found.status != Status::NoDerivative).then(|| found.at.as_slice().to_vec())
}

/// Newton's method, damped where it does not help.
fn newton(iterations: usize, rank: f64) -> Settings {
    Settings { damping: Damping { undamped: 1e-3, ..Damping::default() }, iterations, rank, ..Settings::default() }
}

impl Compiled {
    /// The state with values of the added states for which the inputs are those given.
    fn with_compensator(&self, x: &[f64], inputs: &[f64]) -> Vec<f64> {
        let all = |z: &DVector<f64>| -> Vec<f64> { x.iter().chain(z).copied().collect() };
        let mut gap = |z: &DVector<f64>| {
            let at: Vec<f64> = all(z).into_iter().chain(vec![0.0; self.inputs]).collect();
            let out = values(&self.motion, &at);
            Some(DVector::from_iterator(self.inputs, out[self.states..].iter().zip(inputs).map(|(a, b)| a - b)))
        };
        let start = DVector::zeros(self.states - x.len());
        let settings = Settings { enough: 1e-13, ..newton(30, 1e-7) };
        all(&minimize(&mut gap, &start, &settings).map_or(start, |found| found.at))
    }

    /// The given inputs over time; `None` where the decoupling matrix becomes singular on the way.
    fn inputs_over(&self, from: &[f64], to: &[f64], duration: f64) -> Option<Signals> {
        let (start, end) = (values(&self.derivatives, from), values(&self.derivatives, to));
        let mut polynomials = Vec::new();
        let mut first = 0;
        for &r in &self.degrees {
            polynomials.push(hermite(&start[first..first + r], &end[first..first + r], duration)?);
            first += r;
        }
        let highest = |t: f64| -> Vec<f64> {
            polynomials
                .iter()
                .zip(&self.degrees)
                .map(|(p, &r)| derivative(p, r, t / duration) / duration.powi(r as i32))
                .collect()
        };
        let new_inputs = |t: f64, x: &[f64]| -> Option<Vec<f64>> {
            let out = values(&self.normal, x);
            let (drift, matrix) = out.split_at(self.inputs);
            let right = DVector::from_iterator(self.inputs, highest(t).iter().zip(drift).map(|(y, b)| y - b));
            let a = DMatrix::from_row_slice(self.inputs, self.inputs, matrix);
            let v = solve_vector(a, &right)?;
            v.iter().all(|v| v.is_finite()).then(|| v.iter().copied().collect())
        };
        let evaluate = |t: f64, x: &[f64]| -> Vec<f64> {
            let Some(v) = new_inputs(t, x) else { return vec![f64::NAN; self.states + self.inputs] };
            let at: Vec<f64> = x.iter().copied().chain(v).collect();
            values(&self.motion, &at)
        };
        let h = duration / STEPS as f64;
        let mut x = from.to_vec();
        let mut signals = Signals { times: Vec::new(), values: Vec::new(), hold: Hold::Linear };
        for i in 0..=STEPS {
            let t = i as f64 * h;
            let u = evaluate(t, &x)[self.states..].to_vec();
            if !u.iter().all(|v| v.is_finite()) {
                return None;
            }
            signals.times.push(t);
            signals.values.push(u);
            if i < STEPS {
                x = runge_kutta(t, &x, h, |t, x| evaluate(t, x)[..self.states].to_vec());
            }
        }
        let size = to.iter().chain(from).fold(1.0f64, |m, v| m.max(v.abs()));
        (distance(&x, to) < BRANCH * size).then_some(signals)
    }
}

/// The polynomial of degree 2r − 1 in s = t/T with the given derivatives in t, of order 0 to r − 1, at both ends.
fn hermite(start: &[f64], end: &[f64], duration: f64) -> Option<Vec<f64>> {
    let r = start.len();
    let scaled = |list: &[f64], k: usize| list[k] * duration.powi(k as i32);
    let factor = |i: usize, k: usize| ((i + 1 - k)..=i).map(|j| j as f64).product::<f64>();
    let mut polynomial: Vec<f64> = (0..r).map(|k| scaled(start, k) / factor(k, k)).collect();
    // The rest of the coefficients from the derivatives at s = 1.
    let matrix = DMatrix::from_fn(r, r, |k, i| factor(r + i, k));
    let right = DVector::from_fn(r, |k, _| {
        let known: f64 = (k..r).map(|i| polynomial[i] * factor(i, k)).sum();
        scaled(end, k) - known
    });
    let rest = solve_vector(matrix, &right)?;
    polynomial.extend(rest.iter());
    polynomial.iter().all(|c| c.is_finite()).then_some(polynomial)
}

/// The derivative of order k at s.
fn derivative(polynomial: &[f64], k: usize, s: f64) -> f64 {
    let term = |i: usize| ((i + 1 - k)..=i).map(|j| j as f64).product::<f64>() * polynomial[i] * s.powi((i - k) as i32);
    (k..polynomial.len()).map(term).sum()
}
