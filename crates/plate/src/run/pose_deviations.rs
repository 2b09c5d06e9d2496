//! How far the pose of a run is from that of a log.

use std::ops::RangeBounds;

use serde::Serialize;

use super::result::PlateRow;
use crate::PlateLog;

/// Rotations of the log below this (rad) are too small for a share of them to mean anything.
const SMALLEST_ROTATION: f64 = 0.02;
/// Millimeters and degrees per unit of x, y and yaw.
pub(super) const UNITS: [f64; 3] = [1e3, 1e3, 180.0 / std::f64::consts::PI];

/// How far the pose of a run is from that of a log over some time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PoseDeviations {
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

impl PoseDeviations {
    /// Compares at the times of the log within `span`, between the rows of the run by straight lines; none without a common
    /// time.
    pub(super) fn new(rows: &[PlateRow], log: &PlateLog, span: impl RangeBounds<f64>) -> Option<Self> {
        let (first, last) = (rows.first()?, rows.last()?);
        let slack = 1e-9 * (last.t - first.t);
        let common: Vec<usize> = (0..log.t.len())
            .filter(|k| span.contains(&log.t[*k]) && log.t[*k] >= first.t - slack && log.t[*k] <= last.t + slack)
            .collect();
        let (from, to) = (*common.first()?, *common.last()?);
        let columns = [&log.x, &log.y, &log.phi];
        let poses: Vec<[f64; 3]> = common.iter().map(|k| pose_at(rows, log.t[*k])).collect();
        let deviation = |i: usize| {
            let differences = common.iter().zip(&poses).map(|(k, p)| UNITS[i] * (p[i] - columns[i][*k]));
            Deviation::of(&differences.collect::<Vec<f64>>())
        };
        let rotation = log.phi[to] - log.phi[from];
        let gained = poses[poses.len() - 1][2] - poses[0][2];
        Some(Self {
            from: log.t[from],
            to: log.t[to],
            rows: common.len(),
            x_mm: deviation(0),
            y_mm: deviation(1),
            phi_deg: deviation(2),
            phi_percent: (rotation.abs() > SMALLEST_ROTATION).then(|| 100.0 * (gained - rotation) / rotation),
        })
    }

    /// Along a coordinate, in the unit of the run: m, rad.
    pub(super) fn rms(&self, coordinate: usize) -> f64 {
        [&self.x_mm, &self.y_mm, &self.phi_deg][coordinate].rms / UNITS[coordinate]
    }
}

impl Deviation {
    pub(super) fn of(differences: &[f64]) -> Self {
        let squares: f64 = differences.iter().map(|d| d * d).sum();
        Self {
            rms: (squares / differences.len().max(1) as f64).sqrt(),
            largest: differences.iter().copied().fold(0.0, |l: f64, d| if d.abs() > l.abs() { d } else { l }),
            at_end: differences.last().copied().unwrap_or(0.0),
        }
    }
}

/// The pose of a run at `t`, by straight lines between its rows.
pub(super) fn pose_at(rows: &[PlateRow], t: f64) -> [f64; 3] {
    let k = rows.partition_point(|r| r.t <= t).clamp(1, rows.len().max(2) - 1);
    let (a, b) = (rows[k - 1], rows.get(k).copied().unwrap_or(rows[k - 1]));
    let part = if b.t > a.t { ((t - a.t) / (b.t - a.t)).clamp(0.0, 1.0) } else { 0.0 };
    [0, 1, 2].map(|i| a.state[i] + part * (b.state[i] - a.state[i]))
}
