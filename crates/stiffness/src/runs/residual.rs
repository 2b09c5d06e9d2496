//! What linear springs of the joints do not explain of measured displacements, and where.

use crate::compliance::{JointSpring, Springs, loaded_compliance};
use crate::identify::{LostMotion, LostMotionReport, MeasurementSet, ResidualSample, explain_residual};
use crate::robot::{Kinematics, Robot};
use nalgebra::Vector3;

/// Standard deviations by which a mean square has to exceed that of the noise.
const BEYOND_NOISE: f64 = 4.0;

/// The measured translation of the tool point and its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedTranslation {
    /// Measured (m, base axes).
    pub measured: Vector3<f64>,
    /// Predicted.
    pub predicted: Vector3<f64>,
    /// Whether the measurement was left out as an outlier.
    pub outlier: bool,
}

/// What is left of the measured translations of the tool point by the springs of the joints.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringResidual {
    /// Root mean square of the measured translations (m), outliers left out.
    pub measured_rms: f64,
    /// The same of measured less predicted.
    pub residual_rms: f64,
    /// What the stated noise alone would leave.
    pub noise_rms: f64,
    /// Share of the measured root mean square that neither the springs nor the noise explain; 0 where it is within chance.
    pub share: f64,
    /// Line of the table that leaves most.
    pub worst_line: u64,
    /// Whether the springs are linear: lost motion is looked for beside them.
    pub linear: bool,
    /// Lost motion that explains it, the most important first.
    pub lost_motion: Vec<LostMotion>,
    /// What remains with that lost motion (m).
    pub with_lost_motion_rms: Option<f64>,
}

impl SpringResidual {
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
        let squares = |i: usize| -> f64 {
            let p = &predictions[i];
            (p.measured - p.predicted).iter().map(|v| v.powi(2)).sum()
        };
        let measured = |i: usize| -> f64 { predictions[i].measured.iter().map(|v| v * v).sum() };
        let mean = |of: &dyn Fn(usize) -> f64| kept.iter().map(|i| of(*i)).sum::<f64>() / kept.len() as f64;
        let noise = |i: usize| noise_square(robot, springs, set, i).unwrap_or(0.0);
        let (measured, residual, noise) = (mean(&measured), mean(&squares), mean(&noise));
        // The mean of n squares varies by √(2/n) of itself.
        let chance = 1.0 + BEYOND_NOISE * (2.0 / (3 * kept.len()) as f64).sqrt();
        let beyond = residual > chance * noise;
        let linear = springs.joints.iter().all(|spring| matches!(spring, JointSpring::Linear { .. }));
        let report = (beyond && linear).then(|| lost_motion(robot, springs, set, &kept)).flatten();
        let worst = kept.iter().copied().max_by(|a, b| squares(*a).total_cmp(&squares(*b)))?;
        let report = report.filter(|report| !report.lost_motion.is_empty());
        Some(Self {
            measured_rms: measured.sqrt(),
            residual_rms: residual.sqrt(),
            noise_rms: noise.sqrt(),
            share: if beyond { ((residual - noise) / measured).sqrt() } else { 0.0 },
            worst_line: lines.get(worst).copied()?,
            linear,
            with_lost_motion_rms: report.as_ref().map(|report| report.nonlinear),
            lost_motion: report.map_or_else(Vec::new, |report| report.lost_motion),
        })
    }

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
