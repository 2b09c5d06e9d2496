//! What a delay and a first-order lag do to the samples of an input.

use crate::signal::Signal;
use bracketry_sim::{Hold, InputError, Samples};

/// The part of an input's samples that a window needs, delayed and lagged.
///
/// A delay shifts the times. A lag `τ y' = u − y` is solved exactly at the samples, from rest (`y = u`) at `history`, the first
/// sample that may be used. Between samples a held input stays held, at the mean of `y` over the interval, so that the
/// impulse is exact for every `τ`, also far below the sampling time, and depends smoothly on `τ` at 0; a linear one is joined
/// by straight lines.
///
/// `history..=last` are samples without a gap; the window starts at time `start`, and `lag_history` lags before it are enough.
pub(super) fn through_path(
    times: &[f64],
    signal: &Signal,
    (history, last): (usize, usize),
    start: f64,
    (delay, lag): (f64, f64),
    lag_history: f64,
) -> Result<Samples, InputError> {
    let needed = start - delay - lag_history * lag;
    let first = (history + times[history..=last].partition_point(|&t| t <= needed)).saturating_sub(1).max(history);
    let mut kept: Vec<f64> = times[first..=last].to_vec();
    let mut values: Vec<f64> = signal.values[first..=last].to_vec();
    if lag > 0.0 {
        values = lagged(&kept, &values, signal.hold, lag, values[0]);
    }
    if delay != 0.0 {
        for t in &mut kept {
            *t += delay;
        }
    }
    Samples::new(kept, values, signal.hold)
}

/// The samples of a signal behind a first-order lag that shows `start` at the first of them, see [`through_path`].
pub(crate) fn lagged(times: &[f64], u: &[f64], hold: Hold, lag: f64, start: f64) -> Vec<f64> {
    let n = u.len();
    let mut y = start;
    let mut out = Vec::with_capacity(n);
    for k in 0..n {
        if k + 1 == n {
            // Beyond the last sample only the value there is known.
            out.push(y);
            break;
        }
        let dt = times[k + 1] - times[k];
        let decay = (-dt / lag).exp();
        match hold {
            Hold::Previous => {
                // The mean of u + (y − u) e^{-t/τ}.
                out.push(u[k] + (y - u[k]) * (1.0 - decay) * lag / dt);
                y = u[k] + (y - u[k]) * decay;
            }
            Hold::Linear => {
                out.push(y);
                let slope = (u[k + 1] - u[k]) / dt;
                let steady = u[k] - lag * slope;
                y = steady + slope * dt + (y - steady) * decay;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn sampled(u: impl Fn(f64) -> f64, hold: Hold) -> (Vec<f64>, Signal) {
        let times: Vec<f64> = (0..2001).map(|k| k as f64 * 1e-3).collect();
        let values = times.iter().map(|&t| u(t)).collect();
        (times, Signal { values, hold })
    }

    #[test]
    fn the_lag_of_a_ramp_is_the_ramp_later_by_tau() {
        let (times, ramp) = sampled(|t| 3.0 * t, Hold::Linear);
        for lag in [1e-5, 4e-4, 7e-3] {
            let y = lagged(&times, &ramp.values, Hold::Linear, lag, 0.0);
            for k in [1500, 1999] {
                assert!((y[k] - 3.0 * (times[k] - lag)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_lag_keeps_the_impulse_of_a_held_pulse() {
        let (times, pulse) = sampled(|t| if (0.1..0.2).contains(&t) { 5.0 } else { 0.0 }, Hold::Previous);
        for lag in [1e-6, 3e-4, 1e-2] {
            let y = lagged(&times, &pulse.values, Hold::Previous, lag, 0.0);
            let impulse: f64 = y[..2000].iter().sum::<f64>() * 1e-3;
            assert!((impulse - 5.0 * pulse.values.iter().filter(|v| **v > 0.0).count() as f64 * 1e-3).abs() < 1e-12);
        }
    }

    #[test]
    fn the_history_that_is_left_out_has_no_influence() {
        let (times, signal) = sampled(|t| (7.0 * t).sin(), Hold::Previous);
        let whole = lagged(&times, &signal.values, Hold::Previous, 5e-3, 0.0);
        let part = through_path(&times, &signal, (0, 2000), 1.5, (0.0, 5e-3), 40.0).unwrap();
        let from_rest = Samples::new(times, whole, Hold::Previous).unwrap();
        let system =
            bracketry_system::System::parse("m", "states = ['v']\ninputs = ['u']\n[dynamics]\nv = 'u'").unwrap();
        let at = |samples| {
            let inputs = bracketry_sim::Inputs::new().samples("u", samples);
            bracketry_sim::Model::new(&system, &inputs).unwrap().input_values(1.7)[0]
        };
        assert!((at(part) - at(from_rest)).abs() < 1e-14);
    }
}
