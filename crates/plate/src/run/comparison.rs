//! A run beside a log of the same experiment.

use serde::Serialize;

use super::result::PlateRow;
use crate::PlateLog;

/// Rotations of the log below this (rad) are too small for a share of them to mean anything.
const SMALLEST_ROTATION: f64 = 0.02;

/// How far a run is from a log over their common time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The log.
    pub log: String,
    /// First common time in seconds.
    pub from: f64,
    /// Last common time in seconds.
    pub to: f64,
    /// Rows of the log in it.
    pub rows: usize,
    /// Along x, in millimeters.
    pub x_mm: Deviation,
    /// Along y, in millimeters.
    pub y_mm: Deviation,
    /// Yaw, in degrees.
    pub phi_deg: Deviation,
    /// Difference of the yaw gained at the end, in percent of the log's; none where the log hardly turns.
    pub phi_percent: Option<f64>,
}

/// Differences run − log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// Root mean square.
    pub rms: f64,
    /// Largest in size.
    pub largest: f64,
    /// At the last common time.
    pub at_end: f64,
}

impl Comparison {
    /// Compares at the times of the log, between the rows of the run by straight lines; none without a common time.
    pub fn new(rows: &[PlateRow], log: &PlateLog) -> Option<Self> {
        let (first, last) = (rows.first()?, rows.last()?);
        let slack = 1e-9 * (last.t - first.t);
        let common: Vec<usize> =
            (0..log.t.len()).filter(|k| log.t[*k] >= first.t - slack && log.t[*k] <= last.t + slack).collect();
        let (from, to) = (*common.first()?, *common.last()?);
        let pose = |t: f64| {
            let k = rows.partition_point(|r| r.t <= t).clamp(1, rows.len().max(2) - 1);
            let (a, b) = (rows[k - 1], rows.get(k).copied().unwrap_or(rows[k - 1]));
            let part = if b.t > a.t { ((t - a.t) / (b.t - a.t)).clamp(0.0, 1.0) } else { 0.0 };
            [0, 1, 2].map(|i| a.state[i] + part * (b.state[i] - a.state[i]))
        };
        let columns = [&log.x, &log.y, &log.phi];
        let poses: Vec<[f64; 3]> = common.iter().map(|k| pose(log.t[*k])).collect();
        let deviation = |i: usize, scale: f64| {
            let differences: Vec<f64> =
                common.iter().zip(&poses).map(|(k, p)| scale * (p[i] - columns[i][*k])).collect();
            let squares: f64 = differences.iter().map(|d| d * d).sum();
            Deviation {
                rms: (squares / differences.len() as f64).sqrt(),
                largest: differences.iter().copied().fold(0.0, |l: f64, d| if d.abs() > l.abs() { d } else { l }),
                at_end: differences.last().copied().unwrap_or(0.0),
            }
        };
        let rotation = log.phi[to] - log.phi[from];
        let gained = poses[poses.len() - 1][2] - poses[0][2];
        Some(Self {
            log: log.name.clone(),
            from: log.t[from],
            to: log.t[to],
            rows: common.len(),
            x_mm: deviation(0, 1e3),
            y_mm: deviation(1, 1e3),
            phi_deg: deviation(2, 180.0 / std::f64::consts::PI),
            phi_percent: (rotation.abs() > SMALLEST_ROTATION).then(|| 100.0 * (gained - rotation) / rotation),
        })
    }
}
