//! What linear springs of the joints do not explain of measured displacements, and where.

use bracketry_stiffness::{
    JointSpring, Kinematics, LostMotionReport, MeasurementSet, ResidualSample, Robot, Springs, explain_residual,
    loaded_compliance,
};
use serde::Serialize;

use super::PredictedTranslation;

/// Standard deviations by which a mean square has to exceed that of the noise.
const BEYOND_NOISE: f64 = 4.0;

/// Lost motion that explains a part of what is left.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LostMotionSummary {
    /// Joint, from 1.
    pub joint: usize,
    /// Lost motion from flank to flank (rad; m where it slides).
    pub gap: f64,
    /// Torque from which on the flanks are engaged (N·m; N).
    pub engaged: f64,
    /// Share of the squares that linear springs leave.
    pub share: f64,
}

/// What is left of the measured translations of the tool point by the springs of the joints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unexplained {
    /// Root mean square of the measured translations (m), outliers left out.
    pub moved_rms_m: f64,
    /// The same of measured less predicted.
    pub left_rms_m: f64,
    /// What the stated noise alone would leave.
    pub noise_rms_m: f64,
    /// Share of the measured root mean square that neither the springs nor the noise explain; 0 where it is within chance.
    pub share: f64,
    /// Line of the table that leaves most.
    pub worst_line: u64,
    /// Whether the springs are linear: lost motion is looked for beside them.
    pub linear: bool,
    /// Lost motion that explains it, the most important first.
    pub lost_motion: Vec<LostMotionSummary>,
    /// What remains with that lost motion (m).
    pub with_lost_motion_rms_m: Option<f64>,
}

impl Unexplained {
    /// Of springs with their predictions of all measurements; `outliers` (from 0) were left out. None without measurements.
    pub(super) fn new(
        robot: &Robot,
        springs: &Springs,
        set: &MeasurementSet,
        outliers: &[usize],
        predictions: &[PredictedTranslation],
        lines: &[u64],
    ) -> Option<Self> {
        let kept: Vec<usize> = (0..set.len()).filter(|i| !outliers.contains(i)).collect();
        // One prediction for each measurement, else the lines do not belong to them.
        if kept.is_empty() || predictions.len() != set.len() {
            return None;
        }
        let left = |i: usize| -> f64 {
            let p = &predictions[i];
            (0..3).map(|axis| (p.measured[axis] - p.predicted[axis]).powi(2)).sum()
        };
        let moved = |i: usize| -> f64 { predictions[i].measured.iter().map(|v| v * v).sum() };
        let mean = |of: &dyn Fn(usize) -> f64| kept.iter().map(|i| of(*i)).sum::<f64>() / kept.len() as f64;
        let noise = |i: usize| noise_square(robot, springs, set, i).unwrap_or(0.0);
        let (moved, rest, noise) = (mean(&moved), mean(&left), mean(&noise));
        // The mean of n squares varies by √(2/n) of itself.
        let chance = 1.0 + BEYOND_NOISE * (2.0 / (3 * kept.len()) as f64).sqrt();
        let beyond = rest > chance * noise;
        let linear = springs.joints.iter().all(|spring| matches!(spring, JointSpring::Linear { .. }));
        let report = (beyond && linear).then(|| lost_motion(robot, springs, set, &kept)).flatten();
        let worst = kept.iter().copied().max_by(|a, b| left(*a).total_cmp(&left(*b)))?;
        let mut found = Self {
            moved_rms_m: moved.sqrt(),
            left_rms_m: rest.sqrt(),
            noise_rms_m: noise.sqrt(),
            share: if beyond { ((rest - noise) / moved).sqrt() } else { 0.0 },
            worst_line: lines.get(worst).copied()?,
            linear,
            lost_motion: Vec::new(),
            with_lost_motion_rms_m: None,
        };
        if let Some(report) = report.filter(|report| !report.lost_motion.is_empty()) {
            found.lost_motion = report
                .lost_motion
                .iter()
                .map(|l| LostMotionSummary { joint: l.joint, gap: l.gap, engaged: l.engaged, share: l.share })
                .collect();
            found.with_lost_motion_rms_m = Some(report.nonlinear);
        }
        Some(found)
    }
}

impl Unexplained {
    /// Share of the squares that linear springs leave which lost motion explains.
    pub(super) fn by_lost_motion(&self) -> f64 {
        self.lost_motion.iter().map(|lost| lost.share).sum()
    }
}

/// Expected square of the noise of a translation: that of the displacement and that of the wrench through the compliance.
fn noise_square(robot: &Robot, springs: &Springs, set: &MeasurementSet, index: usize) -> Option<f64> {
    let (m, noise) = (&set.measurements()[index], &set.noise()[index]);
    let kinematics = Kinematics::new(robot, &m.q).ok()?;
    let compliance = loaded_compliance(robot, springs, &kinematics, &m.wrench).ok()?;
    let covariance = noise.displacement + compliance * noise.wrench * compliance.transpose();
    Some(covariance.diagonal().fixed_rows::<3>(0).sum())
}

/// Lost motion in joints; none where there are too few measurements to tell.
fn lost_motion(robot: &Robot, springs: &Springs, set: &MeasurementSet, kept: &[usize]) -> Option<LostMotionReport> {
    let samples: Vec<ResidualSample> = kept
        .iter()
        .map(|i| {
            let m = &set.measurements()[*i];
            ResidualSample {
                coordinates: m.q.clone(),
                wrench: m.wrench,
                displacement: m.displacement.fixed_rows::<3>(0).into(),
            }
        })
        .collect();
    explain_residual(robot, springs, &samples).ok()
}
