//! What is to be said about the data before anything is concluded from them.

use std::fmt;

use bracketry_sim::Hold;
use serde::Serialize;

use super::clock::Clock;
use super::noise::Noise;
use crate::Signal;

/// Something about the data that may spoil a conclusion.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// What was seen.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

/// What one column is like.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnAudit {
    /// Its name in the model.
    pub name: String,
    /// Whether it drives the model; otherwise it was measured.
    pub input: bool,
    /// Number of lost values.
    pub lost: usize,
    /// Standard deviation of its noise, in its unit; measured columns only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// Inputs: whether straight lines join the samples; otherwise each is held until the next.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lines: Option<bool>,
    /// Derivatives by a smoothing spline of the input: the frequency in Hz at which half of the amplitude passes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bandwidth: Option<f64>,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl ColumnAudit {
    fn new(name: &str, input: bool, values: &[f64]) -> Self {
        let finite = values.iter().filter(|v| v.is_finite());
        let (min, max) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        let lost = values.iter().filter(|v| v.is_nan()).count();
        Self { name: name.to_owned(), input, lost, noise: None, lines: None, bandwidth: None, min, max }
    }

    pub(super) fn measured(name: &str, values: &[f64], noise: Noise) -> Self {
        Self { noise: Some(noise.std), ..Self::new(name, false, values) }
    }

    pub(super) fn input(name: &str, signal: &Signal, bandwidth: Option<f64>) -> Self {
        let lines = Some(signal.hold == Hold::Linear);
        Self { lines, bandwidth, ..Self::new(name, true, &signal.values) }
    }

    /// Whether the column never changes.
    pub fn constant(&self) -> bool {
        self.min == self.max
    }
}

/// What was found in the data of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Audit {
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
    ) -> Self {
        let warnings = columns.iter().filter(|c| c.input && c.constant()).map(|c| Warning {
            message: format!("the input `{}` is {} throughout", c.name, c.min),
            remedy: "what acts through it cannot be told from an offset: move it".into(),
        });
        Self {
            name: name.to_owned(),
            samples: times.len(),
            duration: times[times.len() - 1] - times[0],
            step: clock.step,
            jitter: clock.jitter,
            gaps: clock.gaps.len(),
            warnings: warnings.collect(),
            columns,
            ignored,
        }
    }
}

impl fmt::Display for Audit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} samples over {} s", self.name, self.samples, self.duration)?;
        for c in &self.columns {
            match c.noise {
                Some(noise) => writeln!(f, "  {}: measured, noise {noise:.3e}", c.name)?,
                None => writeln!(f, "  {}: input", c.name)?,
            }
        }
        if !self.ignored.is_empty() {
            writeln!(f, "  ignored: {}", self.ignored.join(", "))?;
        }
        for w in &self.warnings {
            writeln!(f, "  warning: {} ({})", w.message, w.remedy)?;
        }
        Ok(())
    }
}
