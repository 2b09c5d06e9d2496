//! Whether columns fit each other: a position and its velocity, angles in radians.

use bracketry_symbolic::{Func, Node};
use bracketry_system::{FileError, System};

use super::origin::Origin;
use super::warning::Warning;
use crate::settings::ConsistencySettings;
use crate::{Quantity, Record};

/// Slopes of other units, and what they mean.
const UNITS: [(f64, &str); 10] = [
    (1e3, "one of them is in thousandths: millimeters, or t in kiloseconds"),
    (1e-3, "one of them is in thousandths: millimeters per second, or t in milliseconds"),
    (57.295_779_513, "it is in degrees"),
    (0.017_453_292_5, "its rate is in degrees per second"),
    (0.104_719_755, "its rate is in turns per minute"),
    (0.159_154_943, "it is in turns"),
    (60.0, "t is in seconds and the rate per minute, or t in minutes and the model in hours"),
    (1.0 / 60.0, "t is in minutes and the rate per second, or t in hours and the model in minutes"),
    (3600.0, "t is in seconds and the rate per hour"),
    (1.0 / 3600.0, "t is in hours and the rate per second"),
];

/// The other unit whose slope is nearest.
fn nearest(slope: f64) -> Option<&'static (f64, &'static str)> {
    let distance = |factor: f64| (slope / factor).ln().abs();
    UNITS.iter().min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)))
}

/// Compares every measured state whose time derivative is another measured state with the integral of that one.
///
/// # Errors
/// [`FileError`] where they differ by the factor of another unit.
pub(super) fn check_rates(
    origin: &Origin<'_>,
    record: &Record,
    system: &System,
    settings: &ConsistencySettings,
) -> Result<Vec<Warning>, FileError> {
    let mut warnings = Vec::new();
    for (state, rate) in system.dynamics.iter().enumerate() {
        let Node::Sym(rate) = system.pool.node(*rate) else {
            continue;
        };
        let Some(rate_state) = system.states.iter().position(|s| *s == rate) else {
            continue;
        };
        let (Some((position, noise)), Some((rates, rate_noise))) =
            (measured(record, state), measured(record, rate_state))
        else {
            continue;
        };
        let names = (system.symbol_name(system.states[state]), system.symbol_name(rate));
        if let Some((stuck, other)) = stuck(record, (position, noise), (rates, rate_noise), names, settings) {
            return Err(origin.whole(
                format!("`{stuck}` never changes, although `{other}` indicates motion"),
                format!("its sensor is dead, or the column has another meaning: remove the column `{stuck}`"),
            ));
        }
        let Some((slope, correlation)) = compare(record, position, noise, rates, settings) else {
            continue;
        };
        let (name, says) = (system.symbol_name(system.states[state]), system.symbol_name(rate));
        let near = |factor: f64| (slope / factor - 1.0).abs() < settings.calibration;
        if correlation.abs() < settings.least_correlation {
            warnings.push(Warning::Unrelated { name: name.to_owned(), rate: says.to_owned(), correlation });
        } else if slope < 0.0 {
            warnings.push(Warning::Reversed { name: name.to_owned(), rate: says.to_owned() });
        } else if let Some((_, meaning)) = nearest(slope).filter(|(factor, _)| near(*factor)) {
            return Err(origin.whole(
                format!("`{name}` moves {slope:.4} times as far as `{says}` indicates"),
                format!("{meaning}: convert to the units of the model"),
            ));
        } else if !near(1.0) {
            warnings.push(Warning::Scaled { name: name.to_owned(), rate: says.to_owned(), factor: slope });
        }
    }
    Ok(warnings)
}

