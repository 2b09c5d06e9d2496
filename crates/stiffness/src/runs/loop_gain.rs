//! Whether a compensation and a process drive each other up along a log.

use super::log::RobotLog;
use crate::compensate::{CompensationError, CompensationSettings, Stability, stability};
use crate::compliance::{Springs, loaded_compliance};
use crate::robot::{Kinematics, Wrench};
use crate::robot_file::RobotFile;
use nalgebra::{Matrix6, Vector6};

/// Poses along a log at which the loop is judged, about.
const POSES: usize = 200;

/// Gains of the loop through the process, the largest along a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopGain {
    /// Stiffness of the process along the base axes (N/m).
    pub process_stiffness: [f64; 3],
    /// The gains; that of the compensation times the largest gain of filter and prediction.
    pub gains: Stability,
}

impl LoopGain {
    /// Along the coordinates of a log that were not lost, with the robot as its springs say.
    pub(super) fn new(
        file: &RobotFile,
        springs: &Springs,
        settings: &CompensationSettings,
        log: &RobotLog,
        process_stiffness: [f64; 3],
    ) -> Result<Self, CompensationError> {
        let [x, y, z] = process_stiffness;
        let process = Matrix6::from_diagonal(&Vector6::new(x, y, z, 0.0, 0.0, 0.0));
        let mut gains = Stability::NONE;
        let complete = |q: &&Vec<f64>| q.iter().all(|v| v.is_finite());
        for q in log.measured.iter().filter(complete).step_by((log.measured.len() / POSES).max(1)) {
            let kinematics = Kinematics::new(&file.robot, q)?;
            let compliance = loaded_compliance(&file.robot, springs, &kinematics, &Wrench::zeros())?;
            let here = stability(&process, &compliance, &compliance)?;
            gains = gains.worse(Stability { compensation: here.compensation * settings.largest_gain(), ..here });
        }
        Ok(Self { process_stiffness, gains })
    }

    /// Whether the loop is stable with any lag.
    pub fn holds(&self) -> bool {
        self.gains.holds()
    }
}
