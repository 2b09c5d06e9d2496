//! The robot that mills: its springs in equilibrium with the cutting force.

use super::cutting::{Cutting, Directions};
use crate::compliance::{Deflections, DeformedFrames, Springs};
use crate::error::StiffnessError;
use crate::robot::{Robot, Wrench};
use nalgebra::{Isometry3, Vector3};

/// Error of the depth of cut at which the process and the springs agree (m).
const DEPTH_FOUND: f64 = 1e-10;
/// Most evaluations to the depth of cut.
const MOST_DEPTHS: usize = 80;
/// Most passes to the loaded equilibrium, and the change (m, rad) that ends them.
const MOST_PASSES: usize = 60;
const SETTLED: f64 = 1e-12;

/// The true robot: its springs in equilibrium with the process.
pub(super) struct CuttingRobot<'a> {
    robot: &'a Robot,
    springs: &'a Springs,
    deformed: DeformedFrames,
    deflected: Deflections,
    /// Depth of cut found last (m), and how fast what was missing fell with it.
    depth: f64,
    slope: f64,
}

impl<'a> CuttingRobot<'a> {
    pub(super) fn new(robot: &'a Robot, springs: &'a Springs) -> Self {
        let joints = robot.joints.len();
        let deflected = Deflections::none(joints);
        let deformed = DeformedFrames::new(robot, &vec![0.0; joints], &deflected);
        Self { robot, springs, deformed, deflected, depth: 0.0, slope: -1.0 }
    }

    /// The loaded tool point's frame.
    pub(super) fn tool(&self) -> Isometry3<f64> {
        self.deformed.tool
    }

    /// The loaded tool point under a wrench.
    fn settle(&mut self, q: &[f64], wrench: &Wrench) -> Result<(), StiffnessError> {
        let mut change = f64::INFINITY;
        for _ in 0..MOST_PASSES {
            self.deformed.update(self.robot, q, &self.deflected);
            change = self.deformed.deflect(self.robot, self.springs, wrench, &mut self.deflected);
            if change <= SETTLED {
                return Ok(());
            }
        }
        Err(StiffnessError::NoEquilibrium { iterations: MOST_PASSES, change })
    }

    /// The depth of cut at which the tool stands where the force of that depth puts it, by secants within a bracket; gives the wrench,
    /// none where no depth is found. `outside` tells how far a point lies outside the path.
    pub(super) fn cut(
        &mut self,
        cutting: &Cutting,
        at: &Directions,
        q: &[f64],
        time: f64,
        outside: impl Fn(&Vector3<f64>) -> f64,
    ) -> Result<Option<Wrench>, StiffnessError> {
        // The root lies above `low` (out of the material below 0) and below `high`.
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut last: Option<(f64, f64)> = None;
        let mut depth = self.depth;
        for _ in 0..MOST_DEPTHS {
            self.settle(q, &cutting.wrench(at, depth, time))?;
            let gap = cutting.depth + outside(&self.deformed.tool.translation.vector) - depth;
            if gap.abs() <= DEPTH_FOUND || (depth == 0.0 && gap < 0.0) {
                self.depth = depth;
                return Ok(Some(cutting.wrench(at, depth, time)));
            }
            if let Some((before, gap_before)) = last {
                self.slope = (gap - gap_before) / (depth - before);
            }
            last = Some((depth, gap));
            if gap > 0.0 {
                low = depth;
            } else {
                high = depth;
            }
            let next = depth - gap / self.slope;
            depth = if next > low && next < high && self.slope < 0.0 {
                next
            } else if high.is_infinite() {
                2.0 * depth + cutting.depth
            } else if low == 0.0 && next <= 0.0 {
                0.0
            } else {
                0.5 * (low + high)
            };
        }
        Ok(None)
    }
}
