//! First guesses of initial states, and typical sizes of the states.

use super::window::Window;
use crate::record::Record;
use crate::signal::Quantity;
use bracketry_numerics::eigen::svd;
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};

/// Where a first guess of a state comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// A measured column.
    Value(usize),
    /// The slope of a measured column.
    Slope(usize),
    /// Nothing: zero.
    Nowhere,
}

/// First guesses of initial states of one record.
#[derive(Clone, Debug)]
pub(super) struct Guess {
    origins: Vec<Origin>,
    /// Typical size of each state.
    pub(super) scales: Vec<f64>,
}

impl Guess {
    /// A state is guessed from its own column, or from the slope of the column of a state whose time derivative it is.
    pub(super) fn new(system: &System, record: &Record, fewest: usize) -> Self {
        let column_of = |state: usize| record.measured.iter().position(|m| m.quantity == Quantity::State(state));
        let mut pool = system.pool.clone();
        let origins: Vec<Origin> = (0..system.states.len())
            .map(|i| {
                if let Some(column) = column_of(i) {
                    return Origin::Value(column);
                }
                let this = pool.sym(system.states[i]);
                let integral = (0..system.states.len()).filter(|&j| system.dynamics[j] == this).find_map(column_of);
                integral.map_or(Origin::Nowhere, Origin::Slope)
            })
            .collect();
        let scales = origins.iter().map(|o| scale(record, *o, fewest)).collect();
        Self { origins, scales }
    }

    /// The initial state at the first sample of a window.
    pub(super) fn at(&self, record: &Record, window: Window) -> Vec<f64> {
        let samples = ((window.to - window.from) / 5).max(6).min(window.to - window.from);
        self.origins
            .iter()
            .map(|origin| match *origin {
                Origin::Value(column) => local(record, column, window.from, samples).map_or(0.0, |p| p.0),
                Origin::Slope(column) => local(record, column, window.from, samples).map_or(0.0, |p| p.1),
                Origin::Nowhere => 0.0,
            })
            .collect()
    }
}

fn scale(record: &Record, origin: Origin, fewest: usize) -> f64 {
    let rms = |values: &[f64]| {
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt()
    };
    let size = match origin {
        Origin::Value(column) => {
            let known: Vec<f64> = record.measured[column].values.iter().copied().filter(|v| v.is_finite()).collect();
            rms(&known)
        }
        Origin::Slope(column) => {
            let slopes: Vec<f64> = (0..record.times.len().saturating_sub(fewest))
                .step_by(fewest.max(1))
                .filter_map(|from| local(record, column, from, fewest).map(|p| p.1))
                .filter(|v| v.is_finite())
                .collect();
            rms(&slopes)
        }
        Origin::Nowhere => 1.0,
    };
    if size > 0.0 && size.is_finite() { size } else { 1.0 }
}

/// Value and slope at the first of `samples` samples, of the parabola through them in the least-squares sense.
fn local(record: &Record, column: usize, from: usize, samples: usize) -> Option<(f64, f64)> {
    let to = (from + samples).min(record.times.len());
    let values = &record.measured[column].values;
    let t0 = record.times[from];
    let span = record.times[to - 1] - t0;
    let known: Vec<usize> = (from..to).filter(|&k| values[k].is_finite()).collect();
    let terms = known.len().min(3);
    if terms == 0 || span <= 0.0 {
        return known.first().map(|&k| (values[k], 0.0));
    }
    let a = DMatrix::from_fn(known.len(), terms, |r, c| ((record.times[known[r]] - t0) / span).powi(c as i32));
    let b = DVector::from_iterator(known.len(), known.iter().map(|&k| values[k]));
    let solution = svd(&a)?.solve(&b, 1e-12).ok()?;
    Some((solution[0], if terms > 1 { solution[1] / span } else { 0.0 }))
}
