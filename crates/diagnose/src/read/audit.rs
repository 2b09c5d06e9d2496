//! What is to be said about the data before anything is concluded from them.

use bracketry_numerics::statistics::extremes;
use std::fmt;

use bracketry_sim::Hold;
use bracketry_system::{TimeUnit, counted, readable};
use serde::Serialize;

use super::clock::Clock;
use super::noise::Noise;
use super::warning::Warning;
use crate::Signal;
use crate::numbers::significant;
use crate::settings::ReadSettings;

/// What one column is like.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnAudit {
    /// Its name in the model.
    pub name: String,
    /// Whether it drives the model; otherwise it was measured.
    pub input: bool,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Number of lost values.
    pub lost: usize,
    /// Measured columns: number of values that stand alone, far from their neighbors, whether they are left out or not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outliers: Option<usize>,
    /// Measured columns: standard deviation of the noise, in the column's unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// Measured columns: correlation of the noise of neighboring samples, 0 where it was not told from white noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_correlation: Option<f64>,
    /// Measured columns: distance of neighboring values, where all are multiples of one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolution: Option<f64>,
    /// Measured columns: number of samples at the smallest or largest value, where they lie in rows as elsewhere they do not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub saturated: Option<usize>,
    /// Inputs: whether straight lines join the samples; otherwise each is held until the next.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lines: Option<bool>,
    /// Derivatives by a smoothing spline of the input: the frequency in Hz at which half of the amplitude passes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bandwidth: Option<f64>,
}

impl ColumnAudit {
    fn new(name: &str, input: bool, values: &[f64]) -> Self {
        let (min, max) = extremes(values.iter().copied().filter(|v| v.is_finite()));
        Self {
            name: name.to_owned(),
            input,
            min,
            max,
            lost: values.iter().filter(|v| v.is_nan()).count(),
            outliers: None,
            noise: None,
            noise_correlation: None,
            resolution: None,
            saturated: None,
            lines: None,
            bandwidth: None,
        }
    }

    pub(super) fn measured(name: &str, values: &[f64], noise: Noise, settings: &ReadSettings) -> Self {
        let column = Self::new(name, false, values);
        Self {
            noise: Some(noise.std),
            noise_correlation: Some(noise.correlation),
            resolution: noise.resolution,
            saturated: saturated(values, column.min, column.max, settings.flat_samples),
            ..column
        }
    }

    pub(super) fn input(name: &str, signal: &Signal, bandwidth: Option<f64>) -> Self {
        let lines = Some(signal.hold == Hold::Linear);
        Self { lines, bandwidth, ..Self::new(name, true, &signal.values) }
    }

    /// Whether the column never changes.
    pub fn constant(&self) -> bool {
        self.min == self.max
    }

    /// What is to be said of the column.
    fn warnings(&self, samples: usize, step: f64, settings: &ReadSettings) -> Vec<Warning> {
        let name = self.name.clone();
        if self.constant() {
            return vec![Warning::Constant { name, value: self.min, input: self.input }];
        }
        let mut out = Vec::new();
        if self.lost > 0 {
            out.push(Warning::Lost { name: name.clone(), count: self.lost, samples });
        }
        if let Some(count) = self.saturated {
            out.push(Warning::Saturated { name: name.clone(), count });
        }
        let noise = self.noise.unwrap_or(0.0);
        if let Some(q) = self.resolution.filter(|q| q / 12f64.sqrt() > 0.5 * noise) {
            out.push(Warning::Coarse { name: name.clone(), step: q });
        }
        if noise > settings.mostly_noise * (self.max - self.min) {
            out.push(Warning::Noisy { name: name.clone() });
        }
        let correlation = self.noise_correlation.unwrap_or(0.0);
        if correlation > settings.correlated {
            out.push(Warning::Correlated { name, time: -step / correlation.ln() });
        }
        out
    }
}

/// Number of samples in rows of at least `flat` at the smallest or the largest value, if at least half of all such rows are
/// there: a column that rests or is coarse has them everywhere.
fn saturated(values: &[f64], min: f64, max: f64, flat: usize) -> Option<usize> {
    let (mut rows_there, mut rows_elsewhere, mut there) = (0, 0, 0);
    for row in values.chunk_by(|a, b| a == b).filter(|row| row.len() >= flat) {
        if row[0] == min || row[0] == max {
            rows_there += 1;
            there += row.len();
        } else {
            rows_elsewhere += 1;
        }
    }
    (min < max && rows_there > 0 && rows_there >= rows_elsewhere).then_some(there)
}

