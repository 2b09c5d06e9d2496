//! Control by the mean motion over the cycles of a shaking plate.

use super::cycle::{CYCLE, Cycle};
use super::cycle_map::{CycleMap, Drifts, Quantity};
use super::halt::Pipeline;
use crate::{Tolerance, Trial, TrialSetup, pose_error};
use bracketry_plate::control::{Command, Measurement, PlateController};
use bracketry_plate::{PlateError, PlateKinematics};
use std::sync::Arc;

/// Samples of a cycle.
const SAMPLES: u32 = 80;
/// Sampling period in s.
const PERIOD: f64 = CYCLE / SAMPLES as f64;
/// Samples at rest that are waited for, and then averaged.
const SETTLE: usize = 10;
const LOOK: usize = 20;
/// Share of the tolerance within which the object is left alone.
const MARGIN: f64 = 0.6;
/// Length in m that an angle of 1 rad counts as in an error.
const LEVER: f64 = 0.1;
/// Share of what a burst missed by that the next one is corrected for.
const LEARNING: f64 = 0.8;
/// Error in m that a burst may leave when the shaking ends for it.
const RESIDUAL: f64 = 4e-3;

/// Moves position and orientation at the same time by shaking the plate with cycles whose mean drift leads to the target.
///
/// In every cycle the drift of the next one is chosen from a [`CycleMap`] so that the error that remains after ebbing away is
/// the least. Once a burst can make up for what will be left, the plate comes to rest; bursts then follow, each after a look
/// at the object at rest, until it is within the tolerance. What a burst did otherwise than the map said, as the friction is
/// another one, is reckoned with in the next. The cycles are made for the bounds of [`PlateLimits::default`](bracketry_plate::control::PlateLimits).
#[derive(Debug, Clone)]
pub struct AveragedController {
    map: Arc<CycleMap>,
    target: [f64; 3],
    tolerance: Tolerance,
    pipeline: Pipeline,
    phase: Phase,
    /// The last pose that was seen, for samples that are lost.
    seen: [f64; 3],
    /// The cycles of the last and of the present period.
    cycles: [Cycle; 2],
    /// Number of the sample in the cycle.
    sample: u32,
    /// Sum and number of the poses seen in this cycle.
    sum: [f64; 3],
    count: usize,
    /// What bursts do besides the displacement of the map.
    bias: [f64; 3],
    /// Where the last burst should have led.
    predicted: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// The plate rests.
    Look,
    /// The plate shakes on and on.
    Cruise,
    /// A burst swells.
    Burst,
    /// The shaking ebbs away.
    Ebb,
    /// Nothing is left to do.
    Finished,
}

impl AveragedController {
    /// The controller of a trial with the map of its object and of the assumed friction.
    pub fn new(map: Arc<CycleMap>, trial: &Trial, setup: &TrialSetup) -> Self {
        Self {
            map,
            target: trial.target,
            tolerance: setup.tolerance,
            pipeline: Pipeline::new(trial.delay, PERIOD),
            phase: Phase::Look,
            seen: trial.target,
            cycles: [Cycle::default(); 2],
            sample: 0,
            sum: [0.0; 3],
            count: 0,
            bias: [0.0; 3],
            predicted: None,
        }
    }

    /// Mean of the poses since the last call.
    fn mean(&mut self) -> [f64; 3] {
        let (sum, count) = (std::mem::take(&mut self.sum), std::mem::take(&mut self.count));
        if count == 0 { self.seen } else { sum.map(|s| s / count as f64) }
    }

    /// The drift of a row of the map that brings `pose` closest to the target within `time`, and the error that it leaves.
    fn best(&self, drifts: &Drifts, pose: [f64; 3], time: f64) -> ([f64; 3], f64) {
        let error = pose_error(pose, self.target);
        let left = |shares: [f64; 3]| {
            let drift = drifts.at(shares);
            let [x, y, phi]: [f64; 3] = std::array::from_fn(|i| error[i] + time * drift[i]);
            (x * x + y * y + (LEVER * phi).powi(2)).sqrt()
        };
        let mut best = ([0.0; 3], left([0.0; 3]));
        // The corners and the middle of the range, then ever smaller steps along each axis and diagonal.
        let mut step = 1.0;
        while step > 1e-3 {
            let from = best.0;
            for direction in 0..27 {
                let sign = |place: usize| (direction / place % 3) as f64 - 1.0;
                let shares = [0, 1, 2].map(|i| (from[i] + step * sign(3usize.pow(i as u32))).clamp(-1.0, 1.0));
                let value = left(shares);
                if value < best.1 {
                    best = (shares, value);
                }
            }
            if best.0 == from {
                step *= 0.5;
            }
        }
        best
    }

