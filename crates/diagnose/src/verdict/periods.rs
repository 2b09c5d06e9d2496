//! Periods worth trying: where the residual of the refitted model repeats.

use std::f64::consts::TAU;

use bracketry_symbolic::Node;
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::library::TIME_INPUT;
use crate::settings::PeriodSettings;
use crate::{Cause, Effect, Fit, Quantity, Record, Study, Window};

/// What a force wave does to a measured column while the rest of the dynamics is left alone.
#[derive(Clone, Copy)]
enum Response {
    /// The column is the rate: the wave is integrated once.
    Rate,
    /// The column is the position: the wave is integrated twice.
    Position,
}

/// Gives disturbances that repeat in a position or in time the periods at which the residual of a fit without effects has
/// the highest peaks of its periodogram.
///
/// A period tells itself only within half a cycle over all the data, so that a few fixed trials would miss most. The
/// periodogram is that of least squares (Lomb 1976): per window the residual is put
/// against the sine and the cosine, integrated from the force to the column, with the initial state's part taken out.
pub(super) fn tune(study: &Study, fit: &Fit, effects: &mut [Effect], settings: &PeriodSettings) {
    let system = study.system();
    for effect in effects.iter_mut().filter(|e| e.cause == Cause::PeriodicDisturbance) {
        let Some(period) = effect.coefficients.iter_mut().find(|c| c.period_of.is_some()) else { continue };
        let Some(along) = &period.period_of else { continue };
        let peaks = peaks(&lanes(system, study, fit, &effect.equation, along), settings);
        let (Some(&first), Some(shortest)) = (peaks.first(), peaks.iter().copied().reduce(f64::min)) else { continue };
        period.nominal = first;
        period.scale = first;
        period.min = 0.1 * shortest;
        period.trials = peaks;
    }
}

/// One window of one measured column.
struct Lane {
    response: Response,
    /// Residual over noise; NaN where lost.
    residual: Vec<f64>,
    /// Position, or time, at each sample.
    phase: Vec<f64>,
    times: Vec<f64>,
    noise: f64,
}

fn lanes(system: &System, study: &Study, fit: &Fit, rate: &str, along: &str) -> Vec<Lane> {
    let Some(rate) = system.state_index(rate) else { return Vec::new() };
    let position =
        system.dynamics.iter().position(|&f| matches!(system.pool.node(f), Node::Sym(s) if s == system.states[rate]));
    let mut lanes = Vec::new();
    for window in &fit.windows {
        let Some(&Window { record: index, from, to }) = study.windows().get(window.window) else { continue };
        let record = &study.records()[index];
        let Some(phase) = values(system, record, along).map(|v| v[from..to].to_vec()) else { continue };
        for (c, residual) in window.residuals.iter().enumerate() {
            let response = match record.measured[c].quantity {
                Quantity::State(i) if i == rate => Response::Rate,
                Quantity::State(i) if Some(i) == position => Response::Position,
                _ => continue,
            };
            if residual.len() == to - from && phase.iter().all(|v| v.is_finite()) {
                let (residual, phase, times) = (residual.clone(), phase.clone(), record.times[from..to].to_vec());
                lanes.push(Lane { response, residual, phase, times, noise: study.noise()[index][c] });
            }
        }
    }
    lanes
}

/// The times, or what was measured of a state.
fn values<'a>(system: &System, record: &'a Record, name: &str) -> Option<&'a [f64]> {
    if name == TIME_INPUT {
        return Some(&record.times);
    }
    let state = system.state_index(name)?;
    record.measured.iter().find(|m| m.quantity == Quantity::State(state)).map(|m| &m.values[..])
}

/// Periods of the highest peaks, the highest first.
fn peaks(lanes: &[Lane], settings: &PeriodSettings) -> Vec<f64> {
    let (per_cycle, finer) = (settings.steps_per_cycle, settings.finer_steps);
    let all = || lanes.iter().flat_map(|l| &l.phase).copied();
    let range = all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min);
    if range.is_nan() || range <= 0.0 {
        return Vec::new();
    }
    let at = |cycles: f64| power(lanes, range / cycles);
    let step = 1.0 / per_cycle as f64;
    let steps = per_cycle..=settings.most_cycles * per_cycle;
    let coarse: Vec<f64> = steps.into_par_iter().map(|k| at(step * k as f64)).collect();
    let beside = |i: Option<usize>| i.and_then(|i| coarse.get(i)).copied().unwrap_or(f64::NEG_INFINITY);
    let mut highest: Vec<usize> = (0..coarse.len())
        .filter(|&i| coarse[i] > beside(i.checked_sub(1)) && coarse[i] >= beside(i.checked_add(1)))
        .collect();
    highest.sort_by(|&a, &b| coarse[b].total_cmp(&coarse[a]));
    highest.truncate(settings.most_refined_peaks);
    let mut crests: Vec<(f64, f64)> = highest
        .into_par_iter()
        .map(|i| {
            let middle = step * (i + per_cycle) as f64;
            (0..2 * finer)
                .map(|j| middle + step * (j as f64 / finer as f64 - 1.0))
                .map(|cycles| (cycles, if cycles == middle { coarse[i] } else { at(cycles) }))
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or((middle, coarse[i]))
        })
        .collect();
    crests.sort_by(|a, b| b.1.total_cmp(&a.1));
    // Two neighbors may have climbed the same crest from both sides.
    let mut periods: Vec<f64> = Vec::new();
    for (cycles, _) in crests {
        if periods.iter().all(|p| (range / p - cycles).abs() > 0.5 * step) {
            periods.push(range / cycles);
        }
    }
    periods.truncate(settings.most_periods);
    periods
}