/// Angles (what stands under a sine, cosine or tangent) that turn very far.
pub(super) fn check_angles(record: &Record, system: &System, settings: &ConsistencySettings) -> Vec<Warning> {
    let roots: Vec<_> = system.dynamics.iter().copied().chain(system.outputs.iter().map(|(_, e)| *e)).collect();
    let mut warnings = Vec::new();
    for e in system.pool.reachable(&roots) {
        let Node::Call(Func::Sin | Func::Cos | Func::Tan, argument) = system.pool.node(e) else {
            continue;
        };
        let Node::Sym(symbol) = system.pool.node(argument) else {
            continue;
        };
        let state = system.states.iter().position(|s| *s == symbol);
        let Some((values, _)) = state.and_then(|state| measured(record, state)) else {
            continue;
        };
        let largest = values.iter().filter(|v| v.is_finite()).map(|v| v.abs()).fold(0.0, f64::max);
        let warning = Warning::LargeAngle { name: system.symbol_name(symbol).to_owned(), largest };
        if largest > settings.most_turns * std::f64::consts::TAU && !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    warnings
}

/// Samples and noise of a measured state.
fn measured(record: &Record, state: usize) -> Option<(&[f64], f64)> {
    let column = record.measured.iter().find(|m| m.quantity == Quantity::State(state))?;
    Some((&column.values, column.noise))
}

/// Which of a position and its rate never changes although the other one says that it does, and the name of that one: what
/// moves is significant above the noise as displacement over parts of the run.
fn stuck<'a>(
    record: &Record,
    (position, noise): (&[f64], f64),
    (rates, rate_noise): (&[f64], f64),
    (name, rate): (&'a str, &'a str),
    settings: &ConsistencySettings,
) -> Option<(&'a str, &'a str)> {
    let constant = |values: &[f64]| values.windows(2).all(|pair| pair[0] == pair[1]);
    let (still, resting) = (constant(position), constant(rates));
    if still == resting {
        return None;
    }
    let mean =
        rates.iter().filter(|v| v.is_finite()).sum::<f64>() / rates.iter().filter(|v| v.is_finite()).count() as f64;
    let length = (position.len() / settings.displacements).max(4);
    let (mut moved, mut of_noise, mut count) = (0.0, 0.0, 0);
    for start in (0..position.len().saturating_sub(length)).step_by(length) {
        let end = start + length;
        if record.gaps.iter().any(|gap| (start + 1..=end).contains(gap)) {
            continue;
        }
        let duration = record.times[end] - record.times[start];
        let (displacement, variance) = if still {
            // An offset of the rate's sensor is no motion.
            let integral: f64 = (start..end)
                .map(|k| (0.5 * (rates[k] + rates[k + 1]) - mean) * (record.times[k + 1] - record.times[k]))
                .sum();
            (integral, rate_noise * rate_noise * duration * duration / length as f64)
        } else {
            (position[end] - position[start] - mean * duration, 2.0 * noise * noise)
        };
        if displacement.is_finite() {
            moved += displacement * displacement;
            of_noise += variance;
            count += 1;
        }
    }
    let moves = count >= 8 && moved > settings.significant_displacement.powi(2) * of_noise;
    moves.then_some(if still { (name, rate) } else { (rate, name) })
}

/// Regression of displacements on integrated rates over parts of the run: slope and correlation. None where neither stands
/// out of the noise.
fn compare(
    record: &Record,
    position: &[f64],
    noise: f64,
    rates: &[f64],
    settings: &ConsistencySettings,
) -> Option<(f64, f64)> {
    let n = position.len();
    let length = (n / settings.displacements).max(4);
    let (mut dd, mut di, mut ii, mut count) = (0.0, 0.0, 0.0, 0.0);
    for start in (0..n.saturating_sub(length)).step_by(length) {
        let end = start + length;
        if record.gaps.iter().any(|gap| (start + 1..=end).contains(gap)) {
            continue;
        }
        let integral: f64 =
            (start..end).map(|k| 0.5 * (rates[k] + rates[k + 1]) * (record.times[k + 1] - record.times[k])).sum();
        let displacement = position[end] - position[start];
        if integral.is_finite() && displacement.is_finite() {
            dd += displacement * displacement;
            di += displacement * integral;
            ii += integral * integral;
            count += 1.0;
        }
    }
    let moves = dd > settings.significant_displacement.powi(2) * 2.0 * noise * noise * count;
    (count >= 8.0 && moves && ii > 0.0).then(|| (di / ii, di / (dd * ii).sqrt()))
}