    /// The best burst from a pose at rest and the error that it leaves.
    fn best_burst(&self, pose: [f64; 3]) -> ([f64; 3], f64) {
        let drifts = self.map.drifts(Quantity::Burst, pose[1], pose[2]).shifted(self.bias);
        self.best(&drifts, pose, 1.0)
    }

    /// What is done in the cycle that begins now.
    fn decide(&mut self) {
        let pose = self.mean();
        let still = Cycle::default();
        let (phase, next) = match self.phase {
            Phase::Look => {
                if let Some(predicted) = self.predicted.take() {
                    (0..3).for_each(|i| self.bias[i] += LEARNING * (pose[i] - predicted[i]));
                }
                let error = pose_error(pose, self.target);
                let close =
                    Tolerance { position: MARGIN * self.tolerance.position, angle: MARGIN * self.tolerance.angle };
                if close.holds(error) == [true; 2] {
                    (Phase::Finished, still)
                } else {
                    let (burst, left) = self.best_burst(pose);
                    if left < RESIDUAL {
                        let displacement = self.map.burst(burst, pose[1], pose[2]);
                        self.predicted = Some(std::array::from_fn(|i| pose[i] + displacement[i] + self.bias[i]));
                        (Phase::Burst, Cycle::drifting(burst))
                    } else {
                        let velocity = self.map.drifts(Quantity::Velocity, pose[1], pose[2]);
                        (Phase::Cruise, Cycle::drifting(self.best(&velocity, pose, CYCLE).0))
                    }
                }
            }
            Phase::Cruise => {
                let velocity = self.map.drifts(Quantity::Velocity, pose[1], pose[2]);
                let [before, now] = self.cycles.map(|cycle| {
                    let v = velocity.at([cycle.asymmetry, cycle.slope, cycle.swing]);
                    v.map(|v| v * cycle.shake)
                });
                // The mean pose is that of the middle of the last cycle, in which the drift went over from one to the other.
                let here: [f64; 3] = std::array::from_fn(|i| pose[i] + CYCLE * (0.125 * before[i] + 0.375 * now[i]));
                // Ebbing away takes half a cycle's displacement more.
                let end: [f64; 3] = std::array::from_fn(|i| here[i] + 0.5 * CYCLE * now[i]);
                if self.best_burst(end).1 < RESIDUAL {
                    (Phase::Ebb, still)
                } else {
                    (Phase::Cruise, Cycle::drifting(self.best(&velocity, end, CYCLE).0))
                }
            }
            Phase::Burst => (Phase::Ebb, still),
            Phase::Ebb => (Phase::Look, still),
            Phase::Finished => (Phase::Finished, still),
        };
        self.phase = phase;
        self.cycles = [self.cycles[1], next];
        self.sample = 0;
    }
}

impl PlateController for AveragedController {
    fn period(&self) -> f64 {
        PERIOD
    }

    fn command(&mut self, measurement: &Measurement) -> Result<Command, PlateError> {
        let fresh = measurement.object.iter().all(|q| q.is_finite());
        if fresh {
            self.seen = measurement.object;
        }
        let plate = self.pipeline.predict(&measurement.plate);
        match self.phase {
            Phase::Look => {
                self.sample += 1;
                if fresh && self.sample as usize > SETTLE {
                    (0..3).for_each(|i| self.sum[i] += self.seen[i]);
                    self.count += 1;
                }
                if self.count == LOOK {
                    self.decide();
                }
            }
            Phase::Cruise | Phase::Burst | Phase::Ebb => {
                if fresh {
                    (0..3).for_each(|i| self.sum[i] += self.seen[i]);
                    self.count += 1;
                }
                if self.sample == SAMPLES {
                    self.decide();
                }
            }
            Phase::Finished => {}
        }
        let command = match self.phase {
            // The plate already rests but for rounding.
            Phase::Look | Phase::Finished => toward(&PlateKinematics::default(), &plate),
            _ => {
                self.sample += 1;
                let [before, now] = self.cycles;
                toward(&now.after(&before, PERIOD * f64::from(self.sample)), &plate)
            }
        };
        Ok(self.pipeline.send(command))
    }

    fn finished(&self) -> bool {
        self.phase == Phase::Finished
    }
}

/// The accelerations that give the plate the rates wanted at the end of the sample.
fn toward(wanted: &PlateKinematics, plate: &PlateKinematics) -> Command {
    Command {
        displacement_acceleration: (wanted.velocity - plate.velocity) / PERIOD,
        tilt_acceleration: (wanted.tilt_rate - plate.tilt_rate) / PERIOD,
    }
}