/// The decrease of the sum of squares by a wave of a period.
fn power(lanes: &[Lane], period: f64) -> f64 {
    let mut gram = DMatrix::zeros(2, 2);
    let mut gradient = DVector::zeros(2);
    for lane in lanes {
        let Some((g, h)) = lane.normal(period) else { continue };
        gram += g;
        gradient += h;
    }
    let solved = gram.cholesky().map(|c| c.solve(&gradient));
    solved.map_or(0.0, |step| step.dot(&gradient))
}

impl Lane {
    /// Normal equations of the sine's and the cosine's amplitude with the initial state eliminated.
    fn normal(&self, period: f64) -> Option<(DMatrix<f64>, DVector<f64>)> {
        // Columns: the initial state's part (1, t), then sine and cosine.
        let states = match self.response {
            Response::Rate => 1,
            Response::Position => 2,
        };
        let n = states + 2;
        let mut gram = DMatrix::<f64>::zeros(n, n);
        let mut gradient = DVector::<f64>::zeros(n);
        let duration = (self.times.last()? - self.times.first()?).max(f64::MIN_POSITIVE);
        let mut force = [0.0; 2];
        let (mut rate, mut position) = ([0.0; 2], [0.0; 2]);
        for k in 0..self.phase.len() {
            if k > 0 {
                let dt = self.times[k] - self.times[k - 1];
                for i in 0..2 {
                    position[i] += dt * (rate[i] + 0.5 * dt * force[i]);
                    rate[i] += dt * force[i];
                }
            }
            let (sin, cos) = (TAU * self.phase[k] / period).sin_cos();
            force = [sin, cos];
            let r = self.residual[k];
            if r.is_nan() {
                continue;
            }
            let moved = if states == 1 { rate } else { position };
            let row = [1.0, (self.times[k] - self.times[0]) / duration, moved[0] / self.noise, moved[1] / self.noise];
            let place = |i: usize| if i < states { row[i] } else { row[2 + i - states] };
            for i in 0..n {
                gradient[i] += place(i) * r;
                for j in 0..n {
                    gram[(i, j)] += place(i) * place(j);
                }
            }
        }
        // Schur complement of the initial state.
        let own = gram.view((0, 0), (states, states)).into_owned().cholesky()?;
        let across = gram.view((0, states), (states, 2)).into_owned();
        let reduced = gram.view((states, states), (2, 2)) - across.transpose() * own.solve(&across);
        let left = gradient.rows(states, 2) - across.transpose() * own.solve(&gradient.rows(0, states).into_owned());
        Some((reduced, left))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Windows of a position that goes up and down, pushed by a force that repeats every `period`.
    fn pushed(period: f64, strength: f64) -> Vec<Lane> {
        let dt = 1e-3;
        (0..40)
            .map(|w| {
                let times: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(w) + dt * f64::from(k)).collect();
                let phase: Vec<f64> = times.iter().map(|t| 0.3 * (1.7 * t).sin()).collect();
                let (mut v, mut x) = (0.1, 0.0);
                let residual = phase
                    .iter()
                    .map(|q| {
                        let here = x;
                        x += dt * v;
                        v += dt * strength * (TAU * q / period + 0.4).sin();
                        here + 0.02
                    })
                    .collect();
                Lane { response: Response::Position, residual, phase, times, noise: 1.0 }
            })
            .collect()
    }

    #[test]
    fn the_highest_peak_is_the_period_of_the_force() {
        let settings = PeriodSettings::default();
        for period in [0.013, 0.0603, 0.21] {
            let found = peaks(&pushed(period, 2.0), &settings)[0];
            // Half a step of frequency over the range of 0.6.
            assert!(
                (0.6 / found - 0.6 / period).abs() <= 0.5 / settings.steps_per_cycle as f64 + 0.05,
                "{period}: {found}"
            );
        }
    }

    #[test]
    fn a_state_that_does_not_move_tells_no_period() {
        let mut still = pushed(0.06, 1.0);
        for lane in &mut still {
            lane.phase.fill(0.1);
        }
        assert!(peaks(&still, &PeriodSettings::default()).is_empty());
    }
}
