//! The intervals of a horizon that differ in length.

use super::horizon::MOST_INTERVALS;
use super::reader::{Parsed, Reader};
use crate::ocp::Ocp;
use bracketry_system::{Table, Value};

/// Longest horizon, in sampling periods.
const LONGEST: f64 = 1e5;

impl Reader<'_> {
    /// The lengths of the intervals of `[horizon]`, from `lengths` or `growth`; empty where all are equal.
    pub(super) fn lengths(&self, horizon: &Table<'_>) -> Parsed<Vec<f64>> {
        let lengths = match (horizon.get("lengths"), horizon.get("growth")) {
            (Some(v), _) => {
                let remedy = "write lengths = [0.05, 0.05, 0.1, 0.2]: seconds, the first one the sampling period";
                for key in ["steps", "dt", "growth", "end_time"] {
                    if let Some(other) = horizon.get(key) {
                        let message = format!("`lengths` defines the whole grid: it cannot be combined with `{key}`");
                        return Err(self.doc.error(other.span(), message, "remove one of them").into());
                    }
                }
                let Value::Array(list) = v.get_ref() else {
                    return Err(self.doc.error(v.span(), "`lengths` must be a list", remedy).into());
                };
                let mut lengths = Vec::new();
                for entry in list {
                    let length = self.constant(entry, "lengths")?;
                    if length <= 0.0 {
                        return Err(self.doc.error(entry.span(), "a length must be positive", remedy).into());
                    }
                    lengths.push(length);
                }
                if lengths.is_empty() {
                    return Err(self.doc.error(v.span(), "`lengths` is empty", remedy).into());
                }
                lengths
            }
            (None, Some(v)) => {
                let growth = self.positive(horizon, "growth", None)?;
                if horizon.contains_key("end_time") {
                    let message = "`growth` continues from the first interval";
                    return Err(self.doc.error(v.span(), message, "give dt instead of end_time").into());
                }
                let dt = self.positive(horizon, "dt", None)?;
                let steps = self.count_up_to(horizon, "steps", None, MOST_INTERVALS)?;
                (0..steps).map(|k| dt * growth.powi(k as i32)).collect()
            }
            (None, None) => return Ok(Vec::new()),
        };
        let whole: f64 = lengths.iter().sum();
        let shortest = lengths.iter().fold(f64::INFINITY, |s: f64, l| s.min(*l));
        if !(whole <= LONGEST * lengths[0] && shortest >= lengths[0] / LONGEST) {
            let place = horizon.get("lengths").or(horizon.get("growth")).map_or(0..0, toml::Spanned::span);
            let message = format!("the horizon lasts {whole} s with a sampling period of {} s", lengths[0]);
            return Err(self.doc.error(place, message, "choose a growth closer to 1, or fewer intervals").into());
        }
        Ok(lengths)
    }

    /// Refuses intervals of different lengths where something needs them to be equal.
    pub(super) fn same_lengths(&self, horizon: &Table<'_>, ocp: &Ocp, needed: bool, what: &str) -> Parsed<()> {
        if !needed || ocp.is_uniform() {
            return Ok(());
        }
        let place = horizon.get("lengths").or(horizon.get("growth")).map_or(0..0, toml::Spanned::span);
        let message = format!("{what} cannot be combined with intervals of different lengths");
        Err(self
            .doc
            .error(
                place,
                message,
                "write steps and dt instead of growth or lengths, or remove what cannot be combined with them",
            )
            .into())
    }
}
