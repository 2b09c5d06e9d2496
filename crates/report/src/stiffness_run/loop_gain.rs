//! Whether a compensation and a process drive each other up along a log.

use std::fmt;

use bracketry_stiffness::{CompensationSettings, Kinematics, RobotFile, Springs, Wrench, loaded_compliance, stability};
use nalgebra::{Matrix6, Vector6};
use serde::Serialize;

use super::{RobotLog, StiffnessRunError};

/// Poses along a log at which the loop is judged, about.
const POSES: usize = 200;

/// Gains of the loop through the process, the largest along a log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopGain {
    /// Stiffness of the process along the base axes (N/m).
    pub process_stiffness: [f64; 3],
    /// Spectral radius of process stiffness × compliance.
    pub process: f64,
    /// How much of a correction comes back as the next one: spectral radius of `(1 + K_p C)⁻¹ K_p Ĉ` times the largest gain of filter and
    /// prediction.
    pub compensation: f64,
    /// Whether the process holds the tool by itself.
    pub process_holds: bool,
}

impl LoopGain {
    /// Along the coordinates of a log that were not lost, with the robot as its springs say.
    pub(super) fn new(
        file: &RobotFile,
        springs: &Springs,
        settings: &CompensationSettings,
        log: &RobotLog,
        process_stiffness: [f64; 3],
    ) -> Result<Self, StiffnessRunError> {
        let [x, y, z] = process_stiffness;
        let process = Matrix6::from_diagonal(&Vector6::new(x, y, z, 0.0, 0.0, 0.0));
        let mut worst = Self { process_stiffness, process: 0.0, compensation: 0.0, process_holds: true };
        let whole = |q: &&Vec<f64>| q.iter().all(|v| v.is_finite());
        for q in log.measured.iter().filter(whole).step_by((log.measured.len() / POSES).max(1)) {
            let kinematics = Kinematics::new(&file.robot, q).map_err(bracketry_stiffness::CompensationError::from)?;
            let compliance = loaded_compliance(&file.robot, springs, &kinematics, &Wrench::zeros())
                .map_err(bracketry_stiffness::CompensationError::from)?;
            let here = stability(&process, &compliance, &compliance)?;
            worst.process = worst.process.max(here.process);
            worst.compensation = worst.compensation.max(here.compensation * settings.largest_gain());
            worst.process_holds &= here.process_holds;
        }
        Ok(worst)
    }

    /// Whether the loop is stable with any lag.
    pub fn holds(&self) -> bool {
        self.process_holds && self.process < 1.0 && self.compensation < 1.0
    }
}

impl fmt::Display for LoopGain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.process_stiffness;
        writeln!(
            f,
            "with a process of {x}, {y}, {z} N/m: process stiffness × compliance {:.3}, loop through the compensation {:.3}",
            self.process, self.compensation
        )?;
        if self.holds() {
            writeln!(f, "both below 1: stable with any lag")
        } else {
            writeln!(
                f,
                "not below 1: compensation and process may drive each other up; cut less deep or slower, or raise stiffness_error"
            )
        }
    }
}
