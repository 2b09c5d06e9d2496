//! Whether data hold any motion.

use bracketry_numerics::statistics::quantile;
use bracketry_system::System;

use crate::report::{Evidence, NoMotion, Outcome, VerdictReason};
use crate::{Effort, Measured, Record, Report, Verdict};

/// Nine tenths of a normal variable lie within this many standard deviations around its mean, to both sides.
const NINE_TENTHS: f64 = 1.645;

/// Measured columns that are significant above their noise in no record, by name, and whether those are all. Single outliers are no motion.
pub(super) fn still(records: &[Record], motion_spread: f64) -> (Vec<String>, bool) {
    let moves = |m: &Measured| spread(&m.values) > motion_spread * 2.0 * NINE_TENTHS * m.noise;
    let mut names: Vec<&str> = Vec::new();
    for m in records.iter().flat_map(|r| &r.measured) {
        if !names.contains(&m.name.as_str()) {
            names.push(&m.name);
        }
    }
    let all = names.len();
    names.retain(|name| !records.iter().flat_map(|r| &r.measured).any(|m| m.name == *name && moves(m)));
    (names.iter().map(|&n| n.to_owned()).collect(), names.len() == all)
}

/// Whether some input changes in some record.
pub(super) fn driven(records: &[Record]) -> bool {
    records.iter().flat_map(|r| &r.inputs).any(|signal| signal.values.windows(2).any(|w| w[0] != w[1]))
}

/// The report on records in which nothing moves: no fit, since it would only give the prior back, or what a dead sensor feigns.
pub(super) fn uninformative(system: &System, records: &[Record]) -> Report {
    let no_motion = match (records.iter().any(|r| !r.inputs.is_empty()), driven(records)) {
        (false, _) => NoMotion::NoInputs,
        (true, false) => NoMotion::StillInputs,
        (true, true) => NoMotion::DrivenInputs,
    };
    Report {
        reason: VerdictReason { outcome: Outcome::NoMotion(no_motion), caveats: Vec::new() },
        ..without_findings(system)
    }
}

/// A report in which nothing stands but the name of the model.
pub(super) fn without_findings(system: &System) -> Report {
    Report {
        model: system.name.clone(),
        quantities: system.quantities.clone(),
        verdict: Verdict::Uninformative,
        reason: VerdictReason { outcome: Outcome::Explained, caveats: Vec::new() },
        causes: Vec::new(),
        places: Vec::new(),
        regimes: Vec::new(),
        residual_acceleration: Vec::new(),
        gain: None,
        parameters: Vec::new(),
        excess: None,
        candidates: Vec::new(),
        windows: None,
        notes: Vec::new(),
        effort: Effort::default(),
        seconds: 0.0,
        data: Vec::new(),
        evidence: Evidence::default(),
    }
}

/// Distance between the 5th and the 95th percentile of the values that are there.
fn spread(values: &[f64]) -> f64 {
    let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    quantile(known.clone(), 0.95).zip(quantile(known, 0.05)).map_or(0.0, |(high, low)| high - low)
}
