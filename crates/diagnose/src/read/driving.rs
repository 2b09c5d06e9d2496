//! What drives the model: inputs and their derivatives.

use std::collections::BTreeMap;

use bracketry_sim::{Bandwidth, Hold, SmoothingSpline};
use bracketry_system::{FileError, System};

use super::audit::ColumnAudit;
use super::origin::Origin;
use super::settings::RecordSettings;
use crate::{Record, Signal};

/// Highest derivative that is taken from a spline; the next one jumps.
const HIGHEST_DERIVATIVE: u32 = 2;

/// Inputs and derivatives in the order of the model, and what is to be said of them.
pub(super) struct Driving {
    pub(super) inputs: Vec<Signal>,
    pub(super) derivatives: Vec<Signal>,
    pub(super) audits: Vec<ColumnAudit>,
}

impl Driving {
    /// Inputs by index, derivatives by index of the input and order. What no column gives is zero, where the model does not
    /// use it; a derivative that no column gives comes from a smoothing spline of its input.
    ///
    /// # Errors
    /// [`FileError`] for a derivative of too high an order.
    pub(super) fn of(
        origin: &Origin<'_>,
        mut inputs: BTreeMap<usize, Vec<f64>>,
        mut derivatives: BTreeMap<(usize, u32), Vec<f64>>,
        times: &[f64],
        gaps: &[usize],
        system: &System,
        settings: &RecordSettings,
    ) -> Result<Self, FileError> {
        let names = system.input_names();
        let zeros = || vec![0.0; times.len()];
        let moving = settings.hold.unwrap_or(Hold::Linear);
        let mut out = Self { inputs: Vec::new(), derivatives: Vec::new(), audits: Vec::new() };
        let mut derived = Vec::new();
        for d in &system.input_derivatives {
            let name = format!("der({},{})", names[d.input], d.order);
            if let Some(values) = derivatives.remove(&(d.input, d.order)) {
                let signal = Signal { values, hold: moving };
                derived.push(ColumnAudit::input(&name, &signal, None));
                out.derivatives.push(signal);
                continue;
            }
            let Some(values) = inputs.get_mut(&d.input) else {
                out.derivatives.push(Signal { values: zeros(), hold: moving });
                continue;
            };
            if d.order > HIGHEST_DERIVATIVE {
                let message = format!("the model uses {name}, for which there is no column");
                return Err(origin.whole(message, format!("add a column {name}: no spline gives order {}", d.order)));
            }
            let smoothed = Smoothed::of(times, gaps, values);
            let signal = Signal { values: smoothed.column(d.order), hold: Hold::Linear };
            derived.push(ColumnAudit::input(&name, &signal, Some(smoothed.bandwidth)));
            out.derivatives.push(signal);
        }
        for (input, name) in names.iter().enumerate() {
            let hold = if system.input_derivatives.iter().any(|d| d.input == input) {
                moving
            } else {
                settings.hold.unwrap_or_default()
            };
            let values = inputs.remove(&input);
            let given = values.is_some();
            let signal = Signal { values: values.unwrap_or_else(zeros), hold };
            if given {
                out.audits.push(ColumnAudit::input(name, &signal, None));
            }
            out.inputs.push(signal);
        }
        out.audits.extend(derived);
        Ok(out)
    }
}

impl Record {
    /// A derivative of an input, of order 1 or 2, by a smoothing spline of the input's samples whose bandwidth generalized
    /// cross validation chooses, separately between gaps in time. None for another order.
    pub fn differentiated_input(&self, input: usize, order: u32) -> Option<Signal> {
        let signal = self.inputs.get(input).filter(|_| (1..=HIGHEST_DERIVATIVE).contains(&order))?;
        let smoothed = Smoothed::of(&self.times, &self.gaps, &signal.values);
        Some(Signal { values: smoothed.column(order), hold: Hold::Linear })
    }
}

/// A column smoothed between gaps.
struct Smoothed {
    first: Vec<f64>,
    second: Vec<f64>,
    /// The lowest of the pieces, Hz.
    bandwidth: f64,
}

impl Smoothed {
    fn of(times: &[f64], gaps: &[usize], values: &[f64]) -> Self {
        let mut out = Self { first: Vec::new(), second: Vec::new(), bandwidth: f64::INFINITY };
        let ends = gaps.iter().copied().chain([times.len()]);
        let mut start = 0;
        for end in ends {
            let (times, values) = (&times[start..end], &values[start..end]);
            if let Some(spline) = SmoothingSpline::fit(times, values, Bandwidth::CrossValidated) {
                out.first.extend(spline.first);
                out.second.extend(spline.second);
                out.bandwidth = out.bandwidth.min(spline.bandwidth);
            } else {
                // Too short a piece for any window: nothing is simulated there.
                out.first.extend(std::iter::repeat_n(0.0, end - start));
                out.second.extend(std::iter::repeat_n(0.0, end - start));
            }
            start = end;
        }
        out
    }

    fn column(&self, order: u32) -> Vec<f64> {
        if order == 1 { self.first.clone() } else { self.second.clone() }
    }
}
