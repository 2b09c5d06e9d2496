//! Newton steps on inputs that remove what is left of the end error.

use bracketry_numerics::least_squares::{Factored, central_differences};
use nalgebra::DVector;

use crate::problem::Problem;
use crate::roll_out::{RollOut, distance};
use crate::signals::Signals;
use bracketry_sim::Hold;

/// Jacobians that are formed, and steps with each.
const JACOBIANS: usize = 6;
const STEPS: usize = 4;
/// Most amplitudes that are changed.
const MAX_SHAPES: usize = 80;
/// Change of an amplitude in a difference quotient, relative to the size of the input.
const DIFFERENCE: f64 = 1e-4;
/// Singular values below this part of the largest are taken for zero.
const RANK: f64 = 1e-8;
/// Damping of the steps that are tried, relative to the square of the largest singular value.
const DAMPING: [f64; 7] = [0.0, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0];
/// Below this the end error is rounding of the simulation.
const FLOOR: f64 = 1e-10;

/// A change of the inputs: weights of one input at some rows.
struct Shape {
    input: usize,
    rows: Vec<(usize, f64)>,
}

/// Sines of the whole motion for inputs along straight lines; for inputs held constant each piece by itself, so that pieces of
/// zero stay zero.
fn shapes(signals: &Signals, states: usize) -> Vec<Shape> {
    let (inputs, rows) = (signals.values[0].len(), signals.times.len());
    if signals.hold == Hold::Previous {
        let moving: Vec<(usize, usize)> = (0..rows - 1)
            .flat_map(|k| (0..inputs).map(move |j| (k, j)))
            .filter(|&(k, j)| signals.values[k][j] != 0.0)
            .collect();
        let every = moving.len().div_ceil(MAX_SHAPES).max(1);
        return moving.into_iter().step_by(every).map(|(k, input)| Shape { input, rows: vec![(k, 1.0)] }).collect();
    }
    let duration = signals.duration();
    let mut list = Vec::new();
    for input in 0..inputs {
        for k in 1..=(states + 1).min(MAX_SHAPES / inputs.max(1)) {
            let weight = |t: f64| (k as f64 * std::f64::consts::PI * t / duration).sin();
            list.push(Shape { input, rows: (0..rows).map(|i| (i, weight(signals.times[i]))).collect() });
        }
    }
    list
}

fn changed(signals: &Signals, shapes: &[Shape], amounts: &[f64]) -> Signals {
    let mut new = signals.clone();
    for (shape, amount) in shapes.iter().zip(amounts).filter(|(_, amount)| **amount != 0.0) {
        for &(row, weight) in &shape.rows {
            new.values[row][shape.input] += amount * weight;
        }
    }
    new
}

/// Inputs with a smaller end error, that error, and the steps that were taken; as they were where nothing helps.
pub(crate) fn corrected(
    problem: &Problem,
    plant: &mut RollOut,
    signals: Signals,
    mut error: f64,
) -> (Signals, f64, usize) {
    let (from, to) = (&problem.options.from, &problem.options.to);
    let mut best = signals;
    let mut taken = 0;
    for _ in 0..JACOBIANS {
        if error <= FLOOR || !error.is_finite() || problem.is_over() {
            break;
        }
        let before = error;
        let shapes = shapes(&best, to.len());
        let Some((factored, sizes)) = jacobian(problem, plant, &best, &shapes) else { break };
        for _ in 0..STEPS {
            let Some(end) = plant.end(from, &best) else { break };
            let gap = DVector::from_fn(to.len(), |i, _| to[i] - end[i]);
            let mut moved = false;
            for damping in DAMPING {
                let step = factored.solve(&gap, damping * factored.largest().powi(2));
                let amounts: Vec<f64> = step.iter().zip(&sizes).map(|(s, size)| s * size).collect();
                let next = changed(&best, &shapes, &amounts);
                let Some(reached) = plant.end(from, &next).map(|x| distance(&x, to)) else { continue };
                if reached < error {
                    (best, error, moved) = (next, reached, true);
                    taken += 1;
                    break;
                }
            }
            if !moved || error <= FLOOR {
                break;
            }
        }
        if error > 0.5 * before {
            break;
        }
    }
    (best, error, taken)
}

/// The derivative of the end by the amplitudes of the shapes, each relative to the size of its input.
fn jacobian(
    problem: &Problem,
    plant: &mut RollOut,
    signals: &Signals,
    shapes: &[Shape],
) -> Option<(Factored, Vec<f64>)> {
    if shapes.is_empty() {
        return None;
    }
    let from = &problem.options.from;
    let overall = (0..signals.values[0].len()).map(|j| signals.largest(j)).fold(1e-3, f64::max);
    let sizes: Vec<f64> = shapes
        .iter()
        .map(|s| {
            let own = signals.largest(s.input);
            if own > 0.0 { own } else { overall }
        })
        .collect();
    let end = |amounts: &DVector<f64>| {
        if problem.is_over() {
            return Err(());
        }
        let amounts: Vec<f64> = amounts.iter().zip(&sizes).map(|(a, size)| a * size).collect();
        plant.end(from, &changed(signals, shapes, &amounts)).map(DVector::from_vec).ok_or(())
    };
    let jacobian = central_differences(end, &DVector::zeros(shapes.len()), DIFFERENCE).ok()?;
    Some((Factored::new(&jacobian, RANK)?, sizes))
}
