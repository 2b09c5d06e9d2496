//! The noise of what is measured.

use crate::exact::Run;
use crate::options::{ExperimentError, ExperimentOptions};
use crate::setup::{Setup, unknown};
use serde::Serialize;

/// Noise of a column of which nothing is known, as a share of its range.
const SHARE: f64 = 0.01;
/// Least noise of a column, as a share of its range: smaller differences are errors of the simulation.
const LEAST: f64 = 1e-7;

/// The noise of a measured column.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnNoise {
    /// The column.
    pub column: String,
    /// Standard deviation, in its unit.
    pub std: f64,
    /// Where it comes from.
    pub source: NoiseSource,
}

/// Where the noise of a column comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseSource {
    /// It was given.
    Given,
    /// One percent of the width of the column's limits.
    Limits,
    /// One percent of the column's range under simple inputs of the same limits.
    Range,
    /// Nothing moves the column under simple inputs: 1 in its unit.
    Unknown,
}

impl NoiseSource {
    /// The source in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Limits => "assumed: 1 % of the width of its limits",
            Self::Range => "assumed: 1 % of its range under simple inputs of the same limits",
            Self::Unknown => "assumed: nothing moves it under simple inputs",
        }
    }
}

/// The noise of every column; `runs` are those of simple inputs.
pub(crate) fn noise(
    setup: &Setup,
    options: &ExperimentOptions,
    runs: &[Run],
) -> Result<Vec<ColumnNoise>, ExperimentError> {
    for (name, std) in &options.noise {
        if !setup.columns.contains(name) {
            return Err(unknown("--noise", name, "a measured column", &setup.columns));
        }
        if !(*std > 0.0 && std.is_finite()) {
            let what = format!("the noise of `{name}`");
            return Err(ExperimentError::Value { what, value: *std, remedy: "give a positive standard deviation" });
        }
    }
    let range = |k: usize| {
        let ranges = runs.iter().map(|run| {
            let values = run.outputs.iter().map(|y| y[k]);
            let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |e, v| [e[0].min(v), e[1].max(v)]);
            ends[1] - ends[0]
        });
        ranges.fold(0.0, f64::max)
    };
    for (name, std) in &options.noise {
        let known = setup.columns.iter().position(|c| c == name);
        if known.is_some_and(|k| *std < LEAST * range(k)) {
            let (what, remedy) = (format!("the noise of `{name}`"), "give at least a ten-millionth of its range");
            return Err(ExperimentError::Value { what, value: *std, remedy });
        }
    }
    let of = |(k, column): (usize, &String)| {
        let named = |source, std| ColumnNoise { column: column.clone(), std, source };
        if let Some((_, std)) = options.noise.iter().find(|n| n.0 == *column) {
            return named(NoiseSource::Given, *std);
        }
        if let Some(limit) = setup.states.iter().find(|l| l.name == *column) {
            return named(NoiseSource::Limits, SHARE * (limit.high - limit.low));
        }
        let range = range(k);
        if range > 0.0 { named(NoiseSource::Range, SHARE * range) } else { named(NoiseSource::Unknown, 1.0) }
    };
    Ok(setup.columns.iter().enumerate().map(of).collect())
}
