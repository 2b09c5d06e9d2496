//! What a compensation would have done along a log.

use super::error::StiffnessRunError;
use super::log::RobotLog;
use super::loop_gain::LoopGain;
use crate::compensate::{CompensationSettings, Compensator, Fault};
use crate::compliance::Springs;
use crate::robot::{Twist, Wrench, halves};
use crate::robot_file::RobotFile;
use crate::sensor::ForceSensor;
use bracketry_numerics::statistics::median;

/// Bias and weight in units of the force's noise, from which on readings must show them.
const WEIGHS: f64 = 5.0;
/// Times that a reading may be smaller than bias and weight: what kN for N leaves of ten times as large a process.
const FAR_BELOW: f64 = 50.0;

/// A sample of a [`CompensatedLog`].
#[derive(Clone, Debug, PartialEq)]
pub struct CompensatedRow {
    /// Time in seconds.
    pub t: f64,
    /// Corrected reference of the joints (rad, m).
    pub corrected: Vec<f64>,
    /// Correction of the joints (rad, m); the last good one where input was bad.
    pub correction: Vec<f64>,
    /// Filtered process wrench at the tool point in base axes (N, N·m).
    pub wrench: Wrench,
    /// Displacement of the tool point without correction, in base axes (m, rad).
    pub displacement: Twist,
    /// Whether bad input held the correction.
    pub held: bool,
    /// Whether a limit shortened the correction or its change.
    pub limited: bool,
}

/// How often something was wrong with the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultCount {
    /// What it was.
    pub fault: Fault,
    /// Samples.
    pub samples: usize,
}

/// A compensation along a log.
#[derive(Clone, Debug, PartialEq)]
pub struct CompensatedLog {
    /// Name of the robot.
    pub robot: String,
    /// Samples of the log.
    pub samples: usize,
    /// Period of the log in seconds.
    pub period: f64,
    /// Root mean square of the predicted translation of the tool point (m).
    pub displacement_rms: f64,
    /// Largest predicted translation (m).
    pub displacement_max: f64,
    /// Largest force of the process (N), filtered.
    pub force_max: f64,
    /// Largest correction of each joint (rad, m).
    pub correction_max: Vec<f64>,
    /// Samples at which a limit acted.
    pub limited: usize,
    /// Samples at which the correction was held, by cause.
    pub faults: Vec<FaultCount>,
    /// The loop through the process, where its stiffness was given.
    pub loop_gain: Option<LoopGain>,
    /// The samples.
    pub rows: Vec<CompensatedRow>,
}

impl CompensatedLog {
    /// Runs the compensation of a robot file along a log, at the log's period. With the stiffness of the process (N/m along the base axes) the
    /// loop through it is judged too.
    ///
    /// # Errors
    /// [`StiffnessRunError`] for a robot file without springs or sensor, and settings that do not fit.
    pub fn new(file: &RobotFile, log: &RobotLog, process: Option<[f64; 3]>) -> Result<Self, StiffnessRunError> {
        check_readings(file, &sensor(file)?, log)?;
        let mut compensator = file.compensator(Some(log.period))?;
        let settings = CompensationSettings { period: log.period, ..file.compensation };
        let springs = springs(file)?;
        let loop_gain = process.map(|process| LoopGain::new(file, springs, &settings, log, process)).transpose()?;
        let mut faults: Vec<FaultCount> = Vec::new();
        let mut rows = Vec::with_capacity(log.t.len());
        for (k, t) in log.t.iter().enumerate() {
            let step = compensator.step(&log.measured[k], &log.readings[k], &log.references[k]);
            if let Some(fault) = step.status.fault {
                let fault = of_log(fault, &log.measured[k]);
                match faults.iter_mut().find(|count| count.fault == fault) {
                    Some(count) => count.samples += 1,
                    None => faults.push(FaultCount { fault, samples: 1 }),
                }
            }
            rows.push(CompensatedRow {
                t: *t,
                corrected: step.reference.to_vec(),
                correction: step.correction.to_vec(),
                wrench: step.wrench,
                displacement: step.displacement,
                held: step.status.fault.is_some(),
                limited: step.status.saturated || step.status.rate_limited,
            });
        }
        let moved = |row: &CompensatedRow| halves(&row.displacement).0.norm();
        let good: Vec<&CompensatedRow> = rows.iter().filter(|row| !row.held).collect();
        let squares: f64 = good.iter().map(|row| moved(row).powi(2)).sum();
        let largest = |value: &dyn Fn(&CompensatedRow) -> f64| good.iter().map(|row| value(row)).fold(0.0, f64::max);
        Ok(Self {
            robot: file.robot.name.clone(),
            samples: rows.len(),
            period: log.period,
            displacement_rms: (squares / good.len().max(1) as f64).sqrt(),
            displacement_max: largest(&moved),
            force_max: largest(&|row| halves(&row.wrench).0.norm()),
            correction_max: (0..file.robot.joints.len()).map(|i| largest(&|row| row.correction[i].abs())).collect(),
            limited: rows.iter().filter(|row| row.limited).count(),
            faults,
            loop_gain,
            rows,
        })
    }

