//! Steering by shooting: sinusoids whose amplitudes are found by Levenberg–Marquardt iterations on the end error of the model itself.
//!
//! No theorem says that it succeeds. It is for models with drift, friction, or inputs that enter nonlinearly.

use bracketry_numerics::least_squares::{self, Damping, Settings, minimize};
use bracketry_sim::Hold;
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use crate::flat::resting_inputs;
use crate::problem::{Outcome, Planned, Problem};
use crate::roll_out::{RollOut, distance};
use crate::signals::Signals;
use crate::steering::{Plan, SteerReason};

/// Rows of the inputs.
const ROWS: usize = 160;
/// Random starts for each duration, and iterations from each.
const STARTS: usize = 5;
const ITERATIONS: usize = 30;
/// Durations that are tried where none is asked for, s.
const DURATIONS: [f64; 4] = [1.0, 3.0, 8.0, 20.0];
/// Change of an amplitude in a difference quotient.
const DIFFERENCE: f64 = 1e-5;

struct Shot<'a> {
    problem: &'a Problem,
    inputs: usize,
    harmonics: usize,
    duration: f64,
    /// Values of the inputs at both ends.
    ends: [Vec<f64>; 2],
}

impl Shot<'_> {
    fn signals(&self, amplitudes: &DVector<f64>) -> Signals {
        let times: Vec<f64> = (0..=ROWS).map(|i| self.duration * i as f64 / ROWS as f64).collect();
        let value = |i: usize, j: usize| {
            let s = i as f64 / ROWS as f64;
            let line = self.ends[0][j] * (1.0 - s) + self.ends[1][j] * s;
            let sines: f64 = (0..self.harmonics)
                .map(|k| amplitudes[j * self.harmonics + k] * ((k + 1) as f64 * std::f64::consts::PI * s).sin())
                .sum();
            self.problem.ranges.clamped(j, line + sines)
        };
        let values = (0..=ROWS).map(|i| (0..self.inputs).map(|j| value(i, j)).collect()).collect();
        Signals { times, values, hold: Hold::Linear }
    }

    /// The iterations from one start: amplitudes and what is left of the end error.
    fn solve(&self, plant: &mut RollOut, start: &DVector<f64>) -> Option<(DVector<f64>, f64)> {
        let settings = Settings {
            damping: Damping { least: 1e-15, trials: 8, ..Damping::default() },
            iterations: ITERATIONS,
            enough: 0.1 * self.problem.options.tolerance,
            ..Settings::default()
        };
        let found = minimize(&mut EndError { shot: self, plant }, start, &settings)?;
        Some((found.at, found.residual.amax()))
    }
}

/// What is left to the end as a function of the amplitudes, as long as there is time.
struct EndError<'a> {
    shot: &'a Shot<'a>,
    plant: &'a mut RollOut,
}

impl least_squares::Problem for EndError<'_> {
    fn residual(&mut self, amplitudes: &DVector<f64>) -> Option<DVector<f64>> {
        let problem = self.shot.problem;
        if problem.is_over() {
            return None;
        }
        let end = self.plant.end(&problem.options.from, &self.shot.signals(amplitudes))?;
        Some(DVector::from_fn(end.len(), |i, _| problem.options.to[i] - end[i]))
    }

    /// By forward differences: half as many simulations as by central ones.
    fn jacobian(&mut self, at: &DVector<f64>, residual: &DVector<f64>) -> Option<DMatrix<f64>> {
        let columns: Option<Vec<DVector<f64>>> = (0..at.len())
            .map(|k| {
                let mut moved = at.clone();
                moved[k] += DIFFERENCE;
                Some((self.residual(&moved)? - residual) / DIFFERENCE)
            })
            .collect();
        Some(DMatrix::from_columns(&columns?))
    }
}

/// Plans by shooting.
pub(crate) fn plan(problem: &Problem, system: &System, plant: &mut RollOut) -> Outcome {
    let (n, m) = (system.states.len(), system.inputs.len());
    let harmonics = (n + 1).div_ceil(m).max(3) + 1;
    let rest = |x: &[f64], given: &Option<Vec<f64>>| {
        given.clone().or_else(|| resting_inputs(system, x)).unwrap_or_else(|| vec![0.0; m])
    };
    let options = &problem.options;
    let ends = [rest(&options.from, &options.from_inputs), rest(&options.to, &options.to_inputs)];
    let mut random = StdRng::seed_from_u64(options.seed);
    let (mut best, mut starts): (Option<(Signals, f64)>, usize) = (None, 0);
    let limits = (0..m).flat_map(|j| [problem.ranges.limit(j, true), problem.ranges.limit(j, false)]);
    let widest = limits.fold(0.0, f64::max);
    for duration in options.duration.map_or(DURATIONS.to_vec(), |t| vec![t]) {
        let shot = Shot { problem, inputs: m, harmonics, duration, ends: ends.clone() };
        for k in 0..STARTS {
            if problem.is_over() {
                break;
            }
            starts += 1;
            // Dry friction is overcome by large amplitudes alone.
            let size = [distance(&options.from, &options.to).max(0.1) / duration, 3.0, 15.0, 100.0, 700.0][k];
            if k > 0 && size > 3.0 * widest {
                continue;
            }
            let start = DVector::from_fn(m * harmonics, |_, _| size * random.random_range(-1.0..1.0));
            let Some((a, left)) = shot.solve(plant, &start) else { continue };
            if best.as_ref().is_none_or(|b| left < b.1) {
                best = Some((shot.signals(&a), left));
            }
            if left <= options.tolerance {
                break;
            }
        }
        if best.as_ref().is_some_and(|b| b.1 <= options.tolerance) {
            break;
        }
    }
    let stopped =
        || if problem.is_over() { SteerReason::Stopped } else { SteerReason::EndError { error: f64::INFINITY } };
    let (signals, _) = best.ok_or_else(stopped)?;
    Ok(vec![Planned { signals, plan: Plan::Shooting { harmonics, starts } }])
}