/// What was found in the data of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Audit {
    /// The unit of the time of the model.
    #[serde(skip_serializing_if = "TimeUnit::is_second")]
    pub time_unit: TimeUnit,
    /// Name of the run: the file.
    pub name: String,
    /// Number of samples.
    pub samples: usize,
    /// From the first to the last sample, s.
    pub duration: f64,
    /// Median distance between samples, s.
    pub step: f64,
    /// Standard deviation of that distance, over the distance.
    pub jitter: f64,
    /// Number of gaps in time; nothing is simulated across them.
    pub gaps: usize,
    /// The columns that mean something to the model.
    pub columns: Vec<ColumnAudit>,
    /// Names of the other columns.
    pub ignored: Vec<String>,
    /// What may spoil a conclusion.
    pub warnings: Vec<Warning>,
}

impl Audit {
    pub(super) fn new(
        name: &str,
        times: &[f64],
        clock: &Clock,
        columns: Vec<ColumnAudit>,
        ignored: Vec<String>,
        time_unit: TimeUnit,
        settings: &ReadSettings,
    ) -> Self {
        let samples = times.len();
        let mut warnings: Vec<Warning> =
            columns.iter().flat_map(|c| c.warnings(samples, clock.step, settings)).collect();
        if clock.jitter > settings.uneven {
            warnings.push(Warning::Uneven { jitter: clock.jitter });
        }
        if !clock.gaps.is_empty() {
            let after = clock.gaps.iter().take(5).map(|k| times[*k]).collect();
            warnings.push(Warning::Gaps { count: clock.gaps.len(), after });
        }
        // Only seconds can be taken for counts of samples or milliseconds.
        if clock.step >= 1.0 && time_unit.is_second() {
            warnings.push(Warning::Slow { step: clock.step });
        }
        Self {
            time_unit,
            name: name.to_owned(),
            samples,
            duration: times[samples - 1] - times[0],
            step: clock.step,
            jitter: clock.jitter,
            gaps: clock.gaps.len(),
            warnings,
            columns,
            ignored,
        }
    }
}

impl fmt::Display for Audit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let samples = counted(self.samples, "sample", "samples");
        let (duration, rate) = (self.time_unit.text(readable(self.duration)), readable(1.0 / self.step));
        let per = match self.time_unit {
            TimeUnit::Second => "second",
            TimeUnit::Dimensionless => "unit of time",
            unit => unit.symbol(),
        };
        writeln!(f, "{}: {samples} over {duration}, {rate} per {per}", self.name)?;
        let width = self.columns.iter().map(|c| c.name.chars().count()).max().unwrap_or(0);
        for c in &self.columns {
            write!(f, "  {:width$}  from {} to {}, ", c.name, significant(c.min, 5), significant(c.max, 5))?;
            match (c.noise, c.lines, c.bandwidth) {
                (Some(noise), ..) => write!(f, "measured, noise {}", significant(noise, 4))?,
                // Beyond half the sampling rate nothing is smoothed away.
                (_, _, Some(bandwidth)) if 2.0 * bandwidth * self.step >= 1.0 => {
                    write!(f, "by a spline through the samples")?;
                }
                (_, _, Some(bandwidth)) => {
                    write!(f, "by a smoothing spline of bandwidth {bandwidth:.3} {}", self.time_unit.frequency())?;
                }
                (_, Some(true), _) => write!(f, "input, linear interpolation between samples")?,
                _ => write!(f, "input, held between samples")?,
            }
            if let Some(q) = c.resolution {
                write!(f, ", in steps of {}", significant(q, 4))?;
            }
            writeln!(f)?;
        }
        if !self.ignored.is_empty() {
            let shown =
                |name: &String| if name.is_empty() { "a column without a name".to_owned() } else { name.clone() };
            writeln!(f, "  ignored: {}", self.ignored.iter().map(shown).collect::<Vec<_>>().join(", "))?;
        }
        for w in &self.warnings {
            writeln!(f, "  warning: {}\n    {}", w.message(), w.remedy())?;
        }
        Ok(())
    }
}