    /// Samples at which the correction was held.
    pub fn held(&self) -> usize {
        self.faults.iter().map(|count| count.samples).sum()
    }
}

impl RobotFile {
    /// The compensation that the file describes, with another period (s) where one is given.
    ///
    /// # Errors
    /// [`StiffnessRunError`] for a file without springs or sensor, and settings that do not fit.
    pub fn compensator(&self, period: Option<f64>) -> Result<Compensator, StiffnessRunError> {
        let settings = CompensationSettings { period: period.unwrap_or(self.compensation.period), ..self.compensation };
        let (period, cutoff) = (settings.period, settings.cutoff);
        if period * cutoff >= 0.5 {
            return Err(StiffnessRunError::Period { period, cutoff });
        }
        let (springs, sensor) = (springs(self)?.clone(), sensor(self)?);
        Ok(Compensator::new(self.robot.clone(), springs, sensor, self.payload, settings)?)
    }
}

/// The springs of a robot file.
pub(super) fn springs(file: &RobotFile) -> Result<&Springs, StiffnessRunError> {
    file.springs.as_ref().ok_or(StiffnessRunError::Lacks {
        what: "springs",
        remedy: "give `stiffness` for each [[joint]]; `bracketry stiffness identify` finds them",
    })
}

/// The sensor of a robot file.
pub(super) fn sensor(file: &RobotFile) -> Result<ForceSensor, StiffnessRunError> {
    file.sensor.ok_or(StiffnessRunError::Lacks {
        what: "[sensor]",
        remedy: "give its position, force_range, and moment_range",
    })
}

/// Refuses forces far below the bias and the weight that the sensor carries.
fn check_readings(file: &RobotFile, sensor: &ForceSensor, log: &RobotLog) -> Result<(), StiffnessRunError> {
    let force = |wrench: &Wrench| halves(wrench).0.norm();
    let alone = |q: &Vec<f64>| {
        let orientation = (file.robot.tool_pose(q).ok()? * sensor.pose).rotation;
        Some(force(&file.payload.reading(&orientation, &file.compensation.gravity)))
    };
    let expected = median(log.measured.iter().filter_map(alone).filter(|v| v.is_finite()).collect());
    let found = median(log.readings.iter().map(force).filter(|v| v.is_finite()).collect());
    match (found, expected) {
        (Some(found), Some(expected)) if expected > WEIGHS * file.noise.force && FAR_BELOW * found < expected => {
            Err(StiffnessRunError::Readings { found, expected })
        }
        _ => Ok(()),
    }
}

/// The fault of a log, whose measured coordinates stand for the references where it has none.
fn of_log(fault: Fault, measured: &[f64]) -> Fault {
    match fault {
        Fault::Reference(i) if measured.get(i).is_some_and(|q| q.is_nan()) => Fault::Measured(i),
        other => other,
    }
}
